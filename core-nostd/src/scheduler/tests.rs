use super::*;
use crate::{Caps, Dag, Node, TaskId, Timing, Wcet};

/// The paper's workload: 4 tasks of 16 nodes, 16 jobs, 4 lanes.
type Paper = Caps<4, 16, 16>;

#[test]
fn a_steady_state_of_one_job_never_touches_the_queue() {
    let mut dag = Dag::<Paper>::new();
    let nodes = [0; 4].map(|_| dag.add_node(Node::new(Wcet::from_millis(1))).unwrap());
    nodes.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).unwrap());
    let mut scheduler = Scheduler::<Paper>::new(Config::REDRT);
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50))).unwrap();
    scheduler.release(task, Instant::ZERO).unwrap();
    let mut order = Vec::new();
    while let Some(action) = scheduler.poll(Instant::ZERO) {
        assert!(scheduler.pools[0].queue.is_empty());
        if let crate::Action::Dispatch(d) = action {
            order.push(d.unit.node());
            scheduler.complete(d.unit, Instant::ZERO).unwrap();
        }
    }
    assert_eq!(order, nodes);
}

#[test]
fn an_edit_keeps_the_samples_of_nodes_that_stay_whether_or_not_the_task_is_idle() {
    let mut dag = Dag::<Paper>::new();
    let stays = dag.add_node(Node::new(Wcet::from_millis(2))).unwrap();
    let goes = dag.add_node(Node::new(Wcet::from_millis(2))).unwrap();
    for idle in [true, false] {
        let mut scheduler = Scheduler::<Paper>::new(Config::REDRT);
        let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50))).unwrap();
        let now = Instant::ZERO.saturating_add(Duration::from_millis(1));
        scheduler.release(task, Instant::ZERO).unwrap();
        while let Some(crate::Action::Dispatch(d)) = scheduler.poll(Instant::ZERO) {
            scheduler.complete(d.unit, now).unwrap();
        }
        if !idle {
            scheduler.release(task, now).unwrap();
        }
        let mut edit = scheduler.edit(task).unwrap();
        edit.remove_node(goes);
        let new = edit.add_node(Node::new(Wcet::from_millis(1))).unwrap();
        let _fits = scheduler.commit(&edit, now).unwrap();
        let mean = |node| scheduler.task_node(task, node).unwrap().1.mean();
        assert_eq!(
            (mean(stays), mean(new)),
            (Some(crate::CostEstimate::from_millis(1)), None),
            "idle: {idle}"
        );
    }
}

#[test]
fn a_timing_that_is_made_again_of_its_parts_has_the_same() {
    let floors =
        [(0, 0), (3, 4), (128, 128), (1, 129), (500, 1000), (7, 3), (0, u32::MAX), (u32::MAX, u32::MAX)];
    for (m, k) in floors {
        let timing = Timing::new(Duration::from_nanos(7)).every(Duration::from_nanos(5)).value(9).floor(m, k);
        let (deadline, period, value, [least, of]) = timing.parts();
        assert_eq!((deadline.as_nanos(), period.map(Duration::as_nanos), value), (7, Some(5), 9));
        let again = timing.floor(least.into(), of.into());
        assert_eq!(format!("{again:?}"), format!("{timing:?}"), "{m} of {k}");
    }
    assert_eq!(Timing::new(Duration::ZERO).parts().1, None);
}

#[test]
fn an_edit_knows_whose_graph_it_was_and_after_how_many_commits() {
    type One = Caps<1, 4, 2>;
    let mut dag = Dag::<One>::new();
    dag.add_node(Node::new(Wcet::from_nanos(1))).unwrap();
    assert_eq!(dag.origin(), (TaskId::EMPTY, 0));
    let mut scheduler = Scheduler::new(Config::REDRT);
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(1))).unwrap();
    for revision in 1..4 {
        let edit = scheduler.edit(task).unwrap();
        assert_eq!(edit.origin(), (task, revision));
        let _proof = scheduler.commit(&edit, Instant::ZERO).unwrap();
    }
}

#[test]
fn a_lane_that_comes_back_brings_back_what_jobs_have_to_spare() {
    let mut dag = Dag::<Paper>::new();
    for _ in 0..2 {
        dag.add_node(Node::new(Wcet::from_nanos(15))).unwrap();
    }
    let mut scheduler = Scheduler::<Paper>::new(Config::REDRT.with_lanes(2));
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(20))).unwrap();
    let slack = |scheduler: &Scheduler<Paper>| scheduler.tasks[task.index()].newest().slack;
    assert_eq!(slack(&scheduler), 5);
    assert!(scheduler.retire_lane(crate::LaneId::new(1)));
    assert_eq!(slack(&scheduler), -10);
    assert!(scheduler.restore_lane(crate::LaneId::new(1)));
    assert_eq!(slack(&scheduler), 5);
}
