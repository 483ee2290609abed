//! The table of admitted tasks.

use super::Scheduler;
use super::action::ShedReason;
use super::jobs::Job;
use super::version::Version;
use crate::analysis::{Certificate, Demand};
use crate::capacity::{Capacity, Empty};
use crate::config::Admission;
use crate::deadlines::Estimator;
use crate::graph::{Dag, Levels, Node, NodeSet};
use crate::id::{NodeId, PoolId, TaskId};
use crate::policy::Floor;
use crate::time::Duration;

/// Longest deadline: 2^62 ns, so that every key fits 64 signed bits.
const LONGEST_DEADLINE: u64 = 1 << 62;

/// When a task's jobs come and are due, and what they are worth.
///
/// ```
/// use red_core::{Duration, Timing};
/// let timing = Timing::new(Duration::from_millis(120)).every(Duration::from_millis(100)).value(10).floor(3, 4);
/// # let _ = timing;
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    deadline: Duration,
    period: Option<Duration>,
    value: u32,
    floor: Floor,
}

impl Timing {
    /// Jobs due `deadline` after their release, at no declared rate, of value 1.
    pub const fn new(deadline: Duration) -> Self {
        Self { deadline, period: None, value: 1, floor: Floor::EMPTY }
    }

    /// With a period, or a minimum inter-arrival time; admission uses it.
    #[must_use]
    pub const fn every(self, period: Duration) -> Self {
        Self { period: Some(period), ..self }
    }

    /// With a declared value: higher survives overload longer.
    #[must_use]
    pub const fn value(self, value: u32) -> Self {
        Self { value, ..self }
    }

    /// With a floor: at least `m` of any `k` consecutive jobs are never shed by choice.
    #[must_use]
    pub const fn floor(self, m: u32, k: u32) -> Self {
        Self { floor: Floor::new(m, k), ..self }
    }
}

