use super::*;
use crate::interference::{Looked, Other};
use crate::member::Member;
use crate::world::{set, task};
use red_certificate::Set;

/// What is looked at first of a set, and the others' shapes.
fn with<R>(set: &Set, bound: i128, of: impl Fn(Single<'_>) -> R) -> R {
    let members: Vec<Member> = set.tasks.iter().map(|task| Member::of(&set.clusters, task)).collect();
    let other =
        |member: &'_ Member, bound| (member.period, member.parts[0].clone().expect("it is here"), bound);
    let parts: Vec<_> = members.iter().map(|member| other(member, member.deadline)).collect();
    let other = |(period, part, bound)| Other { period, part, bound };
    let others: Vec<Other<'_>> =
        parts[1..].iter().map(|(period, part, bound)| other((*period, part, *bound))).collect();
    let (lanes, shape) = (set.clusters[0].lanes.into(), &members[0].shapes[0]);
    let looked = Looked { shape, others: &others, lanes };
    of(Single { looked, part: &parts[0].1, this: other((parts[0].0, &parts[0].1, bound)) })
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
