//! Heights and level sets (paper Def. 1 and 2).
//!
//! *Rule.* height(v) = 0 for sources, else 1 + the largest height among predecessors; one Kahn pass, ties by
//! node id. Time bound: O(nodes + edges).

use super::{Dag, NodeSet};
use crate::capacity::{Capacity, Empty};
use crate::id::NodeId;

/// Heights of a graph's nodes, its nodes in topological order, and the longest path from each of them on.
///
/// ```
/// use red_core::{Caps, Dag, Levels, Node, Wcet};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// let a = dag.add_node(Node::new(Wcet::from_millis(1)))?;
/// let b = dag.add_node(Node::new(Wcet::from_millis(1)))?;
/// dag.add_edge(a, b)?;
/// let levels = Levels::of(&dag);
/// assert_eq!((levels.height(a), levels.height(b), levels.count()), (0, 1, 2));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Levels<C: Capacity> {
    height: C::Nodes<u8>,
    order: C::Nodes<u8>,
    path: C::Nodes<u64>,
    len: usize,
    count: usize,
}

impl<C: Capacity> Levels<C> {
    /// Computes the heights of `dag`.
    pub fn of(dag: &Dag<C>) -> Self {
        let mut levels =
            Self { height: Empty::EMPTY, order: Empty::EMPTY, path: Empty::EMPTY, len: 0, count: 0 };
        let mut left = *dag.indegree();
        let mut open = NodeSet::<C>::EMPTY;
        dag.present().each(|i| open.insert_if(i, left[i] == 0));
        // Each round takes one whole level: at most C::NODES rounds, and each edge is looked at once.
        while !open.is_empty() {
            let mut next = NodeSet::EMPTY;
            let height = levels.count as u8;
            open.each(|i| {
                levels.height[i] = height;
                levels.order[levels.len] = i as u8;
                levels.len += 1;
                dag.out(i).each(|j| {
                    left[j] -= 1;
                    next.insert_if(j, left[j] == 0);
                });
            });
            levels.count += 1;
            open = next;
        }
        for at in (0..levels.len).rev() {
            let i = usize::from(levels.order[at]);
            let mut after = 0;
            dag.out(i).each(|j| after = after.max(levels.path[j]));
            levels.path[i] = after + dag.at(i).cost();
        }
        levels
    }

    /// The node's height.
    pub fn height(&self, node: NodeId) -> usize {
        if node.index() < C::NODES { usize::from(self.height[node.index()]) } else { 0 }
    }

    /// How many levels there are: the greatest height plus one, 0 for an empty graph.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Nodes in topological order, by (height, id).
    pub fn order(&self) -> impl DoubleEndedIterator<Item = NodeId> + '_ {
        self.places().map(|i| NodeId::new(i as u8))
    }

    pub(crate) fn places(&self) -> impl DoubleEndedIterator<Item = usize> + '_ {
        self.order.as_ref().iter().take(self.len).map(|i| usize::from(*i))
    }

    /// Length of the longest path from each node on, itself included, in nanoseconds.
    pub(crate) const fn paths(&self) -> &C::Nodes<u64> {
        &self.path
    }
}
