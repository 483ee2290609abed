//! `release`: a new job, its sources ready.

use super::{Scheduler, event::EventKind, jobs::Job};
use crate::capacity::{Capacity, Empty};
use crate::config::{Gate, Shed};
use crate::id::{JobId, TaskId};
use crate::policy::frame_cache::CaptureSource;
use crate::time::Instant;
use core::hint::cold_path;

crate::error::errors! {
    /// A release was refused. Nothing changed but the time; on `Full` the host counts the job as shed with that reason.
    pub enum ReleaseError {
        /// The task is not admitted, or was removed.
        UnknownTask,
        /// `C::JOBS` jobs are in flight, or have ended and wait to be taken. The job's index is used up.
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
    /// sensor. Time bound: O(nodes). Errors: [`ReleaseError`].
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
        let task_entry = &mut self.tasks[t];
        let due = release.checked_add(task_entry.timing.deadline).filter(|d| d.as_nanos() <= i64::MAX as u64);
        let deadline = due.ok_or(ReleaseError::Overflow)?;
        let index = task_entry.next_job;
        task_entry.next_job += 1;
        task_entry.released = release;
        let slot = (self.in_flight | self.ended).trailing_ones() as usize;
        if slot >= C::JOBS {
            self.note_task(EventKind::Refused, t, index);
            return Err(ReleaseError::Full);
        }
        self.releases += 1;
        let current = self.tasks[t].current;
        let version = &mut self.tasks[t].versions[usize::from(current)];
        version.users += 1;
        let job = &mut self.jobs[slot];
        let (generation, key) = (job.generation, release.as_nanos().cast_signed());
        // Written in place: a literal of this size would be built elsewhere and copied.
        *job = Job::EMPTY;
        (job.task, job.index, job.generation, job.version) = (task, index, generation, current);
        job.left = version.len.into();
        (job.release, job.deadline, job.key) = (release, deadline, key);
        job.capture = capture.unwrap_or(self.releases);
        job.source = if capture.is_some() { CaptureSource::Host } else { CaptureSource::Job };
        job.safe_until = Instant::from_nanos(key.saturating_add(version.slack).max(0).cast_unsigned());
        job.ready = version.sources;
        job.waiting_for = version.indegree;
        // Latest start before the epoch: that instant cannot be written, so the job counts as behind at once.
        job.behind = key < version.slack.saturating_neg();
        let (lost, has_encoders) = (job.behind, !version.encoders.is_empty());
        self.in_flight |= 1 << slot;
        self.note_task(EventKind::Released, t, index);
        self.watch(slot);
        if lost || has_encoders && self.config.shed == Shed::Hopeless && self.waits_longer(slot) {
            self.alarm = Instant::ZERO;
        }
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
