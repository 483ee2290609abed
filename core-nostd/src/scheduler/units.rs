//! Lanes and the units that run on them.

use super::{Scheduler, bits, event::EventKind};
use crate::capacity::{Capacity, Empty};
use crate::deadlines::DeadlineRule;
use crate::id::{JobId, LaneId, NodeId, PoolId, TaskId, UnitId};
use crate::time::{Duration, Instant};
use core::hint::cold_path;

crate::capacity::stored! {
    /// What runs on a lane.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Lane {
        pub(super) unit: UnitId,
        pub(super) started: Instant,
        /// How long the first member had run before, if it was preempted.
        pub(super) carried: Duration,
        /// Jobs with a member in the unit, a bit per slot; 0: every member's job was given up.
        pub(super) members: u64,
        pub(super) memory: u64,
        /// Of a unit that gained or lost members: the longest estimate of those whose jobs were given up, in nanoseconds.
        pub(super) expects: u64,
        /// First member.
        pub(super) slot: u8,
        pub(super) rank: u8,
        pub(super) pool: u8,
        /// Whether the unit has more than one member, or lost one.
        pub(super) merged: bool,
        /// Result that the unit writes (encoder) or reads (decoder), plus one.
        pub(super) output: u16,
        pub(super) is_encoder: bool,
        /// Whether its end may start a unit that was dispatched ahead, or one that waits in some pool.
        pub(super) leads: bool,
    }
}

crate::capacity::stored! {
    /// A sub-job beside the lanes: one that lost its lane to a smaller key, or one that waits on it. No scheduler has
    /// both, for pools that dispatch ahead are not preempted.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Beside {
        /// How long it has run, or its unit.
        pub(super) word: u64,
        /// Job slot, plus one where it lost its lane; 0 is a free place then.
        pub(super) slot: u8,
        pub(super) rank: u8,
        /// It waits, and its job was given up.
        pub(super) broken: bool,
    }
}

impl Lane {
    pub(super) fn is_busy(&self) -> bool {
        self.unit != UnitId::EMPTY
    }
}

