use super::held;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::RwLock;

#[test]
fn a_body_does_not_go_on_without_a_result_that_another_still_has() {
    let result = RwLock::new(1);
    assert_eq!(held(Some(result.try_read())).unwrap().as_deref(), Some(&1));
    let late = result.write().unwrap();
    assert!(held(Some(result.try_read())).is_err() && held(Some(result.try_write())).is_err());
    drop(late);
    let panics = || {
        let _held = result.write().unwrap();
        panic!("with the result");
    };
    assert!(catch_unwind(AssertUnwindSafe(panics)).is_err() && result.is_poisoned());
    assert_eq!(held(Some(result.try_write())).unwrap().as_deref(), Some(&1));
    assert!(held::<()>(None).unwrap().is_none());
}
