//! `release`: a new job, its sources ready.

use super::{
    Scheduler,
    action::ShedReason,
    bits,
    event::EventKind,
    jobs::{Job, Release},
};
use crate::capacity::{Capacity, Empty};
use crate::config::{Gate, Shed};
use crate::id::{JobId, TaskId};
use crate::policy::frame_cache::CaptureSource;
use crate::time::Instant;
use core::hint::cold_path;

crate::error::errors! {
    /// A release was refused. Nothing changed but the time, and what a look that was due gave up; on `Full` the host counts the job as shed with that reason.
    pub enum ReleaseError {
        /// The task is not admitted, or was removed.
        UnknownTask,
        /// `C::JOBS` jobs are in flight, none of a lower rank, or have ended and wait to be taken. The job's index is
        /// used up.
        Full,
        /// The release, or its deadline, lies beyond 2^63 ns.
        Overflow,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Releases a job of `task` now. Errors and time bound: as `release_at`.
    pub fn release(&mut self, task: TaskId, now: Instant) -> Result<JobId, ReleaseError> {
        self.release_at(task, now, None, now)
    }

    /// Releases a job whose release was at `release`, for hosts that learn of it later. `capture` is the number
    /// of the frame it reads; `None` takes the sensors' periods, and a capture of its own where a frame has no
    /// sensor. Under `Shed::Hopeless` a job that finds the table full takes the place of one that ranks below it, whose
    /// outcome [`take_outcome`](Self::take_outcome) or `poll` gives next: take that before the next release. Time bound:
    /// O(nodes), in a full table O(jobs * (nodes + edges)). Errors: [`ReleaseError`].
    #[inline(always)]
    pub fn release_at(
        &mut self,
        task: TaskId,
        release: Instant,
        capture: Option<u64>,
        now: Instant,
    ) -> Result<JobId, ReleaseError> {
        self.advance(now);
        let t = self.task_slot(task).ok_or(ReleaseError::UnknownTask)?;
        let fortune = self.fortune_of(t);
        let task_entry = &mut self.tasks[t];
        let due = release.checked_add(task_entry.timing.deadline).filter(|d| d.as_nanos() <= i64::MAX as u64);
        let deadline = due.ok_or(ReleaseError::Overflow)?;
        let index = task_entry.next_job;
        task_entry.next_job += 1;
        task_entry.released = release;
        let current = task_entry.current;
        let (capture, source) =
            capture.map_or((self.releases + 1, CaptureSource::Job), |capture| (capture, CaptureSource::Host));
        let new = Release { task, index, version: current, fortune, release, deadline, capture, source };
        let slot = (self.in_flight | self.ended).trailing_ones() as usize;
        let slot = if slot < C::JOBS { slot } else { self.displace(&new)? };
        self.releases += 1;
        let version = &mut self.tasks[t].versions[usize::from(current)];
        version.users += 1;
        let job = &mut self.jobs[slot];
        let generation = job.generation;
        job.begin(&new, version);
        job.generation = generation;
        let has_encoders = !version.encoders.is_empty();
        self.in_flight |= 1 << slot;
        if self.warnings != 0 {
            cold_path();
            self.forget_warnings_of(slot);
        }
        self.note_task(EventKind::Released, t, index);
        self.watch(slot);
        if self.config.gate == Gate::Level {
            self.open_level(slot);
        }
        if has_encoders {
            self.meet_outputs(slot);
        }
        if self.residual {
            self.residual_key(slot);
        }
        self.changed(slot);
        if self.lost != 0 {
            self.end_if_lost(slot);
        }
        Ok(JobId::new(slot, generation))
    }

    /// The place for a job that finds the table full: that of the least job, which is given up, if it ranks below.
    #[cold]
    fn displace(&mut self, new: &Release) -> Result<usize, ReleaseError> {
        let task = new.task.index();
        let mut job = Job::EMPTY;
        job.begin(new, self.tasks[task].newest());
        // Of an outcome that was not taken nothing may be forgotten.
        let may_take = self.config.shed == Shed::Hopeless && self.displaced.shed.is_none();
        let was_shed = |slot: &usize| self.jobs[*slot].shed.is_some();
        if may_take && let Some(ended) = bits(self.ended).find(was_shed) {
            // By the look that was due before this call, perhaps. Whether its warning was taken may not matter: that is no input.
            self.displaced = self.outcome_of(ended);
            return Ok(ended);
        }
        let Some(least) = (if may_take { self.gives_way_to(&job) } else { None }) else {
            self.tasks[task].timing.floor.ended(new.index, true);
            self.note_task(EventKind::Refused, task, new.index);
            return Err(ReleaseError::Full);
        };
        self.end_job(least, Some(ShedReason::Full));
        self.displaced = self.outcome_of(least);
        Ok(least)
    }

    /// Called after a job's ready set changed.
    pub(super) fn changed(&mut self, slot: usize) {
        if self.residual {
            cold_path();
            if self.reassigns {
                self.age_keys();
            } else {
                self.residual_key(slot);
            }
        }
        self.requeue(slot);
    }

    /// Something happened. Where every dispatch re-assigns, the keys of all jobs move with the clock, so that any
    /// pool may have another head.
    pub(super) fn age_keys(&mut self) {
        if self.reassigns {
            self.stale_keys = true;
            self.activate_all();
        }
    }
}
