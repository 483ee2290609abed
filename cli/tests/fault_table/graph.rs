//! Rows 1 to 11: graphs and capacities.

use crate::virtual_time::{MS, Small, at, chain, cost, drain, due, one_task, poll, runs_through};
use red_core::{
    AddTaskError, Caps, CommitError, Config, Dag, DeadlineRule, Duration, EdgeError, Frame, Levels, Node,
    NodeError, NodeId, ReadyQueue, RefineError, ReleaseError, Scheduler, SubDeadlines, Table, Wcet, refine,
};

fn nodes<const N: usize>() -> [NodeId; N] {
    std::array::from_fn(|i| NodeId::new(i as u8))
}

/// A running task, and a graph of it to spoil.
fn edited() -> (Box<Scheduler<Small>>, red_core::TaskId, Dag<Small>) {
    let (scheduler, task) = one_task(Config::REDRT, &chain(&[1, 1, 1, 1]), due(100));
    let edit = scheduler.edit(task).expect("it is admitted");
    (scheduler, task, edit)
}

#[test]
fn row_01_a_cycle_is_refused_and_the_old_graph_runs() {
    let (mut scheduler, task, mut edit) = edited();
    let before = format!("{edit:?}");
    // Back over one, two and three edges.
    for (from, to) in [(1, 0), (2, 0), (3, 0), (3, 1)] {
        assert_eq!(edit.add_edge(NodeId::new(from), NodeId::new(to)), Err(EdgeError::Cycle));
    }
    assert_eq!(format!("{edit:?}"), before);
    let _still_a_graph = scheduler.commit(&edit, at(0)).expect("what is left of the edit is the old graph");
    assert_eq!(runs_through(&mut scheduler, task, at(1)), nodes::<4>());
}

#[test]
fn row_02_a_self_edge_is_refused() {
    let (_, _, mut edit) = edited();
    let before = format!("{edit:?}");
    for node in nodes::<4>() {
        assert_eq!(edit.add_edge(node, node), Err(EdgeError::Cycle));
    }
    assert_eq!(format!("{edit:?}"), before);
}

#[test]
fn row_03_a_duplicate_edge_is_refused() {
    let (mut scheduler, task, mut edit) = edited();
    let before = format!("{edit:?}");
    let [a, b, ..] = nodes::<4>();
    assert_eq!(edit.add_edge(a, b), Err(EdgeError::Duplicate));
    assert_eq!(format!("{edit:?}"), before);
    // Counted twice, its end would wait for ever.
    let _taken = scheduler.commit(&edit, at(0)).expect("the graph is the old one");
    runs_through(&mut scheduler, task, at(1));
}

#[test]
fn row_04_an_edge_to_an_unknown_or_removed_node_is_refused() {
    let (mut scheduler, task, mut edit) = edited();
    let [a, b, c, d] = nodes::<4>();
    assert!(edit.remove_node(c));
    let before = format!("{edit:?}");
    for unknown in [c, NodeId::new(7), NodeId::new(8), NodeId::new(255)] {
        assert_eq!(edit.add_edge(a, unknown), Err(EdgeError::UnknownNode));
        assert_eq!(edit.add_edge(unknown, a), Err(EdgeError::UnknownNode));
    }
    assert_eq!(format!("{edit:?}"), before);
    let _taken = scheduler.commit(&edit, at(0)).expect("three nodes");
    let mut ran = runs_through(&mut scheduler, task, at(1));
    ran.sort();
    assert_eq!(ran, [a, b, d]);
}

#[test]
fn row_05_an_empty_graph_is_refused_when_it_is_admitted_or_committed() {
    let (mut scheduler, task, mut edit) = edited();
    assert_eq!(scheduler.add_task(&Dag::new(), due(1)), Err(AddTaskError::Empty));
    // A graph without a sink has no node: every acyclic one ends somewhere.
    for node in nodes::<4>() {
        assert!(edit.nodes().any(|n| edit.successors(n).is_empty()), "a sink");
        assert!(edit.remove_node(node));
    }
    assert_eq!(scheduler.commit(&edit, at(0)), Err(CommitError::Empty));
    assert_eq!(runs_through(&mut scheduler, task, at(1)), nodes::<4>());
}

#[test]
fn row_06_one_node_more_than_the_capacity_is_refused() {
    let mut dag = chain::<Small>(&[1; 8]);
    let before = format!("{dag:?}");
    // The node is `Copy` and was only lent: its owner has it still.
    let surplus = cost(3);
    assert_eq!(dag.add_node(surplus), Err(NodeError::Full));
    assert_eq!(surplus.wcet(), Wcet::from_millis(3));
    assert_eq!(format!("{dag:?}"), before);
    let (mut scheduler, task) = one_task(Config::REDRT, &dag, due(100));
    assert_eq!(runs_through(&mut scheduler, task, at(0)), nodes::<8>());
}

#[test]
fn row_07_edges_have_no_capacity_of_their_own_and_a_refused_one_leaves_no_half() {
    // Every edge that eight nodes can have, and then each once more.
    let mut dag = Dag::<Small>::new();
    let all: [NodeId; 8] = std::array::from_fn(|_| dag.add_node(cost(1)).expect("eight fit"));
    let pairs = || (0..8).flat_map(|from| (from + 1..8).map(move |to| (from, to)));
    pairs().for_each(|(from, to)| assert_eq!(dag.add_edge(all[from], all[to]), Ok(())));
    let before = format!("{dag:?}");
    for (from, to) in pairs() {
        assert_eq!(dag.add_edge(all[from], all[to]), Err(EdgeError::Duplicate));
        assert_eq!(dag.add_edge(all[to], all[from]), Err(EdgeError::Cycle));
    }
    assert_eq!(format!("{dag:?}"), before);
    // Half an edge would be a predecessor that never ends, or a node that starts too early.
    let (mut scheduler, task) = one_task(Config::REDRT, &dag, due(100));
    assert_eq!(runs_through(&mut scheduler, task, at(0)), all);
}

