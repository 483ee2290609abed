//! Graphs of a scheduler as plain data.

use red_core::{Capacity, Dag, Levels, Role};
use red_report::model::{Graph, Node};

/// A graph, with the numbers that nodes have in every version of it.
pub(super) fn of<C: Capacity>(dag: &Dag<C>) -> Graph {
    let levels = Levels::of(dag);
    let mut graph = Graph::default();
    for id in dag.nodes() {
        let Some(node) = dag.node(id) else { continue };
        graph.nodes.insert(
            id.index(),
            Node {
                wcet_ns: node.wcet().get().as_nanos(),
                pool: node.pool().index(),
                height: levels.height(id),
                rest_ns: levels.tail(id).saturating_add(node.cost()),
                after: Vec::new(),
                is_encoder: matches!(node.role(), Role::SharedEncoder(_)),
            },
        );
    }
    for from in dag.nodes() {
        for to in dag.successors(from).iter() {
            if let Some(node) = graph.nodes.get_mut(&to) {
                node.after.push(from.index());
            }
        }
    }
    graph
}

/// What an edit changed, by the names of nodes: those that came and those that went.
pub(super) fn difference(before: &Graph, after: &Graph, name: impl Fn(usize) -> String) -> String {
    let gone = before
        .nodes
        .keys()
        .filter(|node| !after.nodes.contains_key(node))
        .map(|node| format!("−{}", name(*node)));
    let came = after
        .nodes
        .keys()
        .filter(|node| !before.nodes.contains_key(node))
        .map(|node| format!("+{}", name(*node)));
    let words: Vec<String> = gone.chain(came).collect();
    if words.is_empty() { "other costs or edges".to_owned() } else { words.join(" ") }
}
