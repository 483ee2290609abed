//! The paper's worked example: a chain of 20, 20 and 40 ms within 120 ms is due at 30, 60 and 120 ms.

use red_core::{Caps, Dag, DeadlineRule, Duration, Levels, Node, SubDeadlines, Wcet, shares};
use red_workload::Format;
use red_workload::plan::plan;

type Small = Caps<1, 4, 1>;

const DUE_MS: [u64; 3] = [30, 60, 120];

#[test]
fn the_core_assigns_30_60_and_120() {
    let mut chain = Dag::<Small>::new();
    let nodes = [20, 20, 40].map(|ms| chain.add_node(Node::new(Wcet::from_millis(ms))).unwrap());
    chain.add_edge(nodes[0], nodes[1]).unwrap();
    chain.add_edge(nodes[1], nodes[2]).unwrap();

    let deadline = Duration::from_millis(120);
    let levels = Levels::of(&chain);
    let due = SubDeadlines::assign(&levels, DeadlineRule::LevelSum, deadline, &[1]);
    assert_eq!(nodes.map(|node| due.sub_deadline(node)), DUE_MS.map(|ms| ms.cast_signed() * 1_000_000));

    let shares = shares(&levels, DeadlineRule::LevelSum, deadline, &[1]);
    let ends: Vec<u64> = (0..levels.count()).map(|height| shares[height].end).collect();
    assert_eq!(ends, DUE_MS.map(|ms| ms * 1_000_000));
}

#[test]
fn the_plan_shows_30_60_and_120() {
    let file = r#"
        [[pool]]
        name = "gpu"
        lanes = 1
        [[task]]
        name = "chain"
        deadline = "120ms"
        once = true
        node = [
          { name = "a", wcet = "20ms" },
          { name = "b", wcet = "20ms", after = ["a"] },
          { name = "c", wcet = "40ms", after = ["b"] } ]
    "#;
    let workload = red_workload::parse(file.as_bytes(), Format::Toml, "chain.toml").unwrap();
    let plan = plan::<Small>(&workload).unwrap();
    let task = &plan.tasks[0];
    let shares: Vec<u64> = task.levels.iter().map(|level| level.share_ns / 1_000_000).collect();
    assert_eq!(shares, [30, 30, 60]);
    let due: Vec<i64> = task.nodes.iter().map(|node| node.level_sum_ns).collect();
    assert_eq!(due, DUE_MS.map(|ms| ms.cast_signed() * 1_000_000));
    assert_eq!((task.work_ns, task.critical_path_ns), (80_000_000, 80_000_000));

    let reference = red_tests::plan::plan(&workload, &workload.tasks[0]);
    let due: Vec<u64> = reference.nodes.iter().map(|node| node.level_sum_ns / 1_000_000).collect();
    assert_eq!(due, DUE_MS);
}
