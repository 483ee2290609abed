//! Parts of the model together with their places in the file, for the checks that look at several of them.

use super::task::Load;
use crate::model::{Event, Node, Task, Work};

/// A node whose names are not resolved yet.
#[derive(Debug)]
pub(crate) struct PlacedNode {
    /// Offset of the name.
    pub(crate) at: usize,
    pub(crate) node: Node,
    /// Offset of each name in the node's `after`.
    pub(crate) after_at: Vec<usize>,
    /// Offset of each name in the node's `before`.
    pub(crate) before_at: Vec<usize>,
    /// Offset of the body of each part, in the order of execution; of the part where it has no body.
    pub(crate) bodies_at: Vec<usize>,
}

impl PlacedNode {
    /// Names of the parts, in the order of execution: none for an ordinary node.
    pub(crate) fn part_names(&self) -> impl Iterator<Item = &str> {
        let decoders = match &self.node.work {
            Work::Plain(_) => None,
            Work::Stage(stage) => Some(&stage.decoders),
        };
        decoders.into_iter().flat_map(|decoders| {
            std::iter::once("encoder").chain(decoders.iter().map(|(name, _)| name.as_str()))
        })
    }
}

/// A task whose nodes stand beside it.
#[derive(Debug)]
pub(crate) struct PlacedTask {
    pub(crate) task: Task,
    /// The cluster that it names.
    pub(super) cluster: Option<String>,
    pub(crate) nodes: Vec<PlacedNode>,
    pub(super) load: Load,
}

impl PlacedTask {
    pub(crate) fn into_model(self) -> Task {
        Task { nodes: self.nodes.into_iter().map(|placed| placed.node).collect(), ..self.task }
    }
}

/// An event whose added nodes stand beside it.
#[derive(Debug)]
pub(crate) struct PlacedEvent {
    pub(crate) event: Event,
    pub(crate) add: Vec<PlacedNode>,
    /// Offset of each name in the event's `remove`.
    pub(crate) remove_at: Vec<usize>,
}

impl PlacedEvent {
    pub(crate) fn into_model(self) -> Event {
        Event { add: self.add.into_iter().map(|placed| placed.node).collect(), ..self.event }
    }
}
