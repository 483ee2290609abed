//! What counterexamples are made of: small graphs, and schedules by the shortest rules there are.

use red_core::{Caps, Dag, Levels, Node, NodeId, SubDeadlines, Wcet};

pub(crate) type Small = Caps<1, 16, 1, 4, 1>;
pub(crate) type Graph = Dag<Small>;

/// A graph of nodes of these costs in nanoseconds.
pub(crate) fn dag(costs: &[u64], edges: &[(usize, usize)]) -> Graph {
    let mut graph = Graph::new();
    let nodes: Vec<NodeId> =
        costs.iter().map(|ns| graph.add_node(Node::new(Wcet::from_nanos(*ns))).expect("room")).collect();
    edges.iter().for_each(|(from, to)| graph.add_edge(nodes[*from], nodes[*to]).expect("an edge"));
    graph
}

/// Ends of all nodes on so many lanes: whenever one is free, the ready node of the smallest key begins.
pub(crate) fn schedule(graph: &Graph, lanes: usize, key: impl Fn(NodeId) -> i64, gated: bool) -> Vec<u64> {
    let levels = Levels::of(graph);
    let nodes: Vec<NodeId> = graph.nodes().collect();
    let (mut ends, mut now) = (vec![None; nodes.len()], 0);
    let cost = |node: NodeId| graph.node(node).map_or(0, |node| node.cost());
    while ends.iter().any(Option::is_none) {
        let done = |node: &NodeId| ends[node.index()].is_some_and(|end: u64| end <= now);
        let before = |a: NodeId, b: NodeId| match gated {
            true => levels.height(a) < levels.height(b),
            false => graph.successors(a).iter().any(|i| i == b.index()),
        };
        let is_ready = |node: &&NodeId| {
            ends[node.index()].is_none() && nodes.iter().filter(|a| before(**a, **node)).all(done)
        };
        let running = ends.iter().flatten().filter(|end| **end > now).count();
        let next = nodes.iter().filter(is_ready).min_by_key(|node| (key(**node), node.index()));
        match next.filter(|_| running < lanes) {
            Some(node) => ends[node.index()] = Some(now + cost(*node)),
            None => now = ends.iter().flatten().filter(|end| **end > now).min().copied().unwrap_or(now + 1),
        }
    }
    ends.into_iter().flatten().collect()
}

/// Makespan of a list schedule in the order of the nodes.
pub(crate) fn list_makespan(graph: &Graph, lanes: usize) -> u64 {
    schedule(graph, lanes, |_| 0, false).into_iter().max().unwrap_or(0)
}

/// The same where a level waits for the one before it.
pub(crate) fn level_gated(graph: &Graph, lanes: usize) -> u64 {
    schedule(graph, lanes, |_| 0, true).into_iter().max().unwrap_or(0)
}

/// Ends under EDF by sub-deadline.
pub(crate) fn edf_by_sub_deadline(graph: &Graph, due: &SubDeadlines<Small>, lanes: usize) -> Vec<u64> {
    schedule(graph, lanes, |node| due.sub_deadline(node), false)
}
