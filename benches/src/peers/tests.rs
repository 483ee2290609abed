//! Every peer in Rust completes every run of every graph. C++ peers are trusted: they count nothing.

use super::*;
use crate::graphs::Graph;

/// One CPU for both lanes, so that the tests need no second one.
pub(crate) fn machine() -> &'static Machine {
    let machine = Machine::best_effort().map(|found| Machine { lanes: vec![found.lanes[0]; 2], ..found });
    Box::leak(Box::new(machine.expect("the affinity of this process can be read")))
}

/// Three runs of every graph.
pub(crate) fn run(lanes: usize, build: fn(&Setup<'_>) -> Result<Runner, NotRun>) {
    for graph in Graph::all() {
        let setup = Setup { graph: &graph, lanes, body: Body::EMPTY, machine: machine() };
        let mut samples = [0; 2];
        let ended = build(&setup).and_then(|mut runner| runner(3, &mut samples));
        assert!(ended.is_ok(), "{}: {ended:?}", graph.name);
    }
}

#[test]
fn embassy_completes_every_graph() {
    run(1, embassy::build);
}

#[test]
fn mutex_and_heap_completes_every_graph() {
    run(2, mutex_heap::build);
}

#[test]
fn rayon_completes_every_graph() {
    run(2, rayon::build);
}

#[test]
fn edf_under_a_spin_lock_completes_every_graph_with_two_lanes() {
    run(2, edf_spin::build);
}

#[test]
fn edf_runs_every_node_once_after_its_predecessors() {
    for graph in Graph::all() {
        let plan = edf::Plan::new(&graph);
        let mut state = plan.state();
        for _ in 0..2 {
            state.release(&plan);
            let mut order = Vec::new();
            while let Some(node) = state.next() {
                order.push(node);
                state.complete(&plan, node);
            }
            assert_eq!(order.len(), graph.nodes());
            let mut place = vec![0; graph.nodes()];
            for (at, &node) in order.iter().enumerate() {
                place[node] = at;
            }
            for (from, list) in graph.successors.iter().enumerate() {
                assert!(list.iter().all(|&to| place[from] < place[to as usize]));
            }
        }
    }
}
