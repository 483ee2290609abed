use super::*;
use red_core::Instant;
use red_workload::metrics::{Judged, TaskLog, summarise};

/// A task some of whose jobs were given up.
fn task(name: &str, given_up: &[(&'static str, u64)]) -> TaskMetrics {
    let judged = Judged { name, value: 1, floor: None };
    let none = summarise(judged, &TaskLog::default(), Instant::ZERO, Instant::ZERO);
    TaskMetrics { given_up: given_up.iter().copied().collect(), ..none }
}

#[test]
fn reasons_are_counted_and_explained_once() {
    let (full, none, late) =
        (task("a", &[("hopeless", 1), ("full", 2)]), task("b", &[]), task("c", &[("full", 1)]));
    assert_eq!(
        (list(&full.given_up), list(&none.given_up)),
        ("full 2, hopeless 1".to_owned(), "-".to_owned())
    );
    assert_eq!(
        by_task(&[full, none.clone(), late]),
        "  a gave up: full 2, hopeless 1\n  c gave up: full 1\n  full: no place for a 65th job\n  \
         hopeless: not even its best case could end by the deadline"
    );
    assert_eq!(by_task(&[none]), "");
}
