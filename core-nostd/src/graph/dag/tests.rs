use super::*;
use crate::{Caps, Levels, Wcet};

type Three = Caps<1, 3, 1>;

fn node(ns: u64) -> Node {
    Node::new(Wcet::from_nanos(ns))
}

#[test]
fn cycles_of_any_length_are_refused_and_change_nothing() {
    let mut dag = Dag::<Three>::new();
    let [a, b, c] = [1, 2, 3].map(|ns| dag.add_node(node(ns)).unwrap());
    assert_eq!(dag.add_edge(a, a), Err(EdgeError::Cycle));
    dag.add_edge(a, b).unwrap();
    assert_eq!(dag.add_edge(b, a), Err(EdgeError::Cycle));
    dag.add_edge(b, c).unwrap();
    assert_eq!(dag.add_edge(c, a), Err(EdgeError::Cycle));
    assert_eq!(dag.add_edge(a, b), Err(EdgeError::Duplicate));
    assert_eq!(dag.add_edge(a, NodeId::new(9)), Err(EdgeError::UnknownNode));
    assert_eq!(Levels::of(&dag).count(), 3);
}

#[test]
fn a_full_graph_refuses_the_next_node_and_keeps_its_work() {
    let mut dag = Dag::<Three>::new();
    for ns in 1..=3 {
        dag.add_node(node(ns)).unwrap();
    }
    assert_eq!(dag.add_node(node(4)), Err(NodeError::Full));
    assert_eq!((dag.len(), dag.work()), (3, 6));
}

#[test]
fn costs_that_do_not_fit_are_refused() {
    let mut dag = Dag::<Three>::new();
    dag.add_node(node(u64::MAX)).unwrap();
    assert_eq!(dag.add_node(node(1)), Err(NodeError::WorkOverflow));
    assert_eq!(dag.len(), 1);
}

#[test]
fn removing_a_node_removes_its_edges_and_its_cost() {
    let mut dag = Dag::<Three>::new();
    let [a, b, c] = [1, 2, 3].map(|ns| dag.add_node(node(ns)).unwrap());
    dag.add_edge(a, b).unwrap();
    dag.add_edge(b, c).unwrap();
    assert!(dag.remove_node(b));
    assert!(!dag.remove_node(b));
    assert_eq!((dag.work(), Levels::of(&dag).count()), (4, 1));
    dag.add_edge(c, a).unwrap();
}
