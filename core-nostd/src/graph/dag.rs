//! A directed acyclic graph of at most `C::NODES` nodes.

use super::{Node, NodeSet, Role};
use crate::capacity::{Capacity, Empty};
use crate::id::{NodeId, TaskId};

crate::capacity::stored! {
    /// A graph under construction, and the graph of a task.
    ///
    /// ```
    /// use red_core::{Caps, Dag, EdgeError, Node, Wcet};
    /// let mut dag = Dag::<Caps<1, 8, 1>>::new();
    /// let camera = dag.add_node(Node::new(Wcet::from_millis(2)))?;
    /// let control = dag.add_node(Node::new(Wcet::from_millis(3)))?;
    /// dag.add_edge(camera, control)?;
    /// assert_eq!(dag.add_edge(control, camera), Err(EdgeError::Cycle));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Clone, Copy, Debug)]
    pub struct Dag<C: Capacity> {
        nodes: C::Nodes<Node>,
        successors: C::Nodes<NodeSet<C>>,
        /// Number of predecessors.
        pub(crate) indegree: C::Nodes<u8>,
        pub(crate) present: NodeSet<C>,
        /// Places that an older version of the task's graph still uses, and one more than the highest place ever
        /// used: new nodes come after all others, so that the tie rule "by node index" means "by age".
        pub(crate) taken: NodeSet<C>,
        pub(crate) end: u16,
        /// The task whose graph it was, and after which of its commits; 0 where `edit` did not make it.
        pub(crate) task: TaskId,
        pub(crate) revision: u32,
        work: u64,
    }
}

crate::error::errors! {
    /// A node could not be added. The graph is unchanged.
    pub enum NodeError {
        /// All `C::NODES` places are taken: the host needs a larger capacity.
        Full,
        /// The sum of all costs would overflow 64 bits: the node's cost is not a time.
        WorkOverflow,
    }

    /// An edge could not be added. The graph is unchanged.
    pub enum EdgeError {
        /// The edge would close a cycle (a self edge is the shortest): the host's graph is not a DAG.
        Cycle,
        /// The edge is there already.
        Duplicate,
        /// A decoder reads the result of one encoder: let a node that fuses several be an ordinary one.
        SecondEncoder,
        /// One of the two nodes is not in this graph.
        UnknownNode,
    }
}

impl<C: Capacity> Dag<C> {
    /// A graph without nodes.
    #[expect(clippy::new_without_default, reason = "nothing is generic over it")]
    pub const fn new() -> Self {
        Self::EMPTY
    }

    /// Adds a node. Time bound: O(1). Errors: [`NodeError::Full`], [`NodeError::WorkOverflow`].
    pub fn add_node(&mut self, node: Node) -> Result<NodeId, NodeError> {
        let end = usize::from(self.end);
        let mut places = (end..C::NODES).chain(0..end.min(C::NODES));
        let is_free = |i: &usize| !self.present.contains(*i) && !self.taken.contains(*i);
        let place = places.find(is_free).ok_or(NodeError::Full)?;
        let cost = node.wcet.as_nanos().checked_add(node.contention.as_nanos());
        self.work = cost.and_then(|c| self.work.checked_add(c)).ok_or(NodeError::WorkOverflow)?;
        self.nodes[place] = node;
        self.successors[place] = NodeSet::EMPTY;
        self.present.insert(place);
        self.end = self.end.max(place as u16 + 1);
        Ok(NodeId::new(place as u8))
    }

    /// Adds an edge. Time bound: O(nodes). Errors: [`EdgeError`]; a cycle is found before the edge exists.
    pub fn add_edge(&mut self, from: NodeId, to: NodeId) -> Result<(), EdgeError> {
        if !self.contains(from) || !self.contains(to) {
            return Err(EdgeError::UnknownNode);
        }
        if self.successors[from.index()].contains(to.index()) {
            return Err(EdgeError::Duplicate);
        }
        if from == to || self.reaches(to, from) {
            return Err(EdgeError::Cycle);
        }
        let encodes = |i: usize| matches!(self.nodes[i].role, Role::SharedEncoder(_));
        let mut before = self.present.iter().filter(|i| self.successors[*i].contains(to.index()));
        let decodes = self.nodes[to.index()].role == Role::Decoder;
        if decodes && encodes(from.index()) && before.any(encodes) {
            return Err(EdgeError::SecondEncoder);
        }
        self.successors[from.index()].insert(to.index());
        self.indegree[to.index()] += 1;
        Ok(())
    }

