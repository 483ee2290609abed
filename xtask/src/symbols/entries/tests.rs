use super::*;

#[test]
fn a_public_function_is_named_by_its_type() {
    let text = "impl<C: Capacity, L: Exclusive<Scheduler<C>>, const P: usize> Shared<C, L, P> {
    pub fn with<R>(&self) {}
    pub const fn len(&self) {}
            pub const fn of_a_macro(&self) {}
        pub fn of_another(&self) {}
    pub(crate) fn hidden(&self) {}
    fn own(&self) {}
}

impl<const DEPTH: usize> Requests<'_, DEPTH> {
    pub fn next(&mut self) {}
}

pub fn free<C>() {}
";
    let names: Vec<_> = public_functions(text).iter().map(ToString::to_string).collect();
    assert_eq!(names, ["Shared_with", "Shared_len", "Shared_of_another", "Requests_next", "free"]);
}

#[test]
fn an_entry_is_found_under_any_capacity_and_only_whole() {
    let symbols = BTreeSet::from(["red_small_Dag_len".to_owned()]);
    assert!(Entry("Dag_len".into()).is_in(&symbols));
    assert!(!Entry("len".into()).is_in(&symbols) && !Entry("Dag_le".into()).is_in(&symbols));
}
