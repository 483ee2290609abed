//! Graph changes in numbers, and how they are applied to a live scheduler.

use red_core::{Capacity, CommitError, Instant, Node, NodeId, Scheduler, TaskId};

/// A change of a task's graph: all its events of one instant, which make one version.
#[derive(Clone, Debug)]
pub struct Change {
    /// When.
    pub at: Instant,
    /// Which task, in file order.
    pub task: usize,
    /// The events, in file order.
    pub steps: Vec<Step>,
}

/// One event, in numbers: removals come before additions.
#[derive(Clone, Debug, Default)]
pub struct Step {
    /// Nodes that disappear.
    pub removed: Vec<NodeId>,
    /// Nodes that appear, with the numbers that they get.
    pub added: Vec<(NodeId, Node)>,
    /// Edges that appear.
    pub edges: Vec<(NodeId, NodeId)>,
}

/// Applies a change to a live scheduler. Allocates nothing.
///
/// # Errors
/// `Busy`: two versions of the graph are in use, try again when one has drained. Others only where the change
/// was not made for this scheduler.
pub fn apply<C: Capacity>(
    scheduler: &mut Scheduler<C>,
    change: &Change,
    task: TaskId,
    now: Instant,
) -> Result<(), CommitError> {
    let mut edit = scheduler.edit(task).ok_or(CommitError::UnknownTask)?;
    for step in &change.steps {
        for node in &step.removed {
            edit.remove_node(*node);
        }
        for (number, node) in &step.added {
            if edit.add_node(*node) != Ok(*number) {
                return Err(CommitError::Conflict);
            }
        }
        for (from, to) in &step.edges {
            edit.add_edge(*from, *to).map_err(|_| CommitError::Conflict)?;
        }
    }
    scheduler.commit(&edit, now).map(drop)
}
