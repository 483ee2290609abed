use super::super::tests::independent;
use super::*;
use crate::fixtures::{EXAMPLE_TOML, accepted};

const MS: u64 = 1_000_000;

#[test]
fn times_are_printed_whole() {
    let stretch = Stretch {
        task: "t".to_owned(),
        deadline_ns: Some(printed_above(12_000_001)),
        period_ns: Some(printed_above(1_000_000_001)),
    };
    assert_eq!(Cure::Times(vec![stretch]).to_string(), "task `t`: deadline 12.001 ms and period 1.001 s");
    assert_eq!((printed_below(12_000_999), printed_below(999_999)), (12_000_000, 999_999));
}

#[test]
fn a_change_is_made_where_it_says() {
    let workload = independent(1, &[(12, 10, 20), (3, 10, 20)]);
    let stretch = Stretch { task: "t1".to_owned(), deadline_ns: Some(11 * MS), period_ns: None };
    let changed = Cure::Times(vec![stretch]).applied(&workload, Rounding::Up);
    assert_eq!(changed, independent(1, &[(12, 10, 20), (3, 11, 20)]));
    assert_eq!(
        Cure::Pace(2_000).applied(&workload, Rounding::Up),
        independent(1, &[(12, 20, 40), (3, 20, 40)])
    );
    assert_eq!(
        Cure::Periods(500).applied(&workload, Rounding::Up),
        independent(1, &[(12, 10, 10), (3, 10, 10)])
    );
    let lanes = Cure::Lanes { pool: "gpu".to_owned(), lanes: 3, of: 3 };
    assert_eq!(lanes.applied(&workload, Rounding::Up), independent(3, &[(12, 10, 20), (3, 10, 20)]));
}

#[test]
fn costs_shrink_in_stages_and_events_and_with_their_best_cases() {
    let workload = accepted(EXAMPLE_TOML);
    let half = Cure::Costs(500).applied(&workload, Rounding::Up);
    let parts = half.tasks[0].nodes.iter().chain(&half.events[0].add).flat_map(|node| node.parts());
    let costs: Vec<(u64, u64, u64)> =
        parts.map(|(_, part)| (part.wcet_ns, part.bcet_ns, part.contention_ns)).collect();
    let ms = |n: u64| n * MS / 2;
    assert_eq!(
        costs,
        [(ms(2), ms(1), 0), (ms(12), 0, 0), (ms(4), 0, 0), (ms(6), 0, 0), (ms(3), 0, ms(1)), (ms(9), 0, 0)]
    );
    let task = "cruise".to_owned();
    let camera = Cure::Node { task: task.clone(), node: "camera".to_owned(), wcet_ns: 500 };
    assert_eq!(camera.to_string(), "task `cruise`, node `camera`: wcet 500 ns");
    let changed = camera.applied(&workload, Rounding::Up);
    let (_, part) = changed.tasks[0].nodes[0].parts()[0];
    assert_eq!((part.wcet_ns, part.bcet_ns), (500, 500));
    let lane = Cure::Node { task, node: "perception.lane".to_owned(), wcet_ns: 1 };
    let changed = lane.applied(&workload, Rounding::Up);
    assert_eq!(changed.tasks[0].nodes[1].parts()[1].1.wcet_ns, 1);
}

#[test]
fn lanes_of_a_cluster_are_lanes_of_its_pool_too() {
    let cure = Cure::Lanes { pool: "gpu.near".to_owned(), lanes: 2, of: 5 };
    assert_eq!(cure.to_string(), "pool `gpu`: 5 lanes, 2 of them in cluster `near`");
}
