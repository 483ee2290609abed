use super::*;
use crate::interference::{Looked, Other};
use crate::set::Set;
use crate::shape::Shape;
use crate::world::{set, task};

/// What is looked at first of a set, and the others' shapes.
fn with<R>(set: &Set, bound: i128, of: impl Fn(Single<'_>) -> R) -> R {
    let shapes: Vec<Shape> = set.tasks.iter().map(|task| Shape::of(set, task)).collect();
    let part = |shape: &'_ Shape| shape.parts[0].clone().expect("it is here");
    let parts: Vec<_> = shapes.iter().map(part).collect();
    let others: Vec<Other<'_>> = (1..shapes.len())
        .map(|i| Other { shape: &shapes[i], part: &parts[i], bound: shapes[i].deadline })
        .collect();
    let lanes = set.clusters[0].lanes.into();
    let looked = Looked { shape: &shapes[0], others: &others, lanes };
    of(Single { looked, part: &parts[0], bound })
}

#[test]
fn a_chain_alone_takes_as_long_as_it_is() {
    let set = set(1, vec![task("chain", 50, Some(50), &[3, 4], &[(0, 1)])]);
    with(&set, 50, |single| {
        assert_eq!(single.a0(Keys::Key, Variant::B, 50), Some(7));
        assert_eq!(single.prefix(Keys::Key, Variant::B, 50).map(|(response, _)| response), Some(7));
    });
}

#[test]
fn a_lower_node_that_began_before_blocks_for_all_but_a_moment() {
    // 3 of its own, and the other's 10 but for the nanosecond in which it began.
    let high = task("high", 20, Some(1_000), &[3], &[]);
    let low = task("low", 1_000, Some(1_000), &[10], &[]);
    with(&set(1, vec![high, low]), 20, |single| {
        assert_eq!(single.prefix(Keys::Key, Variant::B, 20).map(|(response, _)| response), Some(13));
    });
}

#[test]
fn other_jobs_of_the_task_count_where_deadlines_exceed_periods() {
    let set = set(1, vec![task("often", 25, Some(10), &[8], &[])]);
    with(&set, 25, |single| {
        assert!(single.a0(Keys::Key, Variant::B, 25) >= Some(16), "the one before may not have begun yet");
    });
}