    /// Removes an edge; `false` if there was none.
    pub fn remove_edge(&mut self, from: NodeId, to: NodeId) -> bool {
        let there = self.contains(to) && self.successors(from).contains(to.index());
        if there {
            self.successors[from.index()].remove(to.index());
            self.indegree[to.index()] -= 1;
        }
        there
    }

    /// Removes a node and its edges; `false` if there was none. Time bound: O(nodes).
    pub fn remove_node(&mut self, node: NodeId) -> bool {
        let there = self.contains(node);
        if there {
            self.present.remove(node.index());
            self.work -= self.nodes[node.index()].cost();
            self.present.each(|i| self.successors[i].remove(node.index()));
            self.indegree[node.index()] = 0;
            let row = core::mem::replace(&mut self.successors[node.index()], NodeSet::EMPTY);
            row.each(|j| self.indegree[j] -= 1);
        }
        there
    }

    /// Whether `node` is in this graph.
    pub fn contains(&self, node: NodeId) -> bool {
        node.index() < C::NODES && self.present.contains(node.index())
    }

    /// The node's data, if it is in this graph.
    pub fn node(&self, node: NodeId) -> Option<&Node> {
        self.contains(node).then(|| &self.nodes[node.index()])
    }

    /// Node ids, smallest first.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> + use<C> {
        self.present.iter().map(|i| NodeId::new(i as u8))
    }

    /// Direct successors of a node.
    pub fn successors(&self, node: NodeId) -> NodeSet<C> {
        if self.contains(node) { self.successors[node.index()] } else { NodeSet::EMPTY }
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.present.len()
    }

    /// Whether there is no node.
    pub fn is_empty(&self) -> bool {
        self.present.is_empty()
    }

    /// Sum of all costs in nanoseconds; it cannot overflow.
    pub const fn work(&self) -> u64 {
        self.work
    }

    /// What `commit` compares: whose graph `edit` took, and after how many commits; 0 where that did not make it.
    pub const fn origin(&self) -> (TaskId, u32) {
        (self.task, self.revision)
    }

    pub(crate) fn at(&self, place: usize) -> &Node {
        &self.nodes[place]
    }

    pub(crate) fn out(&self, place: usize) -> &NodeSet<C> {
        &self.successors[place]
    }

    /// A graph from nodes in the given places and edges by number in that list.
    pub(crate) fn restore(
        nodes: &C::Nodes<Node>,
        places: &C::Nodes<u8>,
        len: usize,
        successors: &C::Nodes<NodeSet<C>>,
    ) -> Self {
        let mut dag = Self::EMPTY;
        for i in 0..len {
            let place = usize::from(places[i]);
            dag.nodes[place] = nodes[place];
            dag.present.insert(place);
            dag.end = dag.end.max(place as u16 + 1);
            dag.work += nodes[place].cost();
            successors[i].each(|j| {
                let to = usize::from(places[j]);
                dag.successors[place].insert(to);
                dag.indegree[to] += 1;
            });
        }
        dag
    }

    fn reaches(&self, from: NodeId, to: NodeId) -> bool {
        let mut seen = NodeSet::<C>::EMPTY;
        seen.insert(from.index());
        let mut open = seen;
        // At most C::NODES rounds: each takes one node out of `open`, and a node enters it once.
        while let Some(i) = open.first_in(&seen) {
            open.remove(i);
            let fresh = self.successors[i].without(&seen);
            if fresh.contains(to.index()) {
                return true;
            }
            seen.extend(&fresh);
            open.extend(&fresh);
        }
        false
    }
}

#[cfg(test)]
mod tests;
