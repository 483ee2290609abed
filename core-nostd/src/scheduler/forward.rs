//! The forward schedule: what happens from now on if nothing else comes and every node takes its estimate.
//!
//! *Rule.* Lanes are taken up as they are: each is free when what is left of its unit has passed. Then the rule that
//! dispatches is run forward by the keys of now, over a group of jobs in flight. An encoder whose result is kept, or
//! is computed on the way, runs once for all of the group. What another job holds of a lane stays held until it ends. What
//! was dispatched ahead keeps its lane. Jobs that go *behind* the others start nothing before all of these that need one of their pools have ended.
//! *What it leaves out.* Memory budgets, merging beyond one run per result, level gates, other lanes that wait, what will be
//! dispatched ahead.
//! *Time bound.* O(jobs + lanes + successors) for each node that starts or ends, with encoders O(jobs * encoders).

mod course;
mod heads;
mod promises;
mod results;
mod stop;

use super::{Scheduler, bits, those};
use crate::capacity::{Capacity, Empty};
use crate::time::Instant;
use course::Course;

/// How the jobs of a group end in a forward schedule. Instants are in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forward<C: Capacity> {
    /// When each job ends; the end of time where it never does.
    pub(super) end: C::Jobs<u64>,
    /// When each job next starts a node; the end of time where it starts none.
    first: C::Jobs<u64>,
    /// The pools in which it starts any.
    pools: C::Jobs<u32>,
    /// Jobs that end after their deadline, a bit each.
    pub(super) late: u64,
    /// The least time between the end and the deadline of a job that is not late; the longest time without one.
    pub(super) laxity: u64,
}

impl<C: Capacity> Forward<C> {
    /// Before it begins.
    const NEW: Self =
        Self { end: Empty::EMPTY, first: Empty::EMPTY, pools: Empty::EMPTY, late: 0, laxity: u64::MAX };

    /// Of some jobs, those that start a node before another one ends, in a pool that this one still needs.
    pub(super) fn in_the_way(&self, of: usize, among: u64) -> u64 {
        let meets = |slot: &usize| self.first[*slot] < self.end[of] && self.share_a_pool(of, *slot);
        those(among, meets)
    }

    /// With who of the group is late, and how close the others are.
    fn judged(mut self, scheduler: &Scheduler<C>, group: u64) -> Self {
        for slot in bits(group) {
            match scheduler.jobs[slot].deadline.as_nanos().checked_sub(self.end[slot]) {
                Some(laxity) => self.laxity = self.laxity.min(laxity),
                None => self.late |= 1 << slot,
            }
        }
        self
    }

    /// Whether a job starts a node in one of some pools.
    pub(super) fn needs(&self, job: usize, pools: u32) -> bool {
        self.pools[job] & pools != 0
    }

    /// By how much a job is late, in nanoseconds; 0 if it is not.
    pub(super) fn lateness(&self, job: usize, deadline: Instant) -> u64 {
        self.end[job].saturating_sub(deadline.as_nanos())
    }

    /// Whether two jobs start nodes in a common pool.
    pub(super) fn share_a_pool(&self, one: usize, other: usize) -> bool {
        self.pools[one] & self.pools[other] != 0
    }
}

impl<C: Capacity> Scheduler<C> {
    /// The forward schedule of a group of jobs in flight, a bit each.
    pub(super) fn forward(&self, group: u64) -> Forward<C> {
        self.forward_behind(group, 0)
    }

    /// The same where some of the group go behind the others.
    #[cold]
    pub(super) fn forward_behind(&self, group: u64, behind: u64) -> Forward<C> {
        Course::new(self, group, behind).run()
    }

    /// Whether a job of a group ends by its deadline in the group's forward schedule. Time bound: as that, or less.
    #[cold]
    pub(super) fn ends_in_time(&self, slot: usize, group: u64) -> bool {
        Course::new(self, group, 0).ends_in_time(slot)
    }
}
