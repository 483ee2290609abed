use super::*;
use crate::Caps;

/// A node that has to start by an instant.
const fn node(key: i64, cost: u64, outranks: bool) -> Soon {
    Soon { key, at: 0, cost, outranks, memory: 0, nth: 0 }
}

/// What several of a higher rank take together leaves no time, though each of them could still start.
#[test]
fn a_head_leaves_time_for_all_that_are_due_before() {
    let (first, last, later) = (node(6, 2, true), node(7, 3, true), node(9, 3, true));
    let leaves_none = |head, free| {
        let mut coming = Coming::<Caps<1, 4, 4>>::new(node(0, head, false));
        [first, last, later].into_iter().for_each(|node| coming.meet(node));
        coming.leave_no_time(&last, free)
    };
    // 5 ns of these are due by 10.
    assert_eq!(
        [(4, 1), (5, 1), (5, 0), (6, 0), (6, 5), (6, 6)].map(|(head, free)| leaves_none(head, free)),
        [false, true, false, true, true, false]
    );
}

#[test]
fn what_is_no_higher_is_left_no_time() {
    let own = node(7, 3, false);
    let mut coming = Coming::<Caps<1, 4, 4>>::new(node(0, 9, false));
    coming.meet(own);
    assert!(!coming.leave_no_time(&own, 1));
}
