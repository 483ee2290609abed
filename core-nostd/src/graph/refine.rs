//! MIMONet refinement (paper Def. 6 and Alg. 1): a stage becomes one shared encoder and its decoders.
//!
//! *Rule.* The stage's place is taken by the encoder and then the decoders, later nodes move up; edges into the
//! stage lead to the encoder, edges out of it leave every decoder. The listing in the paper drops the edges.

use super::{Dag, Node, NodeError};
use crate::capacity::{Capacity, Empty};
use crate::id::NodeId;

/// A refined graph and where the stage's parts are. Decoder `j` is node `encoder + 1 + j`.
#[derive(Clone, Copy, Debug)]
pub struct Refined<C: Capacity> {
    /// The new graph.
    pub dag: Dag<C>,
    /// The encoder; nodes before it kept their ids.
    pub encoder: NodeId,
}

crate::error::errors! {
    /// A stage could not be refined. The given graph is unchanged.
    pub enum RefineError {
        /// The stage is not in this graph.
        UnknownNode,
        /// A stage needs at least one decoder.
        NoDecoder,
        /// More nodes than the capacity.
        Full,
        /// The sum of all costs would overflow 64 bits.
        WorkOverflow,
    }
}

/// Replaces `stage` by `encoder` and `decoders`; nodes move, so it is no edit. Time bound: O(nodes + edges * decoders).
///
/// # Errors
/// [`RefineError`].
///
/// ```
/// use red_core::{Caps, Dag, Frame, Node, Wcet, refine};
/// let mut coarse = Dag::<Caps<1, 8, 1>>::new();
/// let stage = coarse.add_node(Node::new(Wcet::from_millis(22)))?;
/// let encoder = Node::shared_encoder(Wcet::from_millis(12), Frame { weights: 0, frame: 0, sensor: None });
/// let decoder = Node::decoder(Wcet::from_millis(5));
/// let refined = refine(&coarse, stage, encoder, &[decoder, decoder])?;
/// assert_eq!(refined.dag.successors(refined.encoder).len(), 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refine<C: Capacity>(
    dag: &Dag<C>,
    stage: NodeId,
    encoder: Node,
    decoders: &[Node],
) -> Result<Refined<C>, RefineError> {
    if !dag.contains(stage) {
        return Err(RefineError::UnknownNode);
    }
    if decoders.is_empty() {
        return Err(RefineError::NoDecoder);
    }
    let full = |e| match e {
        NodeError::Full => RefineError::Full,
        NodeError::WorkOverflow => RefineError::WorkOverflow,
    };
    let mut new = Dag::new();
    // Where each old node is now; of the stage, its encoder.
    let mut place = <C::Nodes<u8>>::EMPTY;
    for old in dag.nodes() {
        let (node, more) = if old == stage { (&encoder, decoders) } else { (dag.at(old.index()), &[][..]) };
        place[old.index()] = new.add_node(*node).map_err(full)?.index() as u8;
        more.iter().try_for_each(|decoder| new.add_node(*decoder).map(drop).map_err(full))?;
    }
    let first = place[stage.index()];
    let parts = first + 1..=first + decoders.len() as u8;
    // The old graph was acyclic and the splice keeps its order, so no edge is refused.
    let mut link = |from: u8, to: u8| {
        let _added = new.add_edge(NodeId::new(from), NodeId::new(to));
    };
    parts.clone().for_each(|part| link(first, part));
    for from in dag.nodes() {
        let alone = place[from.index()];
        let ends = if from == stage { parts.clone() } else { alone..=alone };
        dag.successors(from).each(|to| ends.clone().for_each(|end| link(end, place[to])));
    }
    Ok(Refined { dag: new, encoder: NodeId::new(first) })
}
