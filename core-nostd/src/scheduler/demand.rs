//! Whether a task could have all of its jobs in time beside all that counts before it.
//!
//! *Rule.* Before a task counts all of who is worth as much or more, and of the others what their floors need. It cannot be whole where
//! it and these ask a pool for more than its lanes, nor where as many nodes of who needs each job as there are lanes take longer than it can wait.
//! A task counts while it has a job in flight or its next one is awaited, and without a period as if one came each relative deadline: what
//! comes once, or comes no more, costs nobody its order afterwards.
//! *What it leaves out.* Times are means, and an encoder counts for each that shares it.

use super::{Scheduler, bits, coming::signed, outlook::mean_of, tasks::Task};
use crate::capacity::Capacity;
use crate::deadlines::Estimator;

/// A whole lane.
const LANE: u64 = 1_000_000;

impl<C: Capacity> Scheduler<C> {
    /// Whether the task in a slot could be whole. Time bound: O(pools * tasks * (nodes + jobs)).
    pub(super) fn can_be_whole(&self, slot: usize) -> bool {
        let task = &self.tasks[slot];
        let part = |other: &Task<C>| {
            if other.timing.value >= task.timing.value { [1, 1] } else { other.timing.floor.part() }
        };
        let is_there = |t: usize| {
            let is_awaited = self.tasks[t].awaited_until().is_some_and(|until| self.now < until);
            is_awaited || self.slots().any(|slot| self.jobs[slot].task.index() == t)
        };
        let before = |t: &usize| self.tasks[*t].admitted && part(&self.tasks[*t])[0] > 0 && is_there(*t);
        bits(task.newest().pool_mask.into()).all(|pool| {
            let (mut asked, mut blocking, lanes) = (0u64, 0, self.pools[pool].lanes.count_ones());
            for t in (0..C::TASKS).filter(before) {
                let (other, [some, of]) = (&self.tasks[t], part(&self.tasks[t]));
                asked = asked.saturating_add(other.asks(pool, [some, of]));
                let is_long = |time: &u64| t != slot && some == of && signed(*time) > task.newest().slack;
                blocking += other.times(pool).filter(is_long).count();
            }
            asked <= LANE * u64::from(lanes) && blocking < lanes as usize
        })
    }
}

impl<C: Capacity> Task<C> {
    /// What some of so many of its jobs ask of the lanes of a pool, in millionths of one. Time bound: O(nodes).
    fn asks(&self, pool: usize, [some, of]: [u8; 2]) -> u64 {
        let work = self.times(pool).fold(0, u64::saturating_add);
        if work == 0 {
            return 0;
        }
        let period = self.timing.period().unwrap_or(self.timing.deadline).as_nanos();
        let asked = u128::from(work) * u128::from(some) * u128::from(LANE);
        let asked = asked.checked_div(u128::from(period) * u128::from(of));
        asked.and_then(|asked| u64::try_from(asked).ok()).unwrap_or(u64::MAX)
    }

    /// Mean times of its nodes in a pool, in nanoseconds.
    fn times(&self, pool: usize) -> impl Iterator<Item = u64> + '_ {
        let version = self.newest();
        version.in_pool[pool].iter().map(|rank| {
            let place = usize::from(version.order[rank]);
            mean_of(&self.nodes[place], &Estimator::of(self.shifts[place], &self.samples[place]))
        })
    }
}

#[cfg(test)]
mod tests;
