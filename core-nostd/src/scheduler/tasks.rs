//! The table of admitted tasks.

use super::{Scheduler, action::ShedReason, jobs::Job, version::Version};
use crate::analysis::Certificate;
use crate::capacity::{Capacity, Empty};
use crate::config::Config;
use crate::deadlines::{Estimator, Window, shift};
use crate::graph::{Dag, Levels, Node, NodeSet};
use crate::id::{NodeId, TaskId};
use crate::policy::Floor;
use crate::time::{Duration, Instant};

/// Longest deadline: 2^62 ns, so that every key fits 64 signed bits.
const LONGEST_DEADLINE: Duration = Duration::from_nanos(1 << 62);

crate::capacity::stored! {
    /// When a task's jobs come and are due, and what they are worth.
    ///
    /// ```
    /// use red_core::{Duration, Timing};
    /// let timing = Timing::new(Duration::from_millis(120)).every(Duration::from_millis(100)).value(10).floor(3, 4);
    /// # let _ = timing;
    /// ```
    #[derive(Clone, Copy, Debug)]
    pub struct Timing {
        pub(super) deadline: Duration,
        /// 0 is none.
        period: Duration,
        pub(super) value: u32,
        pub(super) floor: Floor,
    }
}

impl Timing {
    /// Jobs due `deadline` after their release, at no declared rate, of value 1.
    pub const fn new(deadline: Duration) -> Self {
        Self { deadline, period: Duration::ZERO, value: 1, floor: Floor::EMPTY }
    }

    /// With a period, or a minimum inter-arrival time; admission uses it. One of 0 is none.
    #[must_use]
    pub const fn every(self, period: Duration) -> Self {
        Self { period, ..self }
    }

    pub(super) const fn period(&self) -> Option<Duration> {
        if self.period.as_nanos() == 0 { None } else { Some(self.period) }
    }

    /// With a declared value: jobs of a lower value never cost a higher one its deadline, but for nodes that hold a lane.
    #[must_use]
    pub const fn value(self, value: u32) -> Self {
        Self { value, ..self }
    }

    /// With a floor: at least `m` of any `k` consecutive jobs are to be on time. A job that it cannot spare ranks above
    /// every value.
    #[must_use]
    pub const fn floor(self, m: u32, k: u32) -> Self {
        Self { floor: Floor::new(m, k), ..self }
    }

    /// Deadline, period, value, and the floor's m and k as far back as it is kept.
    pub const fn parts(&self) -> (Duration, Option<Duration>, u32, [u8; 2]) {
        (self.deadline, self.period(), self.value, self.floor.part())
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
        /// An encoder names a sensor that does not exist.
        UnknownSensor,
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
        /// Whether new jobs get the second version.
        pub(super) current: bool,
        pub(super) generation: u16,
        /// Counts commits, so that an edit knows whether another came between; 1 from the start.
        pub(super) revision: u32,
        pub(super) next_job: u64,
        /// When its last job was released.
        pub(super) released: Instant,
        pub(super) timing: Timing,
        /// One more than the highest node place ever used.
        pub(super) end: u16,
        /// Whether a node took longer than its WCET, perhaps of late.
        pub(super) overran: bool,
        pub(super) versions: [Version<C>; 2],
        /// By node id; a place belongs to one node as long as a version uses it.
        pub(super) nodes: C::Nodes<Node>,
        pub(super) samples: C::Nodes<Window>,
        /// Those of the samples.
        pub(super) shifts: C::Nodes<u8>,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Admits a task after the others; its certificate is [`certificate`](Self::certificate). Time bound:
    /// O(lanes * (nodes + edges) + nodes log nodes + tasks * tasks * nodes). Errors: [`AddTaskError`].
    pub fn add_task(&mut self, dag: &Dag<C>, timing: Timing) -> Result<TaskId, AddTaskError> {
        if timing.deadline == Duration::ZERO || timing.deadline > LONGEST_DEADLINE {
            return Err(AddTaskError::Deadline);
        }
        let levels = Levels::of(dag);
        let _proof = self.admit(&levels, &timing)?;
        let slot = (0..C::TASKS).find(|t| !self.tasks[*t].admitted).ok_or(AddTaskError::Full)?;
        let lanes = self.lanes_by_pool();
        let task = &mut self.tasks[slot];
        (task.admitted, task.current, task.revision, task.next_job, task.end) = (true, false, 0, 0, 0);
        task.timing = timing;
        task.versions = [Version::EMPTY; 2];
        task.install(&levels, &self.config, lanes.as_ref());
        let id = TaskId::new(slot, task.generation);
        self.find_blocked();
        Ok(id)
    }

    /// Removes a task; its jobs in flight are given up with the reason `removed`. `false` if it is not there.
    pub fn remove_task(&mut self, task: TaskId, now: Instant) -> bool {
        let Some(t) = self.task_slot(task) else { return false };
        self.advance(now);
        for slot in self.slots() {
            if self.jobs[slot].task.index() == t {
                self.end_job(slot, Some(ShedReason::Removed));
            }
        }
        self.tasks[t].admitted = false;
        // Nobody waits for it any more.
        self.find_blocked();
        self.reopen();
        self.tasks[t].generation = self.tasks[t].generation.wrapping_add(1);
        true
    }

    /// The bound on the response time of the task's newest graph, alone on its pools.
    #[must_use]
    pub fn certificate(&self, task: TaskId) -> Option<Certificate> {
        self.edit(task).map(|dag| self.prove(&Levels::of(&dag), &self.tasks[task.index()].timing))
    }

    /// A node of the task, in the newest graph or an older one that jobs in flight still have, and what it took.
    pub fn task_node(&self, task: TaskId, node: NodeId) -> Option<(&Node, Estimator)> {
        let (t, place) = (&self.tasks[self.task_slot(task)?], node.index());
        let is_there = place < C::NODES && t.taken().contains(place);
        is_there.then(|| (&t.nodes[place], Estimator::of(t.shifts[place], &t.samples[place])))
    }

    pub(super) fn task_slot(&self, task: TaskId) -> Option<usize> {
        let t = self.tasks.as_ref().get(task.index())?;
        (t.admitted && task == TaskId::new(task.index(), t.generation)).then_some(task.index())
    }
}

impl<C: Capacity> Task<C> {
    pub(super) fn version_of(&self, job: &Job<C>) -> &Version<C> {
        let [first, second] = &self.versions;
        if job.version { second } else { first }
    }

