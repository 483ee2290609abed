//! Edits of a live graph: nodes and edges come and go in one commit, refused whole or applied whole.
//!
//! *Rule.* Jobs in flight keep the graph of their release; jobs released after the commit have the new one. A
//! task holds two versions; while the older one still has jobs, a third is `Busy`, and the host commits it when
//! that version has drained. A node's place is not reused while a version has it.

use super::{Scheduler, event::EventKind, tasks::AddTaskError};
use crate::analysis::Certificate;
use crate::capacity::Capacity;
use crate::graph::{Dag, Levels};
use crate::id::TaskId;
use crate::time::Instant;

crate::error::errors! {
    /// A commit was refused. The task keeps its graph.
    pub enum CommitError {
        /// The task is not admitted, or was removed.
        UnknownTask,
        /// Another commit came after `edit`, or the graph is not from there: begin again from the graph as it is.
        Conflict,
        /// The version before the current one still has jobs: commit again when it has drained.
        Busy,
        /// The new graph has no node.
        Empty,
        /// A node names a pool that does not exist.
        UnknownPool,
        /// An encoder names a sensor that does not exist.
        UnknownSensor,
        /// A node, or an encoder and one of its decoders together, needs more memory than its pool has.
        Memory,
        /// Under `Admission::Enforce`: the certificate does not fit.
        Unschedulable,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Begins an edit: the task's newest graph, to be changed and given to [`commit`](Self::commit). Dropping it
    /// changes nothing. `None`: the task is not admitted. Time bound: O(nodes + edges).
    ///
    /// ```
    /// use red_core::{Caps, Config, Dag, Duration, Instant, Node, Scheduler, Timing, Wcet};
    /// let mut dag = Dag::<Caps<1, 8, 4>>::new();
    /// let camera = dag.add_node(Node::new(Wcet::from_millis(2)))?;
    /// let control = dag.add_node(Node::new(Wcet::from_millis(3)))?;
    /// dag.add_edge(camera, control)?;
    /// let mut scheduler = Scheduler::new(Config::REDRT);
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
    #[must_use]
    pub fn edit(&self, task: TaskId) -> Option<Dag<C>> {
        let t = &self.tasks[self.task_slot(task)?];
        let mut dag = t.versions[usize::from(t.current)].dag(&t.nodes);
        (dag.taken, dag.end, dag.task, dag.revision) = (t.taken(), t.end, task, t.revision);
        Some(dag)
    }

    /// Applies an edit to jobs released from now on. Time bound: O(nodes log nodes + edges) and the certificate,
    /// O(lanes * (nodes + edges)). Errors: [`CommitError`].
    pub fn commit(&mut self, edit: &Dag<C>, now: Instant) -> Result<Certificate, CommitError> {
        let t = self.task_slot(edit.task).ok_or(CommitError::UnknownTask)?;
        let task = &self.tasks[t];
        if task.revision != edit.revision {
            return Err(CommitError::Conflict);
        }
        if task.versions[usize::from(!task.current)].users > 0 {
            return Err(CommitError::Busy);
        }
        let levels = Levels::of(edit);
        let proof = self.admit(&levels, &task.timing).map_err(|e| match e {
            AddTaskError::Empty => CommitError::Empty,
            AddTaskError::UnknownPool => CommitError::UnknownPool,
            AddTaskError::UnknownSensor => CommitError::UnknownSensor,
            AddTaskError::Unschedulable => CommitError::Unschedulable,
            _ => CommitError::Memory,
        })?;
        self.advance(now);
        self.reopen();
        let lanes = self.lanes_by_pool();
        self.tasks[t].install(&levels, &self.config, lanes.as_ref());
        self.find_blocked();
        self.note_task(EventKind::Edited, t, 0);
        Ok(proof)
    }
}
