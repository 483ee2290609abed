//! The paper's ProactiveDrop: what goes when the monitor speaks of overload. The unit of shedding is the whole job.

use super::{Scheduler, action::ShedReason};
use crate::capacity::Capacity;
use crate::policy::overload::urgency;
use crate::time::{Instant, Ppm};
use core::cmp::Reverse;

impl<C: Capacity> Scheduler<C> {
    /// The jobs of queued sub-jobs, lowest urgency first and last in dispatch order among equals, while a queue is
    /// longer than Q_max, and at least one; then ticks are counted from 0 again.
    pub(super) fn drop_least_urgent(&mut self) {
        self.monitor.over = 0;
        if self.reassigns {
            self.reassign();
        }
        // At most one round per job.
        loop {
            let this = &*self;
            let may_go = |slot: &usize| this.floor_of(&this.jobs[*slot]).spares(this.jobs[*slot].index);
            let queued = this.slots().filter(may_go).flat_map(|slot| {
                let last = move |rank| Reverse((this.rank_key(slot, rank), rank));
                this.jobs[slot].ready.iter().map(move |rank| (this.urgency(slot, rank), last(rank), slot))
            });
            let Some((_, _, slot)) = queued.min() else { return };
            self.end_job(slot, Some(ShedReason::Urgency));
            let longest = self.pool_numbers().map(|pool| self.queued_in(pool)).max();
            if longest <= Some(usize::from(self.config.overload.queue)) {
                return;
            }
        }
    }

    pub(super) fn queued_in(&self, pool: usize) -> usize {
        self.slots().map(|s| self.jobs[s].ready.and(&self.version(s).in_pool[pool]).len()).sum()
    }

    fn urgency(&self, slot: usize, rank: usize) -> Ppm {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let due = job.key_of(version, rank, self.residual).max(0).cast_unsigned();
        urgency(Instant::from_nanos(due).since(job.release), self.now.since(job.release))
    }
}
