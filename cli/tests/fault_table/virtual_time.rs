//! A host of the core in virtual time, as small as it can be, and the graphs that the rows share.

use red_core::{
    Action, Capacity, Caps, Config, Dag, Dispatch, Duration, Instant, Node, NodeId, Outcome, Scheduler,
    TaskId, Timing, Wcet,
};

/// Two tasks of eight nodes, four jobs, two lanes and a record of 64 events.
pub(crate) type Small = Caps<2, 8, 4, 2, 1, 1, 64>;

pub(crate) const MS: u64 = 1_000_000;

pub(crate) fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * MS)
}

pub(crate) fn cost(ms: u64) -> Node {
    Node::new(Wcet::from_millis(ms))
}

pub(crate) fn due(ms: u64) -> Timing {
    Timing::new(Duration::from_millis(ms))
}

/// A chain of nodes with these costs in milliseconds.
pub(crate) fn chain<C: Capacity>(costs_ms: &[u64]) -> Dag<C> {
    let mut dag = Dag::new();
    let nodes: Vec<NodeId> = costs_ms.iter().map(|ms| dag.add_node(cost(*ms)).expect("it fits")).collect();
    nodes.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).expect("a chain has no cycle"));
    dag
}

/// A scheduler of one task.
pub(crate) fn one_task<C: Capacity>(
    config: Config,
    dag: &Dag<C>,
    timing: Timing,
) -> (Box<Scheduler<C>>, TaskId) {
    let mut scheduler = Box::new(Scheduler::new(config));
    let task = scheduler.add_task(dag, timing).expect("it fits");
    (scheduler, task)
}

/// What `poll` gives at an instant.
pub(crate) fn poll<C: Capacity>(scheduler: &mut Scheduler<C>, now: Instant) -> (Vec<Dispatch>, Vec<Outcome>) {
    let (mut starts, mut ends) = (Vec::new(), Vec::new());
    while let Some(action) = scheduler.poll(now) {
        match action {
            Action::Dispatch(start) => starts.push(start),
            Action::Ended(outcome) => ends.push(outcome),
            other => panic!("nobody asked for {other:?}"),
        }
    }
    (starts, ends)
}

/// Lets everything in flight end, each node after its WCET. Nodes in the order of their starts, and the outcomes.
pub(crate) fn drain<C: Capacity>(scheduler: &mut Scheduler<C>, from: Instant) -> (Vec<NodeId>, Vec<Outcome>) {
    let (mut order, mut ended) = (Vec::new(), Vec::new());
    let (mut running, mut now) = (Vec::new(), from);
    loop {
        let (starts, ends) = poll(scheduler, now);
        ended.extend(ends);
        for start in starts {
            let unit = scheduler.unit(start.unit).expect("it was just started");
            order.push(unit.first.node);
            running.push((now.saturating_add(unit.wcet), start.unit));
        }
        running.sort_by_key(|(end, _)| *end);
        if running.is_empty() {
            return (order, ended);
        }
        let (end, unit) = running.remove(0);
        now = end;
        // `Late` is the end of a unit whose job was given up.
        let _lane_is_free = scheduler.complete(unit, now);
    }
}

/// Asserts that a job of `task` runs through from `from` on, whatever was refused before; the order of its nodes.
pub(crate) fn runs_through<C: Capacity>(
    scheduler: &mut Scheduler<C>,
    task: TaskId,
    from: Instant,
) -> Vec<NodeId> {
    let job = scheduler.release(task, from).expect("there is room");
    let (order, ended) = drain(scheduler, from);
    let outcome = ended.iter().find(|outcome| outcome.job == job).expect("the job ended");
    assert!(outcome.on_time(), "{outcome:?}");
    order
}
