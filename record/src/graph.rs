//! A graph from its parts, with every node in the place that it had: later entries name nodes by their places.

use crate::entry::Call;
use red_core::{Capacity, Dag, Node, NodeId, Wcet};

/// Nodes of a graph at most.
const NODES: usize = 256;
/// Words of 64 places each that hold every node.
const GROUPS: usize = NODES / 64;

/// What was read of the graph that the next call takes.
#[derive(Debug, Default)]
pub(crate) struct Parts {
    /// By place, as far as there are nodes.
    nodes: Vec<Option<Part>>,
}

/// A node and where its edges lead.
#[derive(Clone, Copy, Debug)]
struct Part {
    node: Node,
    to: [u64; GROUPS],
}

impl Parts {
    /// Takes what is a part, and gives out all of them to the call that needs them. `None`: this is no part of the graph so
    /// far, or a graph is begun and this call takes none.
    pub(crate) fn before(&mut self, call: &Call) -> Option<Self> {
        match *call {
            Call::Node { place, node } => self.add(place.index(), node)?,
            Call::Edges { from, group, to } => self.lead(from.index(), group.into(), to)?,
            Call::AddTask { .. } | Call::Commit { .. } => return Some(core::mem::take(self)),
            _ if !self.nodes.is_empty() => return None,
            _ => {}
        }
        Some(Self::default())
    }

    /// A node in a place that is free.
    fn add(&mut self, place: usize, node: Node) -> Option<()> {
        if self.nodes.len() <= place {
            // A place is a byte: at most NODES.
            self.nodes.resize(place + 1, None);
        }
        let free = self.nodes.get_mut(place).filter(|part| part.is_none())?;
        *free = Some(Part { node, to: [0; GROUPS] });
        Some(())
    }

    /// Edges of a node that is there, of a group that was not.
    fn lead(&mut self, from: usize, group: usize, to: u64) -> Option<()> {
        let part = self.nodes.get_mut(from)?.as_mut()?;
        let group = part.to.get_mut(group).filter(|group| **group == 0)?;
        *group = to;
        Some(())
    }

    /// The graph of these parts. `base` is what it was begun from: nodes that are as they were there stay in their places,
    /// new ones are only put where the host could have put them. `None`: no graph that was begun so has these parts.
    pub(crate) fn onto<C: Capacity>(&self, base: Dag<C>) -> Option<Dag<C>> {
        let mut dag = base;
        let mut missing = self.nodes.iter().flatten().count();
        for place in base.nodes() {
            base.successors(place).each(|to| _ = dag.remove_edge(place, NodeId::new(to as u8)));
            match self.at(place) {
                None => _ = dag.remove_node(place),
                Some(part) if base.node(place) == Some(&part.node) => missing -= 1,
                Some(_) => return None,
            }
        }
        let mut fillers = Vec::new();
        for place in free_places(dag) {
            if missing == 0 {
                break;
            }
            match self.at(place) {
                Some(part) => {
                    dag.add_node(part.node).ok().filter(|added| *added == place)?;
                    missing -= 1;
                }
                None => fillers.push(dag.add_node(FILLER).ok()?),
            }
        }
        if missing > 0 {
            return None;
        }
        fillers.into_iter().for_each(|filler| _ = dag.remove_node(filler));
        for (from, part) in (0..=u8::MAX).zip(&self.nodes) {
            for to in part.iter().flat_map(Part::successors) {
                dag.add_edge(NodeId::new(from), NodeId::new(to)).ok()?;
            }
        }
        Some(dag)
    }

    fn at(&self, place: NodeId) -> Option<&Part> {
        self.nodes.get(place.index())?.as_ref()
    }
}

impl Part {
    fn successors(&self) -> impl Iterator<Item = u8> {
        (0..=u8::MAX).filter(|to| self.to[usize::from(to / 64)] >> (to % 64) & 1 != 0)
    }
}

/// Holds a place and costs nothing.
const FILLER: Node = Node::new(Wcet::ZERO);

/// The places that a graph gives to new nodes, in its order. Which comes first depends on nodes that are gone, so it is
/// asked.
fn free_places<C: Capacity>(mut dag: Dag<C>) -> impl Iterator<Item = NodeId> {
    std::iter::from_fn(move || dag.add_node(FILLER).ok())
}

#[cfg(test)]
mod tests;
