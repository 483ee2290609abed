//! Errors of the paper's theory, as counterexamples: sections 3.4 to 3.6.

use crate::counterexamples::{Graph, dag, edf_by_sub_deadline, level_gated, list_makespan};
use red_core::{DeadlineRule, Duration, Levels, NodeId, SubDeadlines, response_time, shares};

const fn ns(time: u64) -> Duration {
    Duration::from_nanos(time)
}

#[test]
fn condition_ii_is_one_test_of_all_levels_together() {
    // Shares are proportional to costs, so S_h / rho <= D^(h) is W / rho <= D at every level, however unlike they are.
    let graph = dag(&[7_000, 1_000, 1_000, 3_000, 40_000], &[(0, 1), (0, 2), (1, 3), (2, 3), (3, 4)]);
    let levels = Levels::of(&graph);
    for (deadline, holds) in [(26_000, true), (25_000, false)] {
        let shares = shares(&levels, DeadlineRule::LevelSum, ns(deadline), &[2]);
        assert_eq!(graph.work() <= 2 * deadline, holds);
        assert!((0..levels.count()).all(|h| (shares[h].cost <= 2 * shares[h].share) == holds), "{deadline}");
    }
}

#[test]
fn condition_ii_admits_what_no_schedule_can_finish() {
    // Four lanes, one node of 4 before twelve of 1, D = 4.
    let costs = [4, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1];
    let graph = dag(&costs, &(1..13).map(|leaf| (0, leaf)).collect::<Vec<_>>());
    let levels = Levels::of(&graph);
    let shares = shares(&levels, DeadlineRule::LevelSum, ns(4), &[4]);
    assert!((0..2).all(|h| shares[h].cost <= 4 * shares[h].share), "condition (ii) holds at every level");
    assert_eq!(levels.critical_path(), 5, "and the longest path alone is past the deadline");
    assert!(!response_time(&levels, ns(4), &[4], &[None]).fits());
}

#[test]
fn condition_ii_is_not_sufficient_even_where_the_path_fits() {
    // W = 12 on two lanes and L = 6 within D = 6: condition (ii) holds with equality.
    let graph = dag(&[1, 5, 1, 1, 1, 3], &[(0, 1), (2, 3), (3, 4), (4, 5)]);
    let levels = Levels::of(&graph);
    assert!(graph.work() <= 2 * 6 && levels.critical_path() <= 6);
    assert_eq!(level_gated(&graph, 2), 10, "level by level, as the proof has it");
    assert_eq!(list_makespan(&graph, 2), 6, "whoever gates by precedence makes it");
}

#[test]
fn edf_by_sub_deadlines_misses_them_within_condition_ii() {
    // The remark after Proposition 1: on two lanes no such bound exists without the longest node, here one of ten.
    let graph = dag(&[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 10], &[]);
    let due = SubDeadlines::assign(&Levels::of(&graph), DeadlineRule::LevelSum, ns(10), &[2]);
    assert!(graph.work() <= 2 * 10 && graph.nodes().all(|node| due.sub_deadline(node) == 10));
    assert_eq!(
        edf_by_sub_deadline(&graph, &due, 2).iter().max(),
        Some(&15),
        "all are due at 10, the long one was last"
    );
}

#[test]
fn refinement_can_break_a_siblings_sub_deadline() {
    // Proposition 2. Two lanes, D = 12: u = 10 beside a stage v = 10, both before a sink of 2.
    let before = dag(&[10, 10, 2], &[(0, 2), (1, 2)]);
    let after = dag(&[10, 5, 5, 2], &[(0, 3), (1, 2), (2, 3)]);
    let share = |graph: &Graph| shares(&Levels::of(graph), DeadlineRule::LevelSum, ns(12_000), &[2])[0].share;
    assert!(share(&before) >= 10_000, "u fits its level's share of {}", share(&before));
    assert!(share(&after) < 10_000, "and not after its sibling was refined: {}", share(&after));
    assert_eq!(
        (list_makespan(&before, 2), list_makespan(&after, 2)),
        (12, 12),
        "though nothing takes longer"
    );
    let latest =
        |graph: &Graph| SubDeadlines::assign(&Levels::of(graph), DeadlineRule::LatestFinish, ns(12), &[2]);
    let u = before.nodes().next().expect("u");
    assert_eq!(
        latest(&before).sub_deadline(u),
        latest(&after).sub_deadline(u),
        "a path's deadline is its own"
    );
}

#[test]
fn refinement_does_not_shift_every_height_by_one() {
    // The proof of Proposition 2. A chain a - b - c - d beside a stage v, refined into encoder and decoder, before d.
    let before = dag(&[1; 5], &[(0, 1), (1, 2), (2, 3), (4, 3)]);
    let after = dag(&[1; 6], &[(0, 1), (1, 2), (2, 3), (4, 5), (5, 3)]);
    let height = |graph: &Graph| Levels::of(graph).height(NodeId::new(3));
    assert_eq!((height(&before), height(&after)), (3, 3), "v is not on the longest way to d");
}

#[test]
fn shares_that_are_rounded_level_by_level_lose_time() {
    let graph = dag(&[1, 1, 1], &[(0, 1), (1, 2)]);
    let levels = Levels::of(&graph);
    let floored: u64 = (0..3).map(|_| 100 / 3).sum();
    let exact = shares(&levels, DeadlineRule::LevelSum, ns(100), &[1]);
    assert_eq!(floored, 99, "a nanosecond is gone");
    assert_eq!(exact[2].end, 100, "rounding the prefix keeps it");
    assert_eq!((0..3).map(|h| exact[h].share).sum::<u64>(), 100);
}

#[test]
fn level_gating_costs_more_than_precedence() {
    // Lemma 1 lets a level wait for the one before it. Two chains of 1, 9 and 9, 1 need 10 and get 18.
    let graph = dag(&[1, 9, 9, 1], &[(0, 1), (2, 3)]);
    assert_eq!((list_makespan(&graph, 2), level_gated(&graph, 2)), (10, 18));
}
