use super::*;
use crate::Caps;

/// The paper's workload: 4 tasks of 16 nodes, 16 jobs, 4 lanes.
type Paper = Caps<4, 16, 16>;

#[test]
fn a_steady_state_of_one_job_never_touches_the_queue() {
    let mut dag = crate::Dag::<Paper>::new();
    let nodes = [0; 4].map(|_| dag.add_node(crate::Node::new(crate::Wcet::from_millis(1))).unwrap());
    nodes.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).unwrap());
    let mut scheduler = Scheduler::<Paper>::new(Config::REDRT);
    let task = scheduler.add_task(&dag, crate::Timing::new(Duration::from_millis(50))).unwrap();
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
    let mut dag = crate::Dag::<Paper>::new();
    let stays = dag.add_node(crate::Node::new(crate::Wcet::from_millis(2))).unwrap();
    let goes = dag.add_node(crate::Node::new(crate::Wcet::from_millis(2))).unwrap();
    for idle in [true, false] {
        let mut scheduler = Scheduler::<Paper>::new(Config::REDRT);
        let task = scheduler.add_task(&dag, crate::Timing::new(Duration::from_millis(50))).unwrap();
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
        let new = edit.add_node(crate::Node::new(crate::Wcet::from_millis(1))).unwrap();
        let _fits = scheduler.commit(&edit, now).unwrap();
        let mean = |node| scheduler.task_node(task, node).unwrap().1.mean();
        assert_eq!(
            (mean(stays), mean(new)),
            (Some(crate::CostEstimate::from_millis(1)), None),
            "idle: {idle}"
        );
    }
}
