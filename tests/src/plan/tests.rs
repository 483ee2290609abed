use super::*;
use crate::fixtures::{MS, every, node, once, part, workload, written};
use red_workload::model::{Node, Work, Workload};

fn planned(lanes: u32, deadline_ms: u64, nodes: Vec<Node>) -> TaskPlan {
    let workload = workload(lanes, vec![once("t", deadline_ms, nodes)]);
    plan(&workload, &workload.tasks[0])
}

fn chain() -> Vec<Node> {
    vec![node("a", 20, &[]), node("b", 20, &["a"]), node("c", 40, &["b"])]
}

#[test]
fn the_papers_chain_is_due_at_30_60_120() {
    let plan = planned(1, 120, chain());
    let due: Vec<u64> = plan.nodes.iter().map(|node| node.level_sum_ns / MS).collect();
    assert_eq!(due, [30, 60, 120]);
    let shares: Vec<u64> = plan.levels.iter().map(|level| level.share_ns / MS).collect();
    assert_eq!(shares, [30, 30, 60]);
    let starts: Vec<i128> = plan.nodes.iter().map(|node| node.latest_start_ns / i128::from(MS)).collect();
    assert_eq!(starts, [40, 60, 80]);
    let finishes: Vec<i128> = plan.nodes.iter().map(|node| node.latest_finish_ns / i128::from(MS)).collect();
    assert_eq!(finishes, [60, 80, 120]);
    let proportional: Vec<u64> = plan.nodes.iter().map(|node| node.path_proportional_ns / MS).collect();
    assert_eq!(proportional, [30, 60, 120]);
    assert_eq!((plan.work_ns, plan.critical_path_ns, plan.graham_ns), (80 * MS, 80 * MS, 80 * MS));
    assert!(plan.levels_fit);
}

#[test]
fn latest_starts_go_below_zero_when_the_deadline_is_too_short() {
    let plan = planned(1, 50, chain());
    let starts: Vec<i128> = plan.nodes.iter().map(|node| node.latest_start_ns / i128::from(MS)).collect();
    assert_eq!(starts, [-30, -10, 10]);
    assert!(!plan.levels_fit);
}

#[test]
fn shares_lose_nothing_to_rounding() {
    assert_eq!(level_offsets(&[1, 1, 1], 100), [33, 66, 100]);
    assert_eq!(level_offsets(&[0, 0], 7), [3, 7]);
    assert_eq!(level_offsets(&[5, 0, 0], 7), [7, 7, 7]);
}

#[test]
fn graham_weights_of_two_lanes() {
    // Level 0: 4 alone, g 4, w 8. Level 1: 2, 1, 1: g 2 + 1 = 3, w 4 + 2 = 6. Sum of g 7, spare 21.
    let nodes = vec![node("a", 4, &[]), node("b", 2, &["a"]), node("c", 1, &["a"]), node("d", 1, &["a"])];
    let plan = planned(2, 28, nodes.clone());
    let bounds: Vec<u64> = plan.levels.iter().map(|level| level.graham_ns / MS).collect();
    assert_eq!(bounds, [4, 3]);
    let due: Vec<u64> = plan.nodes.iter().map(|node| node.level_graham_ns / MS).collect();
    assert_eq!(due, [16, 28, 28, 28]);
    // Six are fewer than seven: split by weight alone, 6 * 8 / 14.
    let tight = planned(2, 6, nodes);
    assert_eq!(tight.nodes[0].level_graham_ns, 6 * MS * 8 / 14);
    assert_eq!(tight.nodes[1].level_graham_ns, 6 * MS);
}

#[test]
fn the_long_path_bound_peels_paths() {
    // Two chains of 6 and 4: L 6, W 10. Graham 6 + 4/2 = 8; with both chains peeled 6 + 0.
    let nodes = vec![node("a", 6, &[]), node("b", 4, &[])];
    let plan = planned(2, 100, nodes);
    assert_eq!((plan.graham_ns / MS, plan.long_path_ns), (8, Some(6 * MS)));
}

fn two_pools() -> Workload {
    let mut both = workload(2, vec![]);
    let mut cpu = both.pools[0].clone();
    (cpu.name, cpu.lanes) = ("cpu".to_owned(), 4);
    both.pools.push(cpu);
    let far = written("far", &["near"], Work::Plain(red_workload::model::Part { pool: 1, ..part(9) }));
    both.tasks.push(every(once("t", 100, vec![node("near", 8, &[]), far]), 60));
    both
}

#[test]
fn several_pools_take_the_larger_bound() {
    let both = two_pools();
    let plan = plan(&both, &both.tasks[0]);
    // floor(3/4 * 17 ms) + 1 + 8/2 + ceil(9/4).
    assert_eq!(plan.graham_ns, 12_750_000 + 1 + 4 * MS + 2_250_000);
    assert_eq!(plan.long_path_ns, None);
    assert_eq!(plan.limit_ns, 60 * MS);
    // g = w = 8 and 9; spare 83: 8 + 83 * 8 / 17.
    assert_eq!(plan.nodes[0].level_graham_ns, 8 * MS + 83 * MS * 8 / 17);
}
