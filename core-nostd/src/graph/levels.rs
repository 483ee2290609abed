//! Heights, level sets and longest paths (paper Def. 1 to 3).
//!
//! *Rule.* height(v) = 0 for sources, else 1 + the largest height among predecessors; one Kahn pass, ties by
//! node id. tail(v) = max over successors s of (c_s + tail(s)), 0 at sinks; head(v) = c_v + max over predecessors
//! of head. No sum is above the graph's work, so none overflows. Time bound: O(nodes + edges).

use super::{Dag, NodeSet};
use crate::capacity::{Capacity, Empty};
use crate::id::NodeId;

/// Heights of a graph's nodes, its nodes in topological order, and the longest path from each of them on.
///
/// ```
/// use red_core::{Caps, Dag, Levels, Node, Wcet};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// let a = dag.add_node(Node::new(Wcet::from_nanos(20)))?;
/// let b = dag.add_node(Node::new(Wcet::from_nanos(40)))?;
/// dag.add_edge(a, b)?;
/// let levels = Levels::of(&dag);
/// assert_eq!((levels.height(a), levels.height(b), levels.count()), (0, 1, 2));
/// assert_eq!((levels.tail(a), levels.tail(b), levels.critical_path()), (40, 0, 60));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Levels<'a, C: Capacity> {
    pub(crate) dag: &'a Dag<C>,
    pub(crate) height: C::Nodes<u8>,
    /// Longest path from each node on, itself included, in nanoseconds.
    pub(crate) path: C::Nodes<u64>,
    order: C::Nodes<u8>,
    len: usize,
    count: usize,
}

impl<'a, C: Capacity> Levels<'a, C> {
    /// Computes the heights and paths of `dag`.
    pub fn of(dag: &'a Dag<C>) -> Self {
        let (height, path, order) = (Empty::EMPTY, Empty::EMPTY, Empty::EMPTY);
        let mut levels = Self { dag, height, path, order, len: 0, count: 0 };
        let mut left = dag.indegree;
        let mut open = NodeSet::<C>::EMPTY;
        dag.present.each(|i| open.insert_if(i, left[i] == 0));
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
            levels.path[i] = dag.out(i).largest(&levels.path) + dag.at(i).cost();
        }
        levels
    }

    /// The node's height.
    pub fn height(&self, node: NodeId) -> usize {
        if self.dag.contains(node) { self.height[node.index()].into() } else { 0 }
    }

    /// How many levels there are: the greatest height plus one, 0 for an empty graph.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Longest path cost after the node, excluding it, in nanoseconds.
    pub fn tail(&self, node: NodeId) -> u64 {
        if self.dag.contains(node) { self.tail_at(node.index()) } else { 0 }
    }

    /// The critical path cost C*, in nanoseconds.
    pub fn critical_path(&self) -> u64 {
        self.dag.present.largest(&self.path)
    }

    /// Places of the nodes in topological order, by (height, id).
    pub(crate) fn places(&self) -> impl DoubleEndedIterator<Item = usize> + '_ {
        self.order.as_ref().iter().take(self.len).map(|i| usize::from(*i))
    }

    pub(crate) fn tail_at(&self, place: usize) -> u64 {
        self.path[place] - self.dag.at(place).cost()
    }

    /// Longest path cost up to each node, including it, in nanoseconds.
    pub(crate) fn heads(&self) -> C::Nodes<u64> {
        let mut head = <C::Nodes<u64>>::EMPTY;
        for i in self.places() {
            head[i] += self.dag.at(i).cost();
            let reached = head[i];
            self.dag.out(i).each(|j| head[j] = head[j].max(reached));
        }
        head
    }
}
