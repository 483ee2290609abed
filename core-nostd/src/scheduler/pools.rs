//! Pools of lanes, and the sensors whose captures jobs share.

use super::{Scheduler, action::ShedReason, bits, tasks::Task};
use crate::capacity::{Capacity, Empty};
use crate::config::Shed;
use crate::graph::Levels;
use crate::id::{LaneId, PoolId, SensorId};
use crate::ready_queue::ReadyQueue;
use crate::time::{Bytes, Duration, Instant, Ppm};

crate::capacity::stored! {
    /// A pool: lanes, a memory budget, and the jobs that have something ready for it.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Pool<C: Capacity> {
        /// Free lanes, by global number.
        pub(super) free: u32,
        /// All its lanes, by global number.
        pub(super) lanes: u32,
        /// The job that ran last (slot plus one) is not queued: it is compared with the queue's head instead.
        pub(super) current: u8,
        pub(super) limited: bool,
        /// Whether its head starts without more ado: there is no budget, and no job of one task may outrank one of another there.
        pub(super) is_plain: bool,
        pub(super) ahead: bool,
        /// Until when ranks go before keys; 0 if they do not.
        pub(super) pressed: Instant,
        /// What somebody else measured of its use, in parts per million.
        pub(super) observed: Ppm,
        /// Modulo 2^64: lane time of its completed units; of that, up to the current tick's start, and in the tick before.
        pub(super) busy: u64,
        pub(super) mark: u64,
        pub(super) tick_busy: u64,
        /// Memory budget, and bytes held by running units and kept results.
        pub(super) budget: u64,
        pub(super) used: u64,
        pub(super) queue: ReadyQueue<Rank, C::Jobs<Rank>, C::Jobs<u16>>,
    }
}

crate::capacity::stored! {
    /// Key of the queues, a total order of jobs by their most pressing ready nodes: absolute key, then release, then
    /// how the task fared of late, then task order, then job index.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub(crate) struct Rank {
        key: i64,
        release: u64,
        /// Fortune in the high 8 bits, task order in the next 8, job index below.
        tie: u64,
    }
}

impl Rank {
    #[inline(always)]
    pub(crate) const fn new(key: i64, release: u64, fortune: u8, task_order: usize, job_index: u64) -> Self {
        let tie = (fortune as u64) << 56 | (task_order as u64) << 48 | (job_index & ((1 << 48) - 1));
        Self { key, release, tie }
    }
}

