//! A graph of any class.

use crate::status::red_status;
use core::any::Any;
use red_core::{
    Bytes, Capacity, Certificate, Dag, DeadlineRule, Duration, EdgeError, Levels, Node, NodeId, RefineError,
    SubDeadlines, refine, response_time, shares,
};

/// Nodes of the largest class.
pub(crate) const MOST_NODES: usize = 256;
/// Pools of the largest class.
pub(crate) const MOST_POOLS: usize = 32;

/// What the levels of a graph say as a whole.
pub(crate) struct Summary {
    pub(crate) nodes: usize,
    pub(crate) levels: usize,
    pub(crate) work_ns: u64,
    pub(crate) critical_path_ns: u64,
}

/// What the levels and a rule say of a node.
pub(crate) struct Placed {
    pub(crate) node: NodeId,
    pub(crate) height: usize,
    pub(crate) tail_ns: u64,
    pub(crate) sub_deadline_ns: i64,
    pub(crate) key_ns: i64,
}

/// What a level gets of a deadline.
pub(crate) struct Share {
    pub(crate) cost_ns: u64,
    pub(crate) graham_ns: u64,
    pub(crate) share_ns: u64,
    pub(crate) end_ns: u64,
}

/// A graph behind a handle.
pub(crate) type AnyGraph = dyn Graph;

/// A node whose pool the class has: bounds and shares are by pool, and a schedule could not be.
fn of_class<C: Capacity>(node: Node) -> Result<Node, red_status> {
    if node.pool().index() < C::POOLS { Ok(node) } else { Err(red_status::UnknownPool) }
}

/// The calls of a [`Dag`], whatever its capacity is.
pub(crate) trait Graph {
    fn any(&self) -> &dyn Any;
    /// See [`Held::begun_on`].
    fn begun_on(&self) -> u64;
    fn add_node(&mut self, node: Node) -> Result<NodeId, red_status>;
    fn add_edge(&mut self, from: NodeId, to: NodeId) -> Result<(), EdgeError>;
    fn remove_node(&mut self, node: NodeId) -> bool;
    fn remove_edge(&mut self, from: NodeId, to: NodeId) -> bool;
    /// The encoder's node. `decoders` gives them by their number.
    fn refine(
        &mut self,
        stage: NodeId,
        encoder: Node,
        decoders: &mut dyn ExactSizeIterator<Item = Result<Node, red_status>>,
    ) -> Result<NodeId, red_status>;
    fn node(&self, node: NodeId) -> Option<&Node>;
    fn successors(&self, node: NodeId, each: &mut dyn FnMut(NodeId));
    fn summary(&self) -> Summary;
    fn place(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8], each: &mut dyn FnMut(Placed));
    fn share(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8], each: &mut dyn FnMut(Share));
    fn prove(&self, limit: Duration, lanes: &[u8], budgets: &[Option<Bytes>]) -> Certificate;
}

/// A graph in memory of C's.
pub(crate) struct Held<C: Capacity> {
    pub(crate) dag: Dag<C>,
    /// The handle of the scheduler or runtime that an edit was begun on: tasks have the same names on others. 0: no edit.
    pub(crate) begun_on: u64,
}

impl AnyGraph {
    /// Whether an edit may be committed there; whether a graph is one is for the scheduler to say.
    pub(crate) fn may_change(&self, bits: u64) -> Result<(), red_status> {
        if [0, bits].contains(&self.begun_on()) { Ok(()) } else { Err(red_status::Conflict) }
    }
}

impl<C: Capacity> Graph for Held<C> {
    fn any(&self) -> &dyn Any {
        &self.dag
    }

    fn begun_on(&self) -> u64 {
        self.begun_on
    }

    fn add_node(&mut self, node: Node) -> Result<NodeId, red_status> {
        Ok(self.dag.add_node(of_class::<C>(node)?)?)
    }

    fn add_edge(&mut self, from: NodeId, to: NodeId) -> Result<(), EdgeError> {
        self.dag.add_edge(from, to)
    }

    fn remove_node(&mut self, node: NodeId) -> bool {
        self.dag.remove_node(node)
    }

    fn remove_edge(&mut self, from: NodeId, to: NodeId) -> bool {
        self.dag.remove_edge(from, to)
    }

    fn refine(
        &mut self,
        stage: NodeId,
        encoder: Node,
        decoders: &mut dyn ExactSizeIterator<Item = Result<Node, red_status>>,
    ) -> Result<NodeId, red_status> {
        let mut parts = <C::Nodes<Node> as red_core::Empty>::EMPTY;
        let count = decoders.len();
        let room = parts.as_mut().get_mut(..count).ok_or(red_status::NodesFull)?;
        for (part, decoder) in room.iter_mut().zip(decoders) {
            *part = of_class::<C>(decoder?)?;
        }
        let refined = refine(
            &self.dag,
            stage,
            of_class::<C>(encoder)?,
            parts.as_ref().get(..count).unwrap_or_default(),
        )
        .map_err(<red_status as From<RefineError>>::from)?;
        self.dag = refined.dag;
        Ok(refined.encoder)
    }

    fn node(&self, node: NodeId) -> Option<&Node> {
        self.dag.node(node)
    }

    fn successors(&self, node: NodeId, each: &mut dyn FnMut(NodeId)) {
        self.dag.successors(node).iter().for_each(|i| each(NodeId::new(i as u8)));
    }

    fn summary(&self) -> Summary {
        let levels = Levels::of(&self.dag);
        Summary {
            nodes: self.dag.len(),
            levels: levels.count(),
            work_ns: self.dag.work(),
            critical_path_ns: levels.critical_path(),
        }
    }

    fn place(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8], each: &mut dyn FnMut(Placed)) {
        let levels = Levels::of(&self.dag);
        let due = SubDeadlines::assign(&levels, rule, deadline, lanes);
        for node in self.dag.nodes() {
            each(Placed {
                node,
                height: levels.height(node),
                tail_ns: levels.tail(node),
                sub_deadline_ns: due.sub_deadline(node),
                key_ns: due.key(node),
            });
        }
    }

    fn share(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8], each: &mut dyn FnMut(Share)) {
        let levels = Levels::of(&self.dag);
        let shares = shares(&levels, rule, deadline, lanes);
        for level in shares.as_ref().iter().take(levels.count()) {
            each(Share {
                cost_ns: level.cost,
                graham_ns: level.graham,
                share_ns: level.share,
                end_ns: level.end,
            });
        }
    }

    fn prove(&self, limit: Duration, lanes: &[u8], budgets: &[Option<Bytes>]) -> Certificate {
        response_time(&Levels::of(&self.dag), limit, lanes, budgets)
    }
}
