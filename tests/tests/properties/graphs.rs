//! Random graphs: acyclic by construction, and refused where they would not be.

use proptest::prelude::*;
use red_core::{Capacity, Caps, Contention, Dag, EdgeError, Node, NodeId, PoolId, Wcet};
use red_tests::rng::Rng;

use super::cases;

/// Graphs of up to 80 nodes in two pools.
pub(crate) type Wide = Caps<1, 80, 4, 8, 2, 2>;

/// A graph of 1 to 80 nodes; equal seeds give equal graphs. Costs are all zero, small, or as large as two nodes
/// of 2^60 ns.
pub(crate) fn random_graph<C: Capacity>(seed: u64, pools: u64) -> Dag<C> {
    let rng = &mut Rng::new(seed);
    let mut dag = Dag::new();
    let (nodes, kind, density) = (rng.within(1, 80), rng.within(0, 5), rng.within(0, 40));
    for _ in 0..nodes {
        let cost = match kind {
            0 => 0,
            1 => rng.within(0, 3),
            2 => rng.within(0, 1 << 53),
            _ => rng.within(0, 20) * 100_000,
        };
        let node = Node::new(Wcet::from_nanos(cost)).in_pool(PoolId::new(rng.index(pools as usize) as u8));
        let contention = Contention::from_nanos(cost / 4);
        dag.add_node(if rng.chance(10) { node.atomic(contention) } else { node }).expect("80 nodes fit");
    }
    for to in 1..nodes {
        for from in 0..to {
            if rng.chance(density) {
                dag.add_edge(NodeId::new(from as u8), NodeId::new(to as u8)).expect("it goes forward");
            }
        }
    }
    dag
}

/// Edges of a graph.
pub(crate) fn edges<C: Capacity>(dag: &Dag<C>) -> Vec<(NodeId, NodeId)> {
    let out = |from: NodeId| dag.successors(from).iter().map(move |to| (from, NodeId::new(to as u8)));
    dag.nodes().flat_map(out).collect()
}

/// Whether `to` can be reached from `from`, by a matrix.
fn reaches(edges: &[(u8, u8)], from: u8, to: u8) -> bool {
    let mut reached = vec![from];
    let mut next = 0;
    while next < reached.len() {
        let fresh =
            edges.iter().filter(|(a, b)| *a == reached[next] && !reached.contains(b)).map(|(_, b)| *b);
        let fresh: Vec<u8> = fresh.collect();
        reached.extend(fresh);
        next += 1;
    }
    reached.contains(&to)
}

proptest! {
    #![proptest_config(cases(256))]

    #[test]
    fn an_edge_is_refused_exactly_where_it_would_close_a_cycle_or_be_there_twice(
        asked in prop::collection::vec((0u8..12, 0u8..12), 0..60)
    ) {
        let mut dag = Dag::<Wide>::new();
        for _ in 0..10 {
            dag.add_node(Node::new(Wcet::from_nanos(1))).expect("10 nodes fit");
        }
        let mut there: Vec<(u8, u8)> = Vec::new();
        for (from, to) in asked {
            let expected = if from >= 10 || to >= 10 {
                Err(EdgeError::UnknownNode)
            } else if there.contains(&(from, to)) {
                Err(EdgeError::Duplicate)
            } else if reaches(&there, to, from) {
                Err(EdgeError::Cycle)
            } else {
                there.push((from, to));
                Ok(())
            };
            prop_assert_eq!(dag.add_edge(NodeId::new(from), NodeId::new(to)), expected);
        }
        let mut kept: Vec<(u8, u8)> =
            edges(&dag).into_iter().map(|(a, b)| (a.index() as u8, b.index() as u8)).collect();
        kept.sort_unstable();
        there.sort_unstable();
        prop_assert_eq!(kept, there);
    }
}
