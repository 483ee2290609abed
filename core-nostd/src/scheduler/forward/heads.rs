//! Who is first in each pool of a forward schedule.
//!
//! *Why no queue.* A forward schedule starts each node once, and looks at the heads before each start. For 64 jobs at most a
//! scan without a branch is shorter than what a queue would have to move.

use crate::capacity::{Capacity, Empty};
use crate::scheduler::{Scheduler, bits};

/// No key: nothing is ready.
const NOTHING: i64 = i64::MAX;

crate::capacity::stored! {
    /// The keys of the jobs' first ready nodes.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Heads<C: Capacity> {
        /// The group in the order in which jobs of equal keys go, and where each of them stands in it.
        order: C::Jobs<u8>,
        place: C::Jobs<u8>,
        count: u8,
        /// By pool and place.
        keys: C::Pools<C::Jobs<i64>>,
        /// By pool: how many jobs have something ready.
        waiting: C::Pools<u8>,
    }
}

impl<C: Capacity> Heads<C> {
    /// Of a group of which nothing is ready yet. Time bound: O(jobs * pools), if slots were taken in the order of time.
    pub(super) fn of(scheduler: &Scheduler<C>, group: u64) -> Self {
        let mut new = Self::EMPTY;
        let tie = |slot: u8| {
            let job = &scheduler.jobs[usize::from(slot)];
            (job.release, job.fortune, job.task.index(), job.index)
        };
        for slot in bits(group) {
            let mut at = usize::from(new.count);
            while at > 0 && tie(new.order[at - 1]) > tie(slot as u8) {
                new.order[at] = new.order[at - 1];
                at -= 1;
            }
            new.order[at] = slot as u8;
            new.count += 1;
        }
        for at in 0..usize::from(new.count) {
            new.place[usize::from(new.order[at])] = at as u8;
            scheduler.pool_numbers().for_each(|pool| new.keys[pool][at] = NOTHING);
        }
        new
    }

    /// The job whose head is first in a pool. Time bound: O(jobs).
    pub(super) fn first(&self, pool: usize) -> Option<usize> {
        let keys = self.keys[pool].as_ref().get(..self.count.into()).filter(|_| self.waiting[pool] > 0)?;
        let least = keys.iter().copied().fold(NOTHING, i64::min);
        let at = keys.iter().position(|key| *key == least)?;
        Some(self.order[at].into())
    }

    /// What a job's first ready node in a pool has for a key, if anything is ready.
    pub(super) fn set(&mut self, pool: usize, slot: usize, key: Option<i64>) {
        let new = key.map_or(NOTHING, |key| key.min(NOTHING - 1));
        let old = core::mem::replace(&mut self.keys[pool][usize::from(self.place[slot])], new);
        let waiting = &mut self.waiting[pool];
        *waiting = waiting.wrapping_add(u8::from(new != NOTHING)).wrapping_sub(u8::from(old != NOTHING));
    }
}
