//! What goes when the monitor speaks of overload. The unit of shedding is the whole job.

use super::{Scheduler, action::ShedReason};
use crate::capacity::Capacity;
use crate::config::Shed;
use crate::policy::overload::urgency;
use crate::time::{Instant, Ppm};
use core::cmp::Reverse;

impl<C: Capacity> Scheduler<C> {
    pub(super) fn shed_overload(&mut self) {
        match self.config.shed {
            Shed::Never => {}
            Shed::LowestUrgency => self.drop_least_urgent(),
            Shed::Hopeless => self.drop_least_valuable(),
        }
    }

    /// While a job is behind: the not-started job of the lowest value, then of the most work, then the newest.
    /// At most one round per job.
    fn drop_least_valuable(&mut self) {
        while self.slots().any(|s| self.jobs[s].behind) {
            let droppable = |slot: &usize| !self.jobs[*slot].started && self.may_drop(*slot);
            let order = |slot: &usize| {
                let (job, work) = (&self.jobs[*slot], self.remaining_work(*slot));
                let value = self.tasks[job.task.index()].timing.value;
                (value, Reverse((work, job.release, job.task.index(), job.index)))
            };
            let Some(slot) = self.slots().filter(droppable).min_by_key(order) else { return };
            self.drop_by_choice(slot, ShedReason::Overload);
        }
    }

    /// The paper's ProactiveDrop: the jobs of queued sub-jobs, lowest urgency first and last in dispatch order
    /// among equals, while a queue is longer than Q_max, and at least one; then ticks are counted from 0 again.
    fn drop_least_urgent(&mut self) {
        self.monitor.over = 0;
        if self.reassigns {
            self.reassign();
        }
        // At most one round per job.
        loop {
            let this = &*self;
            let queued = this.slots().filter(|slot| this.may_drop(*slot)).flat_map(|slot| {
                let last = move |rank| Reverse((this.rank_key(slot, rank), rank));
                this.jobs[slot].ready.iter().map(move |rank| (this.urgency(slot, rank), last(rank), slot))
            });
            let Some((_, _, slot)) = queued.min() else { return };
            self.drop_by_choice(slot, ShedReason::Urgency);
            let longest = self.pool_numbers().map(|pool| self.queued_in(pool)).max();
            if longest <= Some(usize::from(self.config.overload.queue)) {
                return;
            }
        }
    }

    pub(super) fn queued_in(&self, pool: usize) -> usize {
        self.slots().map(|s| self.jobs[s].ready.and(&self.version(s).in_pool[pool]).len()).sum()
    }

    /// Whether a job may be given up by choice.
    fn may_drop(&self, slot: usize) -> bool {
        let job = &self.jobs[slot];
        self.tasks[job.task.index()].timing.floor.permits(job.index)
    }

    fn drop_by_choice(&mut self, slot: usize, reason: ShedReason) {
        let (task, index) = (self.jobs[slot].task.index(), self.jobs[slot].index);
        self.tasks[task].timing.floor.dropped(index);
        self.end_job(slot, Some(reason));
    }

    fn urgency(&self, slot: usize, rank: usize) -> Ppm {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let due = job.key_of(version, rank, self.residual).max(0).cast_unsigned();
        urgency(Instant::from_nanos(due).since(job.release), self.now.since(job.release))
    }
}
