//! Edits of a live graph: nodes and edges come and go in one commit, refused whole or applied whole.
//!
//! *Rule.* Jobs in flight keep the graph of their release; jobs released after the commit have the new one. A
//! task holds two versions; while the older one still has jobs, a third is `Busy`, and the host commits it when
//! that version has drained. A node's place is not reused while a version has it.

use super::Scheduler;
use super::event::EventKind;
use super::tasks::AddTaskError;
use crate::analysis::Certificate;
use crate::capacity::Capacity;
use crate::config::Admission;
use crate::graph::{Dag, EdgeError, Levels, Node, NodeError, NodeSet};
use crate::id::{NodeId, TaskId};
use crate::time::Instant;

/// A new graph for a task, made outside of the scheduler: dropping it changes nothing.
///
/// ```
/// use red_core::{Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
/// type Robot = Caps<1, 8, 4>;
/// let mut dag = Dag::<Robot>::new();
/// let camera = dag.add_node(Node::new(Wcet::from_millis(2)))?;
/// let control = dag.add_node(Node::new(Wcet::from_millis(3)))?;
/// dag.add_edge(camera, control)?;
/// let mut scheduler = Scheduler::<Robot>::new(Config::REDRT);
/// let cruise = scheduler.add_task(&dag, Timing::new(Duration::from_millis(50)))?;
///
/// let mut edit = scheduler.edit(cruise).expect("the task is there");
/// let obstacle = edit.add_node(Node::new(Wcet::from_millis(25)))?;
/// edit.add_edge(camera, obstacle)?;
/// edit.add_edge(obstacle, control)?;
/// let admission = scheduler.commit(&edit, Instant::ZERO)?;
/// assert!(admission.fits(), "needs {:?} more", admission.margin());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Edit<C: Capacity> {
    task: TaskId,
    revision: u32,
    dag: Dag<C>,
    /// Places that an older version in use still has.
    taken: NodeSet<C>,
}

crate::error::errors! {
    /// A commit was refused. The task keeps its graph.
    pub enum CommitError {
        /// The task is not admitted, or was removed.
        UnknownTask,
        /// Another commit came between `edit` and this one: begin again from the graph as it is now.
        Conflict,
        /// The version before the current one still has jobs: commit again when it has drained.
        Busy,
        /// The new graph has no node.
        Empty,
        /// A node names a pool that does not exist.
        UnknownPool,
        /// A node, or an encoder and one of its decoders together, needs more memory than its pool has.
        Memory,
        /// Under `Admission::Enforce`: the certificate does not fit.
        Unschedulable,
    }
}

impl<C: Capacity> Edit<C> {
    /// Adds a node.
    ///
    /// # Errors
    /// As [`Dag::add_node`]; places of nodes that jobs in flight still have count as taken.
    pub fn add_node(&mut self, node: Node) -> Result<NodeId, NodeError> {
        self.dag.add_node_avoiding(node, &self.taken)
    }

    /// Adds an edge.
    ///
    /// # Errors
    /// As [`Dag::add_edge`].
    pub fn add_edge(&mut self, from: NodeId, to: NodeId) -> Result<(), EdgeError> {
        self.dag.add_edge(from, to)
    }

    /// Removes a node and its edges; `false` if there was none.
    pub fn remove_node(&mut self, node: NodeId) -> bool {
        self.dag.remove_node(node)
    }

    /// Removes an edge; `false` if there was none.
    pub fn remove_edge(&mut self, from: NodeId, to: NodeId) -> bool {
        self.dag.remove_edge(from, to)
    }

    /// The graph as it would be.
    pub const fn dag(&self) -> &Dag<C> {
        &self.dag
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Begins an edit of a task's newest graph. `None`: the task is not admitted. Time bound: O(nodes + edges).
    #[must_use]
    pub fn edit(&self, task: TaskId) -> Option<Edit<C>> {
        let t = &self.tasks[self.task_slot(task)?];
        let current = usize::from(t.current);
        let mut taken = t.versions[current].nodes();
        if t.versions[1 - current].users > 0 {
            taken.extend(&t.versions[1 - current].nodes());
        }
        Some(Edit {
            task,
            revision: t.revision,
            dag: t.versions[current].dag(&t.nodes).with_end(t.end),
            taken,
        })
    }

    /// Applies an edit to jobs released from now on. Time bound: O(nodes log nodes + edges) and the certificate,
    /// O(lanes * (nodes + edges)).
    ///
    /// # Errors
    /// [`CommitError`].
    pub fn commit(&mut self, edit: &Edit<C>, now: Instant) -> Result<Certificate, CommitError> {
        let t = self.check_commit(edit)?;
        let (deadline, period) = (self.tasks[t].deadline, self.tasks[t].period);
        let levels = Levels::of(&edit.dag);
        let proof = self.prove(&edit.dag, &levels, deadline, period);
        if self.config.admission == Admission::Enforce && !proof.fits() {
            return Err(CommitError::Unschedulable);
        }
        self.advance(now);
        let lanes = self.lanes_by_pool();
        let task = &mut self.tasks[t];
        task.install(&edit.dag, &task.versions[usize::from(task.current)].nodes());
        // A version without jobs is replaced in place; else the other one becomes current.
        if task.versions[usize::from(task.current)].users > 0 {
            task.current = 1 - task.current;
        }
        let version = &mut task.versions[usize::from(task.current)];
        version.lay_out(&edit.dag, &levels, &self.config, deadline, proof.critical_path, &lanes);
        self.note_task(EventKind::Edited, t, 0);
        Ok(proof)
    }

    fn check_commit(&self, edit: &Edit<C>) -> Result<usize, CommitError> {
        let t = self.task_slot(edit.task).ok_or(CommitError::UnknownTask)?;
        let task = &self.tasks[t];
        if task.revision != edit.revision {
            return Err(CommitError::Conflict);
        }
        if task.versions[1 - usize::from(task.current)].users > 0 {
            return Err(CommitError::Busy);
        }
        self.check_graph(&edit.dag).map_err(|e| match e {
            AddTaskError::Empty => CommitError::Empty,
            AddTaskError::UnknownPool => CommitError::UnknownPool,
            _ => CommitError::Memory,
        })?;
        Ok(t)
    }
}