crate::capacity::values! {
    /// One sub-job of a unit, and what its body may want to know.
    pub struct Member {
        /// The job.
        pub job: JobId,
        /// Its task.
        pub task: TaskId,
        /// The how-manieth job of its task, from 0.
        pub index: u64,
        /// The node.
        pub node: NodeId,
        /// When the job was released.
        pub release: Instant,
        /// When the job is due.
        pub deadline: Instant,
        /// When the node should end: release plus its sub-deadline, at least the epoch.
        pub sub_deadline: Instant,
    }

    /// What a unit is.
    pub struct Unit {
        /// Its first member: the one whose body runs.
        pub first: Member,
        /// Where it runs.
        pub lane: LaneId,
        /// The lane's pool.
        pub pool: PoolId,
        /// When it started; of one that was dispatched ahead and has not, the time now.
        pub started: Instant,
        /// The worst-case execution time of the first member's node.
        pub wcet: Duration,
        /// Number of the encoder result that the unit writes or reads. Numbers are below `C::NODES`, and one stays
        /// the same result until nobody in flight needs it.
        pub output: Option<u16>,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// What a unit is, while it runs, or waits on its lane, and one of its jobs is in flight.
    #[must_use]
    pub fn unit(&self, unit: UnitId) -> Option<Unit> {
        let Some(lane) = self.lane_of(unit) else { return self.unit_ahead(unit) };
        let l = &self.lanes[lane];
        let (slot, rank) = (usize::from(l.slot), usize::from(l.rank));
        (l.members != 0).then(|| self.told(slot, rank, lane, l.started, l.output))
    }

    pub(super) fn told(&self, slot: usize, rank: usize, lane: usize, started: Instant, output: u16) -> Unit {
        Unit {
            first: self.member(slot, rank),
            lane: LaneId::new(lane as u8),
            pool: PoolId::new(self.lanes[lane].pool),
            started,
            wcet: self.node(slot, rank).wcet.get(),
            output: output.checked_sub(1),
        }
    }

    /// The members of a unit that runs: one, or the encoders that share one execution.
    pub fn members(&self, unit: UnitId) -> impl Iterator<Item = Member> + '_ {
        let running = self.lane_of(unit).into_iter().flat_map(move |lane| {
            let ranks = move |slot| self.ranks_on(slot, lane).map(move |rank| self.member(slot, rank));
            bits(self.lanes[lane].members).flat_map(ranks)
        });
        running.chain(self.unit_ahead(unit).map(|unit| unit.first))
    }

    /// The lane that runs a unit.
    pub(super) fn lane_of(&self, unit: UnitId) -> Option<usize> {
        let lane = unit.lane().index();
        (unit != UnitId::EMPTY && lane < C::LANES && self.lanes[lane].unit == unit).then_some(lane)
    }

    /// Ranks of a job that run on a lane.
    pub(super) fn ranks_on(&self, slot: usize, lane: usize) -> impl Iterator<Item = usize> + '_ {
        let job = &self.jobs[slot];
        job.running.iter().filter(move |rank| usize::from(job.place[*rank]) == lane)
    }

    fn member(&self, slot: usize, rank: usize) -> Member {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let starts = self.config.rule == DeadlineRule::LatestStart;
        let cost = if starts { self.node(slot, rank).cost() } else { 0 };
        let due = job.key_of(version, rank, self.residual).saturating_add_unsigned(cost);
        Member {
            job: JobId::new(slot, job.generation),
            task: job.task,
            index: job.index,
            node: NodeId::new(version.order[rank]),
            release: job.release,
            deadline: job.deadline,
            sub_deadline: Instant::from_nanos(due.max(0).cast_unsigned()),
        }
    }

    /// A ready rank runs from now on.
    pub(super) fn run_on(&mut self, slot: usize, rank: usize, lane: usize) {
        let job = &mut self.jobs[slot];
        job.ready.remove(rank);
        job.running.insert(rank);
        job.place[rank] = lane as u8;
        job.started = true;
    }

    /// Gives a ready rank, which is `node`, a lane.
    #[inline(always)]
    pub(super) fn start(&mut self, slot: usize, rank: usize, node: u8, lane: usize) -> UnitId {
        self.counters.units += 1;
        let unit = UnitId::new(self.counters.units, node, lane);
        self.start_as(unit, slot, rank, lane);
        unit
    }

    /// Gives a ready rank its lane as a unit of this name.
    #[inline(always)]
    pub(super) fn start_as(&mut self, unit: UnitId, slot: usize, rank: usize, lane: usize) {
        self.run_on(slot, rank, lane);
        if self.reassigns | self.config.preempt {
            cold_path();
            self.stale_keys = self.reassigns;
            self.lanes[lane].carried = self.resume(slot, rank);
        }
        let l = &mut self.lanes[lane];
        (l.unit, l.started, l.members) = (unit, self.now, 1 << slot);
        (l.slot, l.rank, l.output) = (slot as u8, rank as u8, 0);
        let free = &mut self.pools[usize::from(l.pool)].free;
        *free = if C::LANES == 1 { 0 } else { *free & !(1 << lane) };
        self.note_node(EventKind::Started, slot, unit.node(), lane);
        crate::fmt::trace!("start {} on {}", unit, lane);
    }

    /// Takes an idle lane out of its pool, because its thread is lost; `false` if something runs or waits on it or there
    /// is no such lane. A pool without lanes starts nothing. Time bound: O(tasks * pools).
    pub fn retire_lane(&mut self, lane: LaneId) -> bool {
        let l = lane.index();
        let idle = l < self.lanes() && !self.lanes[l].is_busy() && self.promised >> l & 1 == 0;
        if idle {
            let pool = &mut self.pools[usize::from(self.lanes[l].pool)];
            pool.free &= !(1 << l);
            pool.lanes &= !(1 << l);
            self.bound_slack();
            self.worsened();
        }
        idle
    }

    /// Puts a retired lane back; `false` if it was not retired. Time bound: O(tasks * pools).
    pub fn restore_lane(&mut self, lane: LaneId) -> bool {
        let l = lane.index();
        if l >= self.lanes() {
            return false;
        }
        let pool = &mut self.pools[usize::from(self.lanes[l].pool)];
        let retired = pool.lanes >> l & 1 == 0;
        pool.lanes |= 1 << l;
        pool.free |= u32::from(retired) << l;
        self.active |= u32::from(retired) << self.lanes[l].pool;
        if retired {
            self.bound_slack();
        }
        retired
    }

    /// Frees the lane of a unit that is more than one sub-job of an ordinary node; returns what ran there.
    pub(super) fn vacate(&mut self, lane: usize) -> Lane {
        let l = self.lanes[lane];
        self.free(lane);
        // What waits on it has it already.
        self.pools[usize::from(l.pool)].free &= !self.promised;
        self.activate(usize::from(l.pool));
        self.reopen();
        let now = &mut self.lanes[lane];
        (now.merged, now.is_encoder, now.leads) = (false, false, false);
        l
    }

    /// Frees a lane and the memory of its unit. The caller makes its pool active, as `requeue` does.
    #[inline(always)]
    pub(super) fn free(&mut self, lane: usize) {
        let l = &mut self.lanes[lane];
        let pool = usize::from(l.pool);
        let ran = self.now.as_nanos() - l.started.as_nanos();
        self.pools[pool].busy = self.pools[pool].busy.wrapping_add(ran);
        l.unit = UnitId::EMPTY;
        // With one lane the whole word is stored, as in `activate`.
        self.pools[pool].free = if C::LANES == 1 { 1 } else { self.pools[pool].free | 1 << lane };
        if self.pools[pool].limited {
            cold_path();
            self.pools[pool].used -= l.memory;
            l.memory = 0;
        }
    }
}
