//! Sub-deadlines: shares add up to D, nobody is due before a predecessor, and levels end in order.

use proptest::prelude::*;
use red_core::{Capacity, Dag, DeadlineRule, Duration, LevelShare, Levels, NodeId, SubDeadlines, shares};

use super::cases;
use super::graphs::{Wide, edges, random_graph};

/// Deadlines from 1 ns to the longest that a task may have.
fn deadline() -> impl Strategy<Value = u64> {
    prop_oneof![1u64..100, 1u64..1_000_000_000, 1u64..=1 << 62]
}

fn level_shares(dag: &Dag<Wide>, rule: DeadlineRule, d: u64, lanes: &[u8]) -> Vec<LevelShare> {
    let levels = Levels::of(dag);
    let shares = shares(&levels, rule, Duration::from_nanos(d), lanes);
    shares.as_ref()[..levels.count()].to_vec()
}

fn assigned<C: Capacity>(dag: &Dag<C>, rule: DeadlineRule, d: u64) -> SubDeadlines<C> {
    SubDeadlines::assign(&Levels::of(dag), rule, Duration::from_nanos(d), &[2, 3])
}

fn cost<C: Capacity>(dag: &Dag<C>, node: NodeId) -> i128 {
    dag.node(node).map_or(0, |node| node.cost().into())
}

proptest! {
    #![proptest_config(cases(512))]

    #[test]
    fn level_shares_add_up_to_d_and_levels_end_in_order(
        seed: u64, d in deadline(), lanes in 1u8..=8, pools in 1u64..=2
    ) {
        let dag = random_graph::<Wide>(seed, pools);
        let levels = Levels::of(&dag);
        for rule in [DeadlineRule::LevelSum, DeadlineRule::LevelGraham] {
            let shares = level_shares(&dag, rule, d, &[lanes; 2]);
            let total: u128 = shares.iter().map(|level| u128::from(level.share)).sum();
            prop_assert_eq!(total, u128::from(d));
            prop_assert_eq!(shares[shares.len() - 1].end, d);
            prop_assert!(shares.is_sorted_by_key(|level| level.end));
            let due = SubDeadlines::assign(&levels, rule, Duration::from_nanos(d), &[lanes; 2]);
            for node in dag.nodes() {
                prop_assert_eq!(due.sub_deadline(node), shares[levels.height(node)].end.cast_signed());
            }
        }
    }

    #[test]
    fn a_level_sum_share_is_within_a_nanosecond_of_exact(seed: u64, d in deadline()) {
        let dag = random_graph::<Wide>(seed, 1);
        let shares = level_shares(&dag, DeadlineRule::LevelSum, d, &[1]);
        let work = u128::from(dag.work());
        for level in &shares {
            // Both sides times the work; without any, every level weighs the same.
            let (exact, unit) = if work == 0 {
                (u128::from(d), shares.len() as u128)
            } else {
                (u128::from(d) * u128::from(level.cost), work)
            };
            prop_assert!(exact.abs_diff(u128::from(level.share) * unit) < unit);
        }
    }

    #[test]
    fn level_graham_covers_the_bound_of_each_level_where_all_of_them_fit(
        seed: u64, slack in 0u64..1_000_000, lanes in 1u8..=8, pools in 1u64..=2
    ) {
        let dag = random_graph::<Wide>(seed, pools);
        let at = |d| level_shares(&dag, DeadlineRule::LevelGraham, d, &[lanes; 2]);
        let any = at(1);
        let bounds: u128 = any.iter().map(|level| u128::from(level.graham)).sum();
        prop_assume!(bounds > 0 && bounds < 1 << 62);
        let fitting = at(bounds as u64 + slack);
        prop_assert!(fitting.iter().all(|level| level.share >= level.graham));
        let tight = at(bounds as u64 - 1);
        prop_assert!(tight.iter().any(|level| level.share < level.graham));
    }

    #[test]
    fn latest_finish_leaves_every_successor_its_cost(seed: u64, d in deadline()) {
        let dag = random_graph::<Wide>(seed, 2);
        let finish = assigned(&dag, DeadlineRule::LatestFinish, d);
        let start = assigned(&dag, DeadlineRule::LatestStart, d);
        for (from, to) in edges(&dag) {
            let gap = i128::from(finish.sub_deadline(to)) - i128::from(finish.sub_deadline(from));
            prop_assert!(gap >= cost(&dag, to));
            prop_assert!(i128::from(start.key(from)) + cost(&dag, from) <= start.key(to).into());
        }
        for node in dag.nodes() {
            prop_assert_eq!(start.sub_deadline(node), finish.sub_deadline(node));
            prop_assert_eq!(i128::from(start.key(node)), i128::from(start.sub_deadline(node)) - cost(&dag, node));
            if dag.successors(node).is_empty() {
                prop_assert_eq!(finish.sub_deadline(node), d.cast_signed());
            }
        }
        // The most pressing node must start at D less the critical path: feasible iff that is not below 0.
        let first = dag.nodes().map(|node| i128::from(start.key(node))).min();
        let longest = Levels::of(&dag).critical_path();
        prop_assert_eq!(first, Some(i128::from(d) - i128::from(longest)));
    }

    #[test]
    fn path_proportional_is_monotone_and_ends_at_d(seed: u64, d in deadline()) {
        let dag = random_graph::<Wide>(seed, 2);
        let due = assigned(&dag, DeadlineRule::PathProportional, d);
        for (from, to) in edges(&dag) {
            prop_assert!(due.sub_deadline(from) <= due.sub_deadline(to) || cost(&dag, to) == 0);
        }
        for node in dag.nodes() {
            prop_assert!((0..=d.cast_signed()).contains(&due.sub_deadline(node)));
            if dag.successors(node).is_empty() {
                prop_assert_eq!(due.sub_deadline(node), d.cast_signed());
            }
        }
    }

    #[test]
    fn end_to_end_is_d_for_every_node(seed: u64, d in deadline()) {
        let dag = random_graph::<Wide>(seed, 2);
        let due = assigned(&dag, DeadlineRule::EndToEnd, d);
        prop_assert!(dag.nodes().all(|node| due.key(node) == d.cast_signed()));
    }
}
