//! A job: one release of a task, and how far each of its nodes is.

use super::action::{Outcome, ShedReason};
use super::{Scheduler, bits, event::EventKind, pools::Rank, version::Version, warning::Late};
use crate::capacity::{Capacity, Empty};
use crate::deadlines::Window;
use crate::graph::{Node, NodeSet};
use crate::id::{JobId, TaskId};
use crate::policy::floor::RECENT;
use crate::policy::frame_cache::CaptureSource;
use crate::time::Instant;
use core::hint::cold_path;

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    #[repr(C)] // What every completion touches comes first.
    pub(super) struct Job<C: Capacity> {
        pub(super) task: TaskId,
        pub(super) generation: u16,
        /// Whether it has the second version of its task.
        pub(super) version: bool,
        /// Whether a node started, or a result was taken.
        pub(super) started: bool,
        /// Nodes that are not done. As wide as it is loaded: a wide load soon after a narrow store waits for it.
        pub(super) left: u32,
        /// Whether an encoder runs again after its result was thrown away.
        pub(super) reruns: bool,
        pub(super) shed: Option<ShedReason>,
        /// Who numbered the capture it reads.
        pub(super) source: CaptureSource,
        /// Goes before keys, the greatest first.
        pub(super) band: u8,
        /// How its task fared before it: of equal keys the least goes first.
        pub(super) fortune: u8,
        pub(super) late: Late,
        /// By rank.
        pub(super) ready: NodeSet<C>,
        pub(super) running: NodeSet<C>,
        pub(super) done: NodeSet<C>,
        /// Ready by precedence, but its level is not open, or its encoder key is running.
        pub(super) parked: NodeSet<C>,
        pub(super) release: Instant,
        pub(super) deadline: Instant,
        /// Key that all ready nodes share, under residual re-assignment.
        pub(super) key: i64,
        /// The how-manieth job of its task.
        pub(super) index: u64,
        /// The capture it reads, by number.
        pub(super) capture: u64,
        /// In flight: it is not lost for certain before. Ended: when it did.
        pub(super) at: Instant,
        /// By rank: predecessors that are not done.
        pub(super) waiting_for: C::Nodes<u8>,
        /// Ready: how often it was overtaken for memory. Running: lane. Done encoder: output plus one, or 0.
        pub(super) place: C::Nodes<u8>,
    }
}

/// What is known of a job at its release.
#[derive(Debug)]
pub(super) struct Release {
    pub(super) task: TaskId,
    pub(super) index: u64,
    pub(super) version: bool,
    pub(super) fortune: u8,
    pub(super) release: Instant,
    pub(super) deadline: Instant,
    pub(super) capture: u64,
    pub(super) source: CaptureSource,
}

impl<C: Capacity> Job<C> {
    /// Makes it a new job of this version of its task, in place: a literal of this size would be built elsewhere and
    /// copied.
    #[inline(always)]
    pub(super) fn begin(&mut self, new: &Release, version: &Version<C>) {
        *self = Self::EMPTY;
        (self.task, self.index, self.version, self.fortune) = (new.task, new.index, new.version, new.fortune);
        self.left = version.len.into();
        (self.release, self.deadline) = (new.release, new.deadline);
        (self.capture, self.source) = (new.capture, new.source);
        self.key = new.release.as_nanos().cast_signed();
        let latest = self.key.saturating_add(version.slack);
        self.at = Instant::from_nanos(latest.saturating_add(1).max(0).cast_unsigned());
        (self.ready, self.waiting_for) = (version.sources, version.indegree);
    }

    /// Ranks that are not done.
    pub(super) fn undone(&self, version: &Version<C>) -> NodeSet<C> {
        let mut all = NodeSet::EMPTY;
        (0..usize::from(version.len)).for_each(|rank| all.insert(rank));
        all.without(&self.done)
    }

    /// Key of a rank as queues order it: band, then absolute key. No two keys in flight are 2^56 ns, two years, apart.
    pub(super) fn queue_key(&self, version: &Version<C>, rank: usize, residual: bool) -> i64 {
        self.key_of(version, rank, residual).saturating_sub(i64::from(self.band) << 56)
    }

    /// Absolute key of a rank.
    pub(super) fn key_of(&self, version: &Version<C>, rank: usize, residual: bool) -> i64 {
        if residual {
            self.key
        } else {
            (self.release.as_nanos().cast_signed()).saturating_add(version.key[rank])
        }
    }
}

impl<C: Capacity> Scheduler<C> {
    pub(super) fn version(&self, slot: usize) -> &Version<C> {
        let job = &self.jobs[slot];
        self.tasks[job.task.index()].version_of(job)
    }

    pub(super) fn node(&self, slot: usize, rank: usize) -> &Node {
        self.node_of(&self.jobs[slot], rank)
    }

