//! The clock's side of giving jobs up: when jobs may have become lost or late.
//!
//! Looking at every job at every event would cost O(jobs * (nodes + edges)) each time. A job is not lost before
//! the instant `at`, its deadline less the least time in which it can end, and the forward schedule does not get worse
//! but by what is released, lost or outruns its estimate. `alarm` is never after the first of these instants.

use super::{Scheduler, action::ShedReason, bits, outlook::Case};
use crate::capacity::Capacity;
use crate::config::{Late, Shed};
use crate::time::{Duration, Instant};

/// The clock's unit: the first instant after another.
const NEXT: Duration = Duration::from_nanos(1);

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Monitor {
        /// When a lane that is left idle is asked for again.
        pub(super) wake: Instant,
        /// When the forward schedule was last looked at.
        pub(super) looked: Instant,
        /// The least time that a job in flight had left then, in nanoseconds.
        pub(super) laxity: u64,
        /// Consecutive ticks with overload.
        pub(super) over: u32,
        /// Whether the forward schedule has to be looked at, whatever the lanes do.
        pub(super) is_worse: bool,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// When `poll` has to decide even if nothing happens; any other call may change it. Time bound: O(jobs + lanes).
    #[must_use]
    pub fn poll_at(&self) -> Option<Instant> {
        // Estimates may have become shorter since `alarm` was set: `poll` looks then, and no earlier.
        let outrun = self.outrun_at().max(self.alarm);
        let at = self.tick_at().min(self.late_at()).min(self.monitor.wake).min(outrun);
        (at < Instant::MAX).then_some(at)
    }

    /// A job was released: `poll` looks at the forward schedule.
    pub(super) fn watch(&mut self, slot: usize) {
        self.reopen();
        self.alarm = self.alarm.min(self.next_tick()).min(self.aborted_at(slot));
        self.delayed();
    }

    /// More is to come, or it comes later: the next `poll` looks at the forward schedule, or the next event at another instant.
    pub(super) fn delayed(&mut self) {
        if self.config.shed == Shed::Hopeless {
            (self.monitor.is_worse, self.alarm) = (true, Instant::ZERO);
            // The last instant of its window is now.
            let tick = self.config.overload.tick.as_nanos();
            self.window = Instant::from_nanos(self.now.as_nanos().wrapping_sub(tick).wrapping_add(1));
        }
    }

    /// Makes up for looks that were due before `now`, as of then: nobody polls while all lanes are busy, and later the schedule
    /// would not show who was late, and because of whom. Whether units that took longer may have used up what was left then.
    pub(super) fn catch_up(&mut self, now: Instant) -> bool {
        let is_busy = self.pool_numbers().all(|pool| self.pools[pool].free == 0);
        if !(self.monitor.is_worse && is_busy && now > self.now) {
            return false;
        }
        while self.monitor.is_worse {
            self.monitor_and_shed();
        }
        now.since(self.now).as_nanos() > self.monitor.laxity
    }

    /// Lanes or results went: the next `poll` looks at every job again, before anything else starts.
    pub(super) fn worsened(&mut self) {
        if self.config.shed == Shed::Hopeless {
            self.slots().for_each(|slot| self.jobs[slot].at = Instant::ZERO);
        }
        self.delayed();
    }

    /// When the first job is given up for being late.
    fn late_at(&self) -> Instant {
        let continues = self.config.late == Late::Continue;
        let slots = if continues { 0 } else { self.in_flight };
        bits(slots).map(|slot| self.aborted_at(slot)).min().unwrap_or(Instant::MAX)
    }

    fn aborted_at(&self, slot: usize) -> Instant {
        match self.config.late {
            Late::AbortJob => self.jobs[slot].deadline.saturating_add(NEXT),
            Late::Continue => Instant::MAX,
        }
    }

    /// When the first running unit will have outrun its estimate by more than anybody in flight can spare.
    fn outrun_at(&self) -> Instant {
        if self.config.shed != Shed::Hopeless || self.in_flight == 0 || self.monitor.laxity == u64::MAX {
            return Instant::MAX;
        }
        let busy =
            (0..self.lanes()).filter(|lane| self.lanes[*lane].members != 0 && self.lanes[*lane].is_busy());
        busy.map(|lane| self.outruns_at(lane)).min().unwrap_or(Instant::MAX)
    }

    /// When the unit on a lane will have outrun its estimate, or after that the longest of its last executions, by more
    /// than the laxity; then each time that it has run twice as long as when it was last looked at.
    fn outruns_at(&self, lane: usize) -> Instant {
        let l = &self.lanes[lane];
        let (mean, longest) = self.expected_on(lane);
        let begun = i128::from(l.started.as_nanos()) - i128::from(l.carried.as_nanos());
        let spare = i128::from(self.monitor.laxity) + 1;
        let looked = i128::from(self.monitor.looked.as_nanos());
        let known = [mean, longest].map(|cost| begun + i128::from(cost) + spare);
        let at = known.into_iter().find(|at| *at > looked).unwrap_or(looked + (looked - begun).max(1));
        Instant::from_nanos(u64::try_from(at).unwrap_or(u64::MAX))
    }

    /// Ticks, jobs to give up, and when to look again.
    pub(super) fn monitor_and_shed(&mut self) {
        let ours = self.config.shed == Shed::Hopeless;
        let doomed = if ours { self.certain() } else { 0 };
        let fires = self.tick_fires();
        bits(doomed).for_each(|slot| self.end_job(slot, Some(ShedReason::Hopeless)));
        for slot in self.slots() {
            if self.config.late == Late::AbortJob && self.now > self.jobs[slot].deadline {
                self.end_job(slot, Some(ShedReason::Late));
            }
        }
        if fires {
            self.drop_least_urgent();
        }
        if self.now >= self.monitor.wake {
            self.reopen();
        }
        if ours && (self.monitor.is_worse || self.now >= self.outrun_at()) {
            self.look();
        }
        self.alarm = self.next_tick().min(self.late_at()).min(self.monitor.wake);
        if ours && self.in_flight != 0 {
            let safe = self.slots().map(|slot| self.jobs[slot].at).min().unwrap_or(Instant::MAX);
            // What starts from now on has outrun nothing before that.
            let spare = Duration::from_nanos(self.monitor.laxity).saturating_add(NEXT);
            let outrun = self.outrun_at().min(self.now.saturating_add(spare));
            let again = if self.monitor.is_worse { Instant::ZERO } else { Instant::MAX };
            self.alarm = self.alarm.min(safe).min(outrun).min(again);
        }
    }

    /// The jobs that no schedule can end in time; each is warned of.
    fn certain(&mut self) -> u64 {
        let (mut doomed, warned) = (0, self.warnings);
        for slot in self.slots() {
            let job = &self.jobs[slot];
            if self.now < job.at {
                continue;
            }
            let due = job.deadline.as_nanos();
            let end = |case| self.now.as_nanos().saturating_add(self.bound(job, slot, case));
            let spare = [Case::Worst, Case::Best].into_iter().find_map(|case| due.checked_sub(end(case)));
            if spare.is_none() {
                doomed |= 1 << slot;
                self.warn(slot, end(Case::Best).saturating_sub(due), None);
            }
            let latest = self.now.saturating_add(Duration::from_nanos(spare.unwrap_or_default()));
            self.jobs[slot].at = latest.saturating_add(NEXT);
        }
        self.note_warnings(warned);
        doomed
    }
}