crate::error::errors! {
    /// A task could not be admitted. Nothing changed.
    pub enum AddTaskError {
        /// Every task place of the capacity is taken.
        Full,
        /// The graph has no node.
        Empty,
        /// The deadline is 0 or above 2^62 ns.
        Deadline,
        /// A node names a pool that does not exist.
        UnknownPool,
        /// A node, or an encoder and one of its decoders together, needs more memory than its pool has.
        Memory,
        /// Under `Admission::Enforce`: the certificate does not fit.
        Unschedulable,
    }
}

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Task<C: Capacity> {
        pub(super) admitted: bool,
        /// The version that new jobs get.
        pub(super) current: u8,
        pub(super) generation: u16,
        pub(super) value: u32,
        pub(super) deadline: Duration,
        pub(super) period: Option<Duration>,
        pub(super) next_job: u64,
        /// One more than the highest node place ever used.
        pub(super) end: u16,
        /// Counts commits, so that an edit knows whether another came between.
        pub(super) revision: u32,
        pub(super) floor: Floor,
        pub(super) versions: [Version<C>; 2],
        /// By node id; a place belongs to one node as long as a version uses it.
        pub(super) nodes: C::Nodes<Node>,
        pub(super) estimates: C::Nodes<Estimator>,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Admits a task after the others; its certificate is [`certificate`](Self::certificate). Time bound:
    /// O(lanes * (nodes + edges) + nodes log nodes).
    ///
    /// # Errors
    /// [`AddTaskError`].
    pub fn add_task(&mut self, dag: &Dag<C>, timing: Timing) -> Result<TaskId, AddTaskError> {
        let deadline = timing.deadline.as_nanos();
        if deadline == 0 || deadline > LONGEST_DEADLINE {
            return Err(AddTaskError::Deadline);
        }
        self.check_graph(dag)?;
        let slot = (0..C::TASKS).find(|t| !self.tasks[*t].admitted).ok_or(AddTaskError::Full)?;
        let levels = Levels::of(dag);
        let proof = self.prove(dag, &levels, timing.deadline, timing.period);
        if self.config.admission == Admission::Enforce && !proof.fits() {
            return Err(AddTaskError::Unschedulable);
        }
        let lanes = self.lanes_by_pool();
        let task = &mut self.tasks[slot];
        task.admitted = true;
        task.current = 0;
        task.value = timing.value;
        task.deadline = timing.deadline;
        task.period = timing.period;
        task.next_job = 0;
        task.end = 0;
        task.revision = 0;
        task.floor = timing.floor;
        task.versions = [Version::EMPTY; 2];
        task.install(dag, &NodeSet::EMPTY);
        let [first, _] = &mut task.versions;
        first.lay_out(dag, &levels, &self.config, timing.deadline, proof.critical_path, &lanes);
        Ok(TaskId::new(slot, self.tasks[slot].generation))
    }

    /// Removes a task; its jobs in flight are given up with the reason `removed`. `false` if it is not there.
    pub fn remove_task(&mut self, task: TaskId, now: crate::time::Instant) -> bool {
        let Some(t) = self.task_slot(task) else { return false };
        self.advance(now);
        for slot in self.slots() {
            if self.jobs[slot].task.index() == t {
                self.end_job(slot, Some(ShedReason::Removed));
            }
        }
        self.tasks[t].admitted = false;
        self.tasks[t].generation = self.tasks[t].generation.wrapping_add(1);
        true
    }

    /// The bound on the response time of the task's newest graph, alone on its pools.
    #[must_use]
    pub fn certificate(&self, task: TaskId) -> Option<Certificate> {
        let t = &self.tasks[self.task_slot(task)?];
        let dag = t.versions[usize::from(t.current)].dag(&t.nodes);
        Some(self.prove(&dag, &Levels::of(&dag), t.deadline, t.period))
    }

    /// What the admitted tasks ask of a pool, for [`utilisation_slack`](crate::utilisation_slack).
    pub fn demands(&self, pool: PoolId) -> impl Iterator<Item = Demand> + '_ {
        self.tasks.as_ref().iter().filter(|t| t.admitted).map(move |t| {
            let dag = t.versions[usize::from(t.current)].dag(&t.nodes);
            let work = dag.nodes().filter_map(|n| dag.node(n).copied()).filter(|n| n.pool == pool);
            Demand { work: Duration::from_nanos(work.map(|n| n.cost()).sum()), period: t.period }
        })
    }

    /// A node of the task, in the newest graph or an older one that jobs in flight still have.
    pub fn task_node(&self, task: TaskId, node: NodeId) -> Option<&Node> {
        let t = &self.tasks[self.task_slot(task)?];
        let used = t.versions.iter().any(|v| v.nodes().contains(node.index().min(C::NODES - 1)));
        (node.index() < C::NODES && used).then(|| &t.nodes[node.index()])
    }

    /// What the node took so far.
    pub fn estimate(&self, task: TaskId, node: NodeId) -> Option<&Estimator> {
        self.task_node(task, node)?;
        Some(&self.tasks[self.task_slot(task)?].estimates[node.index()])
    }

    pub(super) fn task_slot(&self, task: TaskId) -> Option<usize> {
        let slot = task.index();
        let live = |t: &Task<C>| t.admitted && task == TaskId::new(slot, t.generation);
        (slot < C::TASKS && live(&self.tasks[slot])).then_some(slot)
    }
}

impl<C: Capacity> Task<C> {
    /// The version that a job of this task has.
    #[inline(always)]
    pub(super) fn version_of(&self, job: &Job<C>) -> &Version<C> {
        let [first, second] = &self.versions;
        if job.version == 0 { first } else { second }
    }

    /// Takes the data of `dag`'s nodes; those that are `here` already keep their samples.
    pub(super) fn install(&mut self, dag: &Dag<C>, here: &NodeSet<C>) {
        dag.present().each(|place| {
            if !here.contains(place) {
                self.estimates[place] = Estimator::new(dag.at(place));
            }
            self.nodes[place] = *dag.at(place);
        });
        self.end = self.end.max(dag.end());
        self.revision = self.revision.wrapping_add(1);
    }
}
