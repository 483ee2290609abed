//! The clock's side of giving jobs up: when jobs may have become lost, and the paper's overload ticks.
//!
//! Looking at every job at every event would cost O(jobs * (nodes + edges)) each time. A job is not lost before
//! `safe_before`, its deadline less the least time in which it can end, and the forward schedule does not get worse
//! but by what is released, lost or outruns its estimate. `alarm` is never after the first of these instants.
//!
//! *Ticks of the paper's rule on a real clock.* They are at multiples of the tick. One at which `poll` is called sees
//! what all events of the instant left. Those that lie between two calls saw what the first of these left: lanes as
//! busy as since then, queues as long. The next call counts them all.

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
        /// From when on the forward schedule has to be looked at, whatever the lanes do.
        pub(super) worse: Instant,
        /// When it was last looked at.
        pub(super) looked: Instant,
        /// The least time that a job in flight had left then, in nanoseconds.
        pub(super) laxity: u64,
        /// Consecutive ticks with overload.
        pub(super) over: u32,
        /// Whether the tick at the start of the window was counted.
        counted: bool,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// First event of a new tick, or a step back of the clock.
    #[cold]
    pub(super) fn enter_tick(&mut self, now: Instant) -> Instant {
        if now < self.now {
            self.counters.clock_steps_back += 1;
            return self.now;
        }
        let tick = self.tick().as_nanos();
        let start = Instant::from_nanos(now.as_nanos() / tick * tick);
        if self.config.shed == Shed::LowestUrgency {
            self.pass_ticks(start, start == now);
        }
        (self.window, self.now) = (start, now);
        now
    }

    /// Counts the ticks up to `last` that nobody looked at, but not `last` itself if it begins now. Time bound:
    /// O(pools * jobs), however many there are.
    fn pass_ticks(&mut self, last: Instant, begins_now: bool) {
        if !self.monitor.counted {
            self.count_ticks(1);
        }
        let tick = self.tick().as_nanos();
        let ticks = (last.as_nanos() - self.window.as_nanos()) / tick;
        // The first that ended since, whose beginning something may have happened in; the others were alike.
        self.take_use(Instant::from_nanos(self.window.as_nanos() + tick));
        if ticks > 1 {
            self.count_ticks(1);
            self.take_use(Instant::from_nanos(last.as_nanos() - tick));
            self.take_use(last);
            self.count_ticks(ticks - 2);
        }
        self.monitor.counted = false;
        if !begins_now {
            self.count_ticks(1);
        }
    }

    /// Takes the lane time of the tick that ended at `start`, the first instant at which it is asked for.
    fn take_use(&mut self, start: Instant) {
        for pool in self.pool_numbers() {
            let mark = self.busy_until(pool, start);
            self.pools[pool].tick_busy = mark.wrapping_sub(self.pools[pool].mark);
            self.pools[pool].mark = mark;
        }
    }

    /// Counts ticks that see what is now.
    fn count_ticks(&mut self, ticks: u64) {
        if ticks == 0 {
            return;
        }
        let (overload, tick) = (self.config.overload, self.tick());
        let exceeded = self.pool_numbers().any(|pool| {
            let (p, queued) = (&self.pools[pool], self.queued_in(pool));
            let (busy, lanes) = (Duration::from_nanos(p.tick_busy), p.lanes.count_ones() as u8);
            p.observed > overload.utilisation || overload.exceeded(queued, busy, tick, lanes)
        });
        let ticks = u32::try_from(ticks).unwrap_or(u32::MAX);
        self.monitor.over = if exceeded { self.monitor.over.saturating_add(ticks) } else { 0 };
        self.monitor.counted = true;
    }

    /// Lane time of a pool used up to `instant`, which is not before the last event.
    fn busy_until(&self, pool: usize, instant: Instant) -> u64 {
        let lanes = bits(self.pools[pool].lanes.into()).map(|l| &self.lanes[l]);
        let running = lanes.filter(|l| l.is_busy()).map(|l| instant.since(l.started).as_nanos());
        running.fold(self.pools[pool].busy, u64::wrapping_add)
    }

    fn tick(&self) -> Duration {
        self.config.overload.tick.max(NEXT)
    }

    /// The tick that `poll` must not miss: this one, if it begins now and was not counted, or the next. None under
    /// other rules.
    fn next_tick(&self) -> Instant {
        match self.config.shed {
            Shed::LowestUrgency if !self.monitor.counted => self.window,
            Shed::LowestUrgency => self.window.saturating_add(self.tick()),
            Shed::Never | Shed::Hopeless => Instant::MAX,
        }
    }

    /// The next tick while there is a job, or a lane was busy since the last.
    fn tick_at(&self) -> Instant {
        let used = |pool: usize| self.busy_until(pool, self.now) != self.pools[pool].mark;
        let matters = self.config.shed == Shed::LowestUrgency
            && (self.in_flight != 0 || self.running_units() > 0 || self.pool_numbers().any(used));
        if matters { self.next_tick() } else { Instant::MAX }
    }

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
        if self.config.shed == Shed::Hopeless {
            (self.monitor.worse, self.alarm) = (Instant::ZERO, Instant::ZERO);
        }
    }

    /// Lanes or results went: the next `poll` looks at every job again, before anything else starts.
    pub(super) fn worsened(&mut self) {
        if self.config.shed == Shed::Hopeless {
            self.slots().for_each(|slot| self.jobs[slot].safe_before = Instant::ZERO);
            (self.monitor.worse, self.alarm) = (Instant::ZERO, Instant::ZERO);
        }
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
        let (mean, longest) = self.expected_to_run(l.slot.into(), l.rank.into());
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
        if ours && (self.now >= self.monitor.worse || self.now >= self.outrun_at()) {
            self.look();
        }
        if self.now >= self.monitor.wake {
            self.reopen();
        }
        self.alarm = self.next_tick().min(self.late_at()).min(self.monitor.wake);
        if ours && self.in_flight != 0 {
            let safe = self.slots().map(|slot| self.jobs[slot].safe_before).min().unwrap_or(Instant::MAX);
            // What starts from now on has outrun nothing before that.
            let spare = Duration::from_nanos(self.monitor.laxity).saturating_add(NEXT);
            let outrun = self.outrun_at().min(self.now.saturating_add(spare));
            self.alarm = self.alarm.min(safe).min(outrun).min(self.monitor.worse);
        }
    }

    /// The jobs that no schedule can end in time.
    fn certain(&mut self) -> u64 {
        let mut doomed = 0;
        for slot in self.slots() {
            let job = &self.jobs[slot];
            if self.now < job.safe_before {
                continue;
            }
            let latest_by = |case| {
                let left = job.deadline.as_nanos().checked_sub(self.bound(job, slot, case));
                left.map(Instant::from_nanos).filter(|latest| self.now <= *latest)
            };
            let latest = latest_by(Case::Worst).or_else(|| latest_by(Case::Best));
            doomed |= u64::from(latest.is_none()) << slot;
            self.jobs[slot].safe_before = latest.unwrap_or(self.now).saturating_add(NEXT);
        }
        doomed
    }

    /// Counts the tick whose instant events came at, once; whether shedding is due.
    fn tick_fires(&mut self) -> bool {
        if self.config.shed != Shed::LowestUrgency {
            return false;
        }
        if !self.monitor.counted {
            self.count_ticks(1);
        }
        self.age_keys();
        self.monitor.over >= u32::from(self.config.overload.ticks)
    }
}
