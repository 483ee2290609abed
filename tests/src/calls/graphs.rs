//! The graph that tasks begin with, and what edits do to it.

use red_core::{Bytes, Dag, Frame, Node, NodeId, PoolId, Wcet};

use super::Small;

/// One step of an edit. Names may be those of nodes that do not exist.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// A node after another: what it costs in milliseconds, and the kind of node.
    Add(u8, u8, u8),
    /// A node goes.
    Remove(u8),
    /// An edge comes.
    Link(u8, u8),
    /// An edge goes.
    Unlink(u8, u8),
}

fn frame() -> Frame {
    Frame { weights: 0, frame: 0, sensor: None }
}

/// An encoder and two decoders behind a camera; the encoder's frames are the jobs' own unless a capture is given.
pub(super) fn graph() -> Dag<Small> {
    let mut dag = Dag::new();
    let mut add = |node| dag.add_node(node).expect("six nodes fit");
    let camera = add(Node::new(Wcet::from_millis(1)));
    let encoder = add(Node::shared_encoder(Wcet::from_millis(2), frame()).memory(Bytes(2)));
    let decoders = [0; 2].map(|_| add(Node::decoder(Wcet::from_millis(1)).memory(Bytes(1))));
    let edges = [(camera, encoder), (encoder, decoders[0]), (encoder, decoders[1])];
    edges.into_iter().for_each(|(from, to)| dag.add_edge(from, to).expect("no cycle"));
    dag
}

/// What the graph refuses is left out.
pub(super) fn apply(dag: &mut Dag<Small>, change: Change) {
    match change {
        Change::Add(after, cost, kind) => {
            let wcet = Wcet::from_millis(u64::from(cost % 4));
            let node = match kind % 8 {
                0 | 1 => Node::shared_encoder(wcet, frame()).memory(Bytes(2)),
                2 | 3 => Node::decoder(wcet).memory(Bytes(1)),
                4 => Node::new(Wcet::from_nanos(u64::MAX)),
                5 => Node::new(wcet).in_pool(PoolId::new(cost)),
                6 => Node::new(wcet).memory(Bytes(u64::MAX)),
                _ => Node::new(wcet),
            };
            if let Ok(new) = dag.add_node(node) {
                let _refused = dag.add_edge(NodeId::new(after), new);
            }
        }
        Change::Remove(node) => _ = dag.remove_node(NodeId::new(node)),
        Change::Link(from, to) => _ = dag.add_edge(NodeId::new(from), NodeId::new(to)),
        Change::Unlink(from, to) => _ = dag.remove_edge(NodeId::new(from), NodeId::new(to)),
    }
}

/// Nodes with their costs and successors.
pub(super) fn shape(dag: &Dag<Small>) -> Vec<(NodeId, u64, Vec<usize>)> {
    let of = |node| (node, dag.node(node).map_or(0, Node::cost), dag.successors(node).iter().collect());
    dag.nodes().map(of).collect()
}
