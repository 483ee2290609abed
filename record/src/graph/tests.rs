use super::*;
use red_core::{Caps, Config, Duration, Frame, Instant, Scheduler, Timing};

type Few = Caps<1, 6, 4>;

fn node(ns: u64) -> Node {
    Node::new(Wcet::from_nanos(ns))
}

/// The parts that a recorder makes of a graph.
fn parts<C: Capacity>(dag: &Dag<C>) -> Parts {
    let mut parts = Parts::default();
    for place in dag.nodes() {
        let node = *dag.node(place).expect("it is there");
        parts.before(&Call::Node { place, node }).expect("a part");
        let mut to = [0; GROUPS];
        dag.successors(place).each(|next| to[next / 64] |= 1 << (next % 64));
        for (group, to) in (0..).zip(to).filter(|(_, to)| *to != 0) {
            parts.before(&Call::Edges { from: place, group, to }).expect("a part");
        }
    }
    let [deadline, period] = [Duration::ZERO; 2];
    let takes = Call::AddTask { deadline, period: Some(period), value: 1, floor: [0; 2] };
    let all = parts.before(&takes).expect("a graph");
    assert!(parts.nodes.is_empty(), "the next graph is another");
    all
}

fn shown<C: Capacity>(dag: &Dag<C>) -> Vec<(NodeId, Node, Vec<usize>)> {
    let with_edges =
        |id| (id, *dag.node(id).expect("it is there"), dag.successors(id).iter().collect::<Vec<_>>());
    dag.nodes().map(with_edges).collect()
}

#[test]
fn nodes_of_a_new_graph_are_where_they_were_though_others_before_them_were_removed() {
    let mut dag = Dag::<Few>::new();
    let nodes = [1, 2, 3, 4, 5].map(|ns| dag.add_node(node(ns)).unwrap());
    for gone in [nodes[0], nodes[2]] {
        dag.remove_node(gone);
    }
    dag.add_edge(nodes[4], nodes[1]).unwrap();
    dag.add_edge(nodes[1], nodes[3]).unwrap();
    // After the last place the first come again.
    let last = dag.add_node(Node::decoder(Wcet::from_nanos(9))).unwrap();
    let again = dag.add_node(node(7)).unwrap();
    assert_eq!((last.index(), again.index()), (5, 0));
    dag.add_edge(again, last).unwrap();
    assert_eq!(shown(&parts(&dag).onto(Dag::<Few>::new()).expect("a graph")), shown(&dag));
    assert!(parts(&Dag::<Few>::new()).onto(Dag::<Few>::new()).expect("a graph").is_empty());
}

#[test]
fn a_graph_of_every_place_and_edge_comes_back() {
    type Many = Caps<1, 256, 1, 1, 1, 4>;
    let mut dag = Dag::<Many>::new();
    let nodes: Vec<_> = (0..256).map(|ns| dag.add_node(node(ns)).unwrap()).collect();
    for (i, from) in nodes.iter().enumerate() {
        nodes.iter().skip(i + 1).for_each(|to| dag.add_edge(*from, *to).unwrap());
    }
    assert_eq!(shown(&parts(&dag).onto(Dag::<Many>::new()).expect("a graph")), shown(&dag));
}

#[test]
fn an_edit_is_made_again_of_the_graph_that_it_was_begun_from() {
    let mut first = Dag::<Few>::new();
    let nodes = [1, 2, 3].map(|ns| first.add_node(node(ns)).unwrap());
    first.add_edge(nodes[0], nodes[1]).unwrap();
    first.add_edge(nodes[1], nodes[2]).unwrap();
    let mut scheduler = Scheduler::new(Config::REDRT);
    let task = scheduler.add_task(&first, Timing::new(Duration::from_millis(1))).unwrap();
    // A job keeps the graph of its release, and so the places of its nodes.
    scheduler.release(task, Instant::ZERO).unwrap();
    let mut edit = scheduler.edit(task).unwrap();
    edit.remove_node(nodes[1]);
    let [fourth, fifth] = [4, 5].map(|ns| edit.add_node(node(ns)).unwrap());
    edit.remove_node(fourth);
    edit.add_edge(nodes[2], nodes[0]).unwrap();
    edit.add_edge(fifth, nodes[2]).unwrap();
    let again = parts(&edit).onto(scheduler.edit(task).unwrap()).expect("a graph");
    assert_eq!((shown(&again), again.origin()), (shown(&edit), edit.origin()));
    let _proof = scheduler.commit(&again, Instant::ZERO).unwrap();
    let second = scheduler.edit(task).unwrap();
    // A place that the job still uses, and a node that changed where it is.
    for (place, ns) in [(1, 2), (0, 77)] {
        let mut wrong = parts(&second);
        wrong.nodes[place] = Some(Part { node: node(ns), to: [0; GROUPS] });
        assert!(wrong.onto(second).is_none(), "{place}");
    }
}

#[test]
fn what_no_graph_is_made_of_is_refused() {
    let place = NodeId::new;
    let add = |place| Call::Node { place, node: node(1) };
    let lead = |from, group, to| Call::Edges { from, group, to };
    let taken = |calls: &[Call]| {
        let mut parts = Parts::default();
        calls.iter().all(|call| parts.before(call).is_some())
    };
    let (a, b) = (place(0), place(5));
    assert!(taken(&[add(b), lead(b, 0, 1), lead(b, 3, 1), add(a), lead(a, 0, 1)]));
    assert!(!taken(&[add(a), add(a)]), "a place has one node");
    assert!(!taken(&[lead(a, 0, 1)]) && !taken(&[add(b), lead(a, 0, 1)]), "edges leave a node");
    assert!(!taken(&[add(a), lead(a, 0, 1), lead(a, 0, 2)]), "edges come once");
    assert!(!taken(&[add(a), lead(a, 4, 1)]), "there are 256 places");
    assert!(!taken(&[add(a), Call::Poll(None)]) && taken(&[Call::Poll(None), add(a)]), "nothing in between");
    let made = |calls: &[Call]| {
        let mut parts = Parts::default();
        calls.iter().for_each(|call| assert!(parts.before(call).is_some(), "{call}"));
        parts.onto(Dag::<Few>::new()).is_some()
    };
    assert!(made(&[add(a), lead(a, 0, 32), add(b)]));
    assert!(!made(&[add(a), lead(a, 0, 32)]), "an edge leads to a node");
    assert!(!made(&[add(a), lead(a, 0, 32), add(b), lead(b, 0, 1)]), "a cycle");
    assert!(!made(&[add(place(6))]), "there are six places");
    let endless = Call::Node { place: b, node: node(u64::MAX) };
    assert!(made(&[endless]) && !made(&[add(a), endless]), "a sum that is no time");
    let encoder = |place| {
        let frame = Frame { weights: 0, frame: 0, sensor: None };
        Call::Node { place, node: Node::shared_encoder(Wcet::from_nanos(1), frame) }
    };
    let decoder = Call::Node { place: b, node: Node::decoder(Wcet::from_nanos(1)) };
    let two = [encoder(a), lead(a, 0, 32), encoder(place(1)), lead(place(1), 0, 32), decoder];
    assert!(!made(&two), "a decoder of two encoders");
}