#[test]
fn row_08_the_ready_heap_has_room_for_every_job_and_one_job_more_is_refused() {
    let mut queue = ReadyQueue::<u64, Table<u64, 4>, Table<u16, 4>>::new();
    (0..4).for_each(|slot| queue.push(slot, 9 - slot as u64));
    // An entry a slot: what is queued already moves instead of growing.
    queue.push(2, 0);
    assert_eq!((queue.len(), queue.pop()), (4, Some((2, 0))));

    let (mut scheduler, task) = one_task::<Small>(Config::EDF, &chain(&[1, 1]), due(1_000));
    let jobs: Vec<_> = (0..4).map(|_| scheduler.release(task, at(0)).expect("four fit")).collect();
    assert_eq!(scheduler.release(task, at(0)), Err(ReleaseError::Full));
    let (order, ended) = drain(&mut scheduler, at(0));
    assert_eq!(order.len(), 8);
    assert!(jobs.iter().all(|job| ended.iter().any(|end| end.job == *job && end.on_time())), "{ended:?}");
}

#[test]
fn row_09_a_full_event_ring_drops_the_newest_and_counts_them_exactly() {
    /// A record of four events.
    type Four = Caps<1, 2, 4, 1, 1, 1, 4>;
    let run = |takes: bool| {
        let (mut scheduler, task) = one_task::<Four>(Config::EDF, &chain(&[1, 1]), due(1_000));
        let mut taken = Vec::new();
        for ms in [0, 10, 20] {
            scheduler.release(task, at(ms)).expect("there is room");
            let mut now = at(ms);
            loop {
                if takes {
                    taken.extend(std::iter::from_fn(|| scheduler.take_event().copied()));
                }
                let (starts, _) = poll(&mut scheduler, now);
                if takes {
                    taken.extend(std::iter::from_fn(|| scheduler.take_event().copied()));
                }
                let [start] = starts[..] else { break };
                now = now.saturating_add(Duration::from_millis(1));
                scheduler.complete(start.unit, now).expect("it runs");
            }
        }
        taken.extend(std::iter::from_fn(|| scheduler.take_event().copied()));
        (taken, scheduler.events_dropped())
    };
    let ((all, none), (kept, dropped)) = (run(true), run(false));
    assert_eq!(none, 0);
    assert_eq!(kept, all[..4], "a gapless beginning");
    assert_eq!(dropped, all.len() as u64 - 4);
}

#[test]
fn row_10_disconnected_parts_the_deepest_chain_and_the_widest_level_run() {
    let parts = {
        let mut dag = chain::<Small>(&[1, 1, 1]);
        let (lonely, apart) = (dag.add_node(cost(1)).expect("room"), dag.add_node(cost(1)).expect("room"));
        let end = dag.add_node(cost(1)).expect("room");
        dag.add_edge(apart, end).expect("no cycle");
        assert!(dag.successors(lonely).is_empty());
        dag
    };
    let wide = {
        let mut dag = Dag::<Small>::new();
        (0..8).for_each(|_| assert!(dag.add_node(cost(1)).is_ok()));
        dag
    };
    for (dag, levels, path_ms) in [(parts, 3, 3), (chain(&[1; 8]), 8, 8), (wide, 1, 1)] {
        let of = Levels::of(&dag);
        assert_eq!((of.count(), of.critical_path()), (levels, path_ms * MS));
        for rule in [DeadlineRule::LevelSum, DeadlineRule::LevelGraham, DeadlineRule::PathProportional] {
            let assigned = SubDeadlines::assign(&of, rule, Duration::from_millis(100), &[2]);
            let last = dag.nodes().map(|node| assigned.sub_deadline(node)).max();
            assert_eq!(last, Some(100 * MS as i64), "{rule:?}");
        }
        for config in [Config::EDF, Config::RED_FG, Config::RED, Config::REDRT] {
            let (mut scheduler, task) = one_task(config.with_lanes(2), &dag, due(100));
            let mut ran = runs_through(&mut scheduler, task, at(0));
            ran.sort();
            assert_eq!(ran, dag.nodes().collect::<Vec<_>>(), "each node once");
        }
    }
}

#[test]
fn row_11_a_refinement_beyond_the_capacity_is_refused_and_the_unrefined_graph_runs() {
    let dag = chain::<Small>(&[1, 6, 1]);
    let before = format!("{dag:?}");
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let (encoder, decoder) =
        (Node::shared_encoder(Wcet::from_millis(2), frame), Node::decoder(Wcet::from_millis(1)));
    let [_, stage, ..] = nodes::<3>();
    // Two nodes beside the stage, an encoder, and so five decoders at most.
    assert!(matches!(refine(&dag, stage, encoder, &[decoder; 6]), Err(RefineError::Full)));
    // The last node too, behind which nothing else could tell that it is full.
    let last = NodeId::new(2);
    assert!(matches!(refine(&dag, last, encoder, &[decoder; 6]), Err(RefineError::Full)));
    assert_eq!(format!("{dag:?}"), before);
    assert_eq!(refine(&dag, stage, encoder, &[decoder; 5]).expect("eight nodes fit").dag.len(), 8);
    let (mut scheduler, task) = one_task(Config::REDRT, &dag, due(100));
    assert_eq!(runs_through(&mut scheduler, task, at(0)), nodes::<3>());
}