    /// Whether no execution that estimates come from took longer than its WCET. Time bound: O(nodes).
    pub(super) fn has_settled(&mut self) -> bool {
        let overran = |place: usize| {
            let longest = Estimator::of(self.shifts[place], &self.samples[place]).maximum();
            longest > Some(self.nodes[place].wcet.get())
        };
        self.overran = (0..C::NODES).any(overran);
        !self.overran
    }

    /// Whether nothing is left to learn of its times: each node has 8 samples, and none exceeded its WCET. Time bound: O(nodes).
    pub(super) fn is_known(&self) -> bool {
        let version = self.newest();
        let places = version.order.as_ref().iter().take(version.len.into());
        !self.overran && places.into_iter().all(|place| self.samples[usize::from(*place)].is_whole())
    }

    /// Whether a job of it may have a higher rank than one of another.
    pub(super) fn may_outrank(&self, other: &Self) -> bool {
        self.timing.value > other.timing.value || self.timing.floor.needs_some() || other.is_slow()
    }

    /// Whether jobs of it may be late however early they start: at WCET they would be, or a WCET was exceeded of late.
    pub(super) fn is_slow(&self) -> bool {
        self.overran || self.newest().slack < 0
    }

    pub(super) fn newest(&self) -> &Version<C> {
        &self.versions[usize::from(self.current)]
    }

    /// Places of the newest graph's nodes, and of the older one's as long as jobs have it.
    pub(super) fn taken(&self) -> NodeSet<C> {
        let mut taken = self.newest().nodes();
        let older = self.versions.iter().filter(|version| version.users > 0);
        older.for_each(|version| taken.extend(&version.nodes()));
        taken
    }

    /// Takes a graph for jobs that are released from now on; nodes of the current one keep their samples.
    pub(super) fn install(&mut self, levels: &Levels<'_, C>, config: &Config, lanes: &[u8]) {
        let current = &self.versions[usize::from(self.current)];
        let here = current.nodes();
        // A version without jobs is replaced in place; else the other one becomes current.
        self.current ^= current.users > 0;
        for place in levels.places() {
            self.nodes[place] = *levels.dag.at(place);
            if !here.contains(place) {
                (self.samples[place], self.shifts[place]) = (Window::EMPTY, shift(levels.dag.at(place)));
            }
        }
        self.end = self.end.max(levels.dag.end);
        self.revision = self.revision.wrapping_add(1);
        let version = &mut self.versions[usize::from(self.current)];
        version.lay_out(levels, config, self.timing.deadline, lanes);
    }
}
