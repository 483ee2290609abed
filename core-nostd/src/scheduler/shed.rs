//! What goes when the monitor speaks of overload. The unit of shedding is the whole job.

use super::Scheduler;
use super::action::ShedReason;
use crate::capacity::Capacity;
use crate::config::Shed;
use crate::policy::Urgency;
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
            let droppable = |slot: &usize| {
                let job = &self.jobs[*slot];
                !job.started && self.tasks[usize::from(job.task)].floor.permits(job.index())
            };
            let order = |slot: &usize| {
                let job = &self.jobs[*slot];
                let value = self.tasks[usize::from(job.task)].value;
                (value, Reverse(self.remaining_work(*slot)), Reverse(job.release), Reverse(job.tie))
            };
            let Some(slot) = self.slots().filter(droppable).min_by_key(order) else { return };
            let (task, index) = (usize::from(self.jobs[slot].task), self.jobs[slot].index());
            self.tasks[task].floor.dropped(index);
            self.end_job(slot, Some(ShedReason::Overload));
        }
    }

    /// The paper's ProactiveDrop: jobs of queued sub-jobs, lowest urgency first, while the queue is longer than
    /// Q_max, and at least one; then the ticks are counted from 0 again.
    fn drop_least_urgent(&mut self) {
        self.monitor.over = 0;
        loop {
            let order = |slot: &usize| (self.urgency(*slot), Reverse(self.jobs[*slot].release), Reverse(self.jobs[*slot].tie));
            let queued = self.slots().filter(|s| !self.jobs[*s].ready.is_empty());
            let Some(slot) = queued.min_by_key(order) else { return };
            self.end_job(slot, Some(ShedReason::Urgency));
            if self.ready_sub_jobs() <= usize::from(self.config.overload.queue) {
                return;
            }
        }
    }

    /// Lowest urgency among a job's queued sub-jobs.
    fn urgency(&self, slot: usize) -> Urgency {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let elapsed = self.now.since(job.release);
        let of = |rank| {
            let due = job.key_of(version, rank, self.config.residual());
            let due = crate::time::Instant::from_nanos(due.max(0).cast_unsigned());
            Urgency::of(due.since(job.release), elapsed)
        };
        job.ready.iter().map(of).min().unwrap_or(Urgency::of(job.deadline.since(job.release), elapsed))
    }
}
