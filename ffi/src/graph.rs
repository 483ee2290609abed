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

impl<C: Capacity> Graph for Dag<C> {
    fn any(&self) -> &dyn Any {
        self
    }

    fn add_node(&mut self, node: Node) -> Result<NodeId, red_status> {
        Ok(Self::add_node(self, of_class::<C>(node)?)?)
    }

    fn add_edge(&mut self, from: NodeId, to: NodeId) -> Result<(), EdgeError> {
        Self::add_edge(self, from, to)
    }

    fn remove_node(&mut self, node: NodeId) -> bool {
        Self::remove_node(self, node)
    }

    fn remove_edge(&mut self, from: NodeId, to: NodeId) -> bool {
        Self::remove_edge(self, from, to)
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
        let refined =
            refine(self, stage, of_class::<C>(encoder)?, parts.as_ref().get(..count).unwrap_or_default())
                .map_err(<red_status as From<RefineError>>::from)?;
        *self = refined.dag;
        Ok(refined.encoder)
    }

    fn node(&self, node: NodeId) -> Option<&Node> {
        Self::node(self, node)
    }

    fn successors(&self, node: NodeId, each: &mut dyn FnMut(NodeId)) {
        Self::successors(self, node).iter().for_each(|i| each(NodeId::new(i as u8)));
    }

    fn summary(&self) -> Summary {
        let levels = Levels::of(self);
        Summary {
            nodes: self.len(),
            levels: levels.count(),
            work_ns: self.work(),
            critical_path_ns: levels.critical_path(),
        }
    }

    fn place(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8], each: &mut dyn FnMut(Placed)) {
        let levels = Levels::of(self);
        let due = SubDeadlines::assign(&levels, rule, deadline, lanes);
        for node in Self::nodes(self) {
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
        let levels = Levels::of(self);
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
        response_time(&Levels::of(self), limit, lanes, budgets)
    }
}