    pub(super) fn node_of(&self, job: &Job<C>, rank: usize) -> &Node {
        let task = &self.tasks[job.task.index()];
        &task.nodes[usize::from(task.version_of(job).order[rank])]
    }

    /// Queue key of a job's rank.
    pub(super) fn rank_key(&self, slot: usize, rank: usize) -> Rank {
        let job = &self.jobs[slot];
        let key = job.queue_key(self.version(slot), rank, self.residual);
        Rank::new(key, job.release.as_nanos(), job.fortune, job.task.index(), job.index)
    }

    /// Most pressing ready rank of a job in a pool.
    pub(super) fn head_of(&self, slot: usize, pool: usize) -> Option<usize> {
        let ready = &self.jobs[slot].ready;
        if C::POOLS == 1 { ready.first_in(ready) } else { ready.first_in(&self.version(slot).in_pool[pool]) }
    }

    /// Brings a job's entry in every pool's queue up to date after its ready set or key changed.
    #[inline(always)]
    pub(super) fn requeue(&mut self, slot: usize) {
        if C::POOLS == 1 {
            self.requeue_in(slot, 0);
        } else {
            bits(self.version(slot).pool_mask.into()).for_each(|pool| self.requeue_in(slot, pool));
        }
    }

    #[inline(always)]
    fn requeue_in(&mut self, slot: usize, pool: usize) {
        self.activate(pool);
        if usize::from(self.pools[pool].current) != slot + 1 {
            cold_path();
            self.requeue_other(slot, pool);
        }
    }

    /// A job that is not the pool's current one: in the queue iff it has something ready.
    fn requeue_other(&mut self, slot: usize, pool: usize) {
        let key = self.head_of(slot, pool).map(|rank| self.rank_key(slot, rank));
        let current = usize::from(self.pools[pool].current);
        let is_vacant = current == 0 || self.head_of(current - 1, pool).is_none();
        let p = &mut self.pools[pool];
        match key {
            Some(key) if !is_vacant => p.queue.push(slot, key),
            _ => {
                p.queue.remove(slot);
                p.current = if key.is_some() { slot as u8 + 1 } else { p.current };
            }
        }
    }

    /// Ends a job: completed (`None`) or given up. Its slot is free once the host took the outcome.
    #[inline(never)]
    pub(super) fn end_job(&mut self, slot: usize, shed: Option<ShedReason>) {
        if shed.is_some_and(|reason| reason != ShedReason::Fault) {
            self.observe_given_up(slot);
        }
        self.in_flight &= !(1 << slot);
        self.ended |= 1 << slot;
        let job = &mut self.jobs[slot];
        (job.shed, job.at) = (shed, self.now);
        (job.ready, job.parked) = (NodeSet::EMPTY, NodeSet::EMPTY);
        let (task, index) = (job.task.index(), job.index);
        let is_lost = shed.is_some() || self.now > job.deadline;
        let overran = self.tasks[task].overran;
        let floor = &mut self.tasks[task].timing.floor;
        let is_back = !is_lost && overran && floor.lost_in_row() > RECENT;
        floor.ended(index, is_lost);
        if is_back {
            cold_path();
            // It lost them by how long it once took.
            self.tasks[task].samples.as_mut().iter_mut().for_each(Window::keep_newest);
        }
        self.tasks[task].versions[usize::from(job.version)].users -= 1;
        for pool in self.pool_numbers() {
            self.pools[pool].queue.remove(slot);
            if usize::from(self.pools[pool].current) == slot + 1 {
                self.pools[pool].current = 0;
            }
        }
        self.note_task(shed.map_or(EventKind::Ended, EventKind::Shed), task, index);
        if shed.is_some() {
            self.abandon(slot);
        }
    }

    /// The id of a job in flight, by its task and its index in the task.
    #[must_use]
    pub fn job_id(&self, task: TaskId, index: u64) -> Option<JobId> {
        let t = self.task_slot(task)?;
        let found = |slot: &usize| self.jobs[*slot].task.index() == t && self.jobs[*slot].index == index;
        self.slots().find(found).map(|slot| JobId::new(slot, self.jobs[slot].generation))
    }

    /// Takes the outcome of one ended job; its place can be used again. `poll` hands outcomes out as well: take
    /// them here before releasing into a full table.
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        if self.displaced.shed.is_some() {
            cold_path();
            return Some(core::mem::replace(&mut self.displaced, Outcome::EMPTY));
        }
        Some(self.outcome_of(bits(self.ended).next()?))
    }

    /// Takes the outcome of an ended job out of its slot.
    pub(super) fn outcome_of(&mut self, slot: usize) -> Outcome {
        self.ended &= !(1 << slot);
        let job = &mut self.jobs[slot];
        let id = JobId::new(slot, job.generation);
        job.generation = job.generation.wrapping_add(1);
        let Job { task, index, release, deadline, at, shed, .. } = *job;
        Outcome { job: id, task, index, release, deadline, at, shed }
    }
}
