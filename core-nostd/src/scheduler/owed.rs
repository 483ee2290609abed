//! Floors as they will stand: jobs that are to be lost count as lost before they are.
//!
//! *Why.* One more lost job, and a floor cannot spare the next one. Where that is known only once the job is lost, the lanes are taken already.
//! *Rule.* When jobs get their ranks, a job that is late even without all others in flight, as lanes are held, counts as lost. When a
//! node asks for whom it has to wait, so does a job that needs lanes before so many are free again behind it. Only tasks with a floor are looked at.

use super::{Scheduler, bits, those};
use crate::capacity::{Capacity, Empty};
use crate::id::TaskId;
use crate::policy::floor::Floor;

impl<C: Capacity> Scheduler<C> {
    /// All floors, if of some jobs that are late those count as lost that are late alone. Time bound: a forward schedule of one job for each.
    #[inline(never)]
    pub(super) fn floors_without(&self, late: u64) -> C::Tasks<Floor> {
        let has_floor = |slot: &usize| self.floor_of(&self.jobs[*slot]).needs_some();
        let is_lost = |slot: &usize| has_floor(slot) && !self.ends_in_time(*slot, 1 << *slot);
        let mut floors = self.floors();
        for job in bits(those(late, is_lost)).map(|slot| &self.jobs[slot]) {
            floors[job.task.index()].ended(job.index, true);
        }
        floors
    }

    /// All floors, if of other tasks than one the jobs count as lost that need lanes of a pool before so many are free. Time bound: O(jobs)
    /// spreads.
    pub(super) fn floors_behind(&self, pool: usize, own: TaskId, free: &C::Lanes<u64>) -> C::Tasks<Floor> {
        let mut floors = self.floors();
        let is_looked_at = |slot: &usize| {
            let job = &self.jobs[*slot];
            job.task != own && self.floor_of(job).needs_some()
        };
        let mut left = those(self.in_flight, is_looked_at);
        // The first of a task tells what the floor makes of the next one.
        while let Some(slot) = bits(left).min_by_key(|slot| self.jobs[*slot].index) {
            let job = &self.jobs[slot];
            let floor = &mut floors[job.task.index()];
            if floor.spares(job.index) && self.need_of(pool, slot).starts_before(self.now.as_nanos(), free) {
                floor.ended(job.index, true);
            }
            left &= !(1 << slot);
        }
        floors
    }

    fn floors(&self) -> C::Tasks<Floor> {
        let mut floors = <C::Tasks<Floor>>::EMPTY;
        (0..C::TASKS).for_each(|task| floors[task] = self.tasks[task].timing.floor);
        floors
    }
}

#[cfg(test)]
mod tests;
