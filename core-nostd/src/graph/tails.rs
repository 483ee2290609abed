//! Longest paths: after each node, up to each node, through the whole graph (paper Def. 3).
//!
//! *Rule.* tail(v) = max over successors s of (c_s + tail(s)), 0 at sinks; head(v) = c_v + max over
//! predecessors of head. One pass each, additions only. The sums cannot overflow: none is above the graph's
//! work. Time bound: O(nodes + edges).

use super::{Dag, Levels};
use crate::capacity::{Capacity, Empty};

/// Longest path cost after each node, excluding it, in nanoseconds.
pub fn tails<C: Capacity>(dag: &Dag<C>, levels: &Levels<C>) -> C::Nodes<u64> {
    let mut tail = <C::Nodes<u64>>::EMPTY;
    levels.places().for_each(|i| tail[i] = levels.paths()[i] - dag.at(i).cost());
    tail
}

/// Longest path cost up to each node, including it, in nanoseconds.
pub fn heads<C: Capacity>(dag: &Dag<C>, levels: &Levels<C>) -> C::Nodes<u64> {
    let mut head = <C::Nodes<u64>>::EMPTY;
    for i in levels.places() {
        head[i] += dag.at(i).cost();
        let reached = head[i];
        dag.out(i).each(|j| head[j] = head[j].max(reached));
    }
    head
}

/// The critical path cost C*, in nanoseconds.
///
/// ```
/// use red_core::{Caps, Dag, Levels, Node, Wcet, critical_path};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// let a = dag.add_node(Node::new(Wcet::from_nanos(20)))?;
/// let b = dag.add_node(Node::new(Wcet::from_nanos(40)))?;
/// dag.add_edge(a, b)?;
/// assert_eq!(critical_path(&dag, &Levels::of(&dag)), 60);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn critical_path<C: Capacity>(dag: &Dag<C>, levels: &Levels<C>) -> u64 {
    dag.present().iter().map(|i| levels.paths()[i]).max().unwrap_or(0)
}