crate::error::errors! {
    /// A pool could not be added. Nothing changed.
    pub enum PoolError {
        /// A pool needs at least one lane.
        NoLane,
        /// More pools or lanes than the capacity.
        Full,
    }

    /// A sensor could not be added. Nothing changed.
    pub enum SensorError {
        /// A period is at least one nanosecond.
        ZeroPeriod,
        /// More distinct periods than the capacity has nodes.
        Full,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Adds a pool of `lanes` lanes after the others. Errors: [`PoolError`].
    pub fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
        if lanes == 0 {
            return Err(PoolError::NoLane);
        }
        let first = self.lane_count;
        let end = first.checked_add(lanes).ok_or(PoolError::Full)?;
        if usize::from(end) > C::LANES || usize::from(self.pool_count) >= C::POOLS {
            return Err(PoolError::Full);
        }
        let pool = usize::from(self.pool_count);
        let mask = ((1u64 << end) - (1u64 << first)) as u32;
        let budget = memory.map_or(u64::MAX, |m| m.0);
        self.pools[pool] = Pool {
            free: mask,
            lanes: mask,
            limited: memory.is_some(),
            is_plain: memory.is_none(),
            budget,
            ..Pool::EMPTY
        };
        for lane in first..end {
            self.lanes[usize::from(lane)].pool = pool as u8;
        }
        (self.lane_count, self.pool_count) = (end, self.pool_count + 1);
        Ok(PoolId::new(pool as u8))
    }

    /// A pool that was added.
    pub(super) fn pool_mut(&mut self, pool: PoolId) -> Option<&mut Pool<C>> {
        (pool.index() < usize::from(self.pool_count)).then(|| &mut self.pools[pool.index()])
    }

    /// Tells how much of what a pool's lanes share was used of late, by whomever: a GPU, which other processes use,
    /// too. Until the next call overload is judged by that where it is more than the lanes' own busy time. `false`: no
    /// such pool. Time bound: O(1).
    pub fn observe_use(&mut self, pool: PoolId, used: Ppm) -> bool {
        self.pool_mut(pool).map(|pool| pool.observed = used).is_some()
    }

    /// The pool of a lane; `None`: there is no such lane. Time bound: O(1).
    pub fn pool_of(&self, lane: LaneId) -> Option<PoolId> {
        (lane.index() < self.lanes()).then(|| PoolId::new(self.lanes[lane.index()].pool))
    }

    /// Gives a pool up, because what its lanes ran on is gone: jobs that still need it end with the reason `fault`, and
    /// so does each that is released from now on. Units that run there have to be reported all the same. `false`: no
    /// such pool. Time bound: O(jobs * nodes).
    pub fn lose_pool(&mut self, pool: PoolId, now: Instant) -> bool {
        self.advance(now);
        let there = self.pool_mut(pool).is_some();
        if there {
            self.lost |= 1 << pool.index();
            self.reopen();
            self.slots().for_each(|slot| self.end_if_lost(slot));
            self.worsened();
        }
        there
    }

    /// What jobs to come have to spare on the lanes that there are. Time bound: that of [`Self::find_blocked`], and
    /// O(tasks * (nodes + edges)).
    pub(super) fn bound_slack(&mut self) {
        let lanes = self.lanes_by_pool();
        for task in self.tasks.as_mut() {
            let (due, nodes) = (task.timing.deadline, &task.nodes);
            for version in task.versions.as_mut() {
                let path = Levels::of(&version.dag(nodes)).critical_path();
                version.bound_slack(path, lanes.as_ref(), due);
            }
        }
        self.find_blocked();
    }

    /// In which pools a node may be in the way of a higher rank. Time bound: O(tasks * tasks).
    pub(super) fn find_blocked(&mut self) {
        let mut blocked = 0;
        let tasks = || self.tasks.as_ref().iter().enumerate().filter(|(_, task)| task.admitted);
        // Jobs in flight may have the older graph.
        let pools = |task: &Task<C>| task.versions[0].pool_mask | task.versions[1].pool_mask;
        for (t, low) in tasks().filter(|_| self.config.shed == Shed::Hopeless) {
            let above = tasks().filter(|(other, high)| *other != t && high.may_outrank(low));
            blocked |= above.fold(0, |all, (_, high)| all | pools(high)) & pools(low);
        }
        for pool in self.pool_numbers() {
            self.pools[pool].is_plain = !self.pools[pool].limited && blocked >> pool & 1 == 0;
        }
    }

    /// Ends a job that needs a pool which was lost.
    #[cold]
    pub(super) fn end_if_lost(&mut self, slot: usize) {
        let version = self.version(slot);
        let undone = self.jobs[slot].undone(version);
        if bits(self.lost.into()).any(|pool| undone.first_in(&version.in_pool[pool]).is_some()) {
            self.end_job(slot, Some(ShedReason::Fault));
        }
    }

    /// Makes a sensor known; jobs released between two captures share the earlier one. Sensors of equal
    /// period are one: the frame's name tells them apart. Errors: [`SensorError`].
    pub fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError> {
        if period == Duration::ZERO {
            return Err(SensorError::ZeroPeriod);
        }
        let place = self.sensors.as_ref().iter().position(|p| *p == period || *p == Duration::ZERO);
        let place = place.ok_or(SensorError::Full)?;
        self.sensors[place] = period;
        Ok(SensorId::new(place as u8))
    }

    /// Bytes that running units and kept results hold of a pool.
    pub fn memory_used(&self, pool: PoolId) -> Bytes {
        Bytes(if pool.index() < C::POOLS { self.pools[pool.index()].used } else { 0 })
    }
}

#[cfg(test)]
mod tests;
