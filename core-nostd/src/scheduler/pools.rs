//! Pools of lanes, and the sensors whose captures jobs share.

use super::Scheduler;
use crate::capacity::{Capacity, Empty};
use crate::id::{PoolId, SensorId};
use crate::ready_queue::ReadyQueue;
use crate::time::{Bytes, Duration};

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
        pub(super) ahead: bool,
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
    /// task order, then job index.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
    pub(crate) struct Rank {
        key: i64,
        release: u64,
        /// Task order in the high 8 bits, job index below.
        tie: u64,
    }
}

impl Rank {
    #[inline(always)]
    pub(crate) const fn new(key: i64, release: u64, task_order: usize, job_index: u64) -> Self {
        Self { key, release, tie: (task_order as u64) << 56 | (job_index & ((1 << 56) - 1)) }
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
        self.pools[pool] = Pool { free: mask, lanes: mask, limited: memory.is_some(), budget, ..Pool::EMPTY };
        for lane in first..end {
            self.lanes[usize::from(lane)].pool = pool as u8;
        }
        (self.lane_count, self.pool_count) = (end, self.pool_count + 1);
        Ok(PoolId::new(pool as u8))
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
