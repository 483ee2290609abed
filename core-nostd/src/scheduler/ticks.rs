//! The overload ticks of the paper's rule, on a real clock.
//!
//! *Rule.* They are at multiples of the tick. One at which `poll` is called sees what all events of the instant left.
//! Those that nobody looked at saw what the last event at or before them left: lanes as busy as since then, queues as
//! long. The first call after them counts them, and if they are enough, gives up of what they saw, before it does what it
//! is for. On a real clock most ticks are such; otherwise what waits would be the next node of whoever just completed one.

use super::{Scheduler, bits};
use crate::capacity::Capacity;
use crate::config::Shed;
use crate::time::{Duration, Instant};

/// A tick is at least this long.
const SHORTEST: Duration = Duration::from_nanos(1);

impl<C: Capacity> Scheduler<C> {
    /// First events of a new tick, or after a look became due, or a step back of the clock.
    #[cold]
    pub(super) fn enter_tick(&mut self, now: Instant) -> Instant {
        if now < self.now {
            self.counters.clock_steps_back += 1;
            return self.now;
        }
        let is_worse = self.catch_up(now);
        let tick = self.tick().as_nanos();
        if self.config.shed != Shed::LowestUrgency {
            self.window = Instant::from_nanos(now.as_nanos() / tick * tick);
        } else if let Some(before) = now.as_nanos().checked_sub(1) {
            self.pass_ticks(before / tick * tick);
        }
        self.now = now;
        if is_worse {
            self.delayed();
        }
        now
    }

    /// None was counted yet: the first is at 0.
    pub(super) const fn begin_ticks(&mut self) {
        if matches!(self.config.shed, Shed::LowestUrgency) {
            self.window = Instant::from_nanos(self.tick().as_nanos().wrapping_neg());
        }
    }

    /// Counts the ticks after the last that was counted, up to one at `last`. Time bound: O(pools * jobs) for each job that
    /// is given up, however many there are.
    fn pass_ticks(&mut self, last: u64) {
        let tick = self.tick().as_nanos();
        let ticks = last.wrapping_sub(self.window.as_nanos()) / tick;
        if ticks == 0 {
            return;
        }
        // The first, before which something may have happened; the others are alike.
        let first = self.after_window();
        self.take_use(first);
        self.pass(1, first.as_nanos());
        if ticks > 1 {
            self.take_use(Instant::from_nanos(last - tick));
            self.take_use(Instant::from_nanos(last));
            self.pass(ticks - 1, last);
        }
        self.window = Instant::from_nanos(last);
    }

    /// The tick after the last that was counted; before the first, that at 0.
    const fn after_window(&self) -> Instant {
        Instant::from_nanos(self.window.as_nanos().wrapping_add(self.tick().as_nanos()))
    }

    /// Counts ticks that nobody looked at, up to that at `last`, and gives up jobs at each that makes them enough.
    fn pass(&mut self, ticks: u64, last: u64) {
        self.count_ticks(ticks);
        // Each round gives somebody up, or is the last.
        while let Some(rest) = self.monitor.over.checked_sub(self.config.overload.ticks.into()) {
            let before = self.in_flight;
            let since = self.tick().as_nanos().saturating_mul(rest.into());
            self.now = Instant::from_nanos(last.saturating_sub(since));
            self.drop_least_urgent();
            let is_last = self.in_flight == before;
            let rest = if is_last { rest % u32::from(self.config.overload.ticks).max(1) } else { rest };
            self.count_ticks(rest.into());
            if is_last {
                break;
            }
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
    }

    /// Lane time of a pool used up to `instant`, which is not before the last event.
    fn busy_until(&self, pool: usize, instant: Instant) -> u64 {
        let lanes = bits(self.pools[pool].lanes.into()).map(|l| &self.lanes[l]);
        let running = lanes.filter(|l| l.is_busy()).map(|l| instant.since(l.started).as_nanos());
        running.fold(self.pools[pool].busy, u64::wrapping_add)
    }

    const fn tick(&self) -> Duration {
        let tick = self.config.overload.tick;
        if tick.as_nanos() == 0 { SHORTEST } else { tick }
    }

    /// The tick that `poll` must not miss. None under other rules.
    pub(super) fn next_tick(&self) -> Instant {
        let next = self.after_window();
        // At the end of the clock there is no further one.
        let is_last = next < self.window && self.now >= self.window;
        if self.config.shed == Shed::LowestUrgency && !is_last { next } else { Instant::MAX }
    }

    /// The next tick while there is a job, or a lane was busy since the last.
    pub(super) fn tick_at(&self) -> Instant {
        let used = |pool: usize| self.busy_until(pool, self.now) != self.pools[pool].mark;
        let matters = self.config.shed == Shed::LowestUrgency
            && (self.in_flight != 0 || self.running_units() > 0 || self.pool_numbers().any(used));
        if matters { self.next_tick() } else { Instant::MAX }
    }

    /// Counts the tick whose instant events came at, once; whether shedding is due.
    pub(super) fn tick_fires(&mut self) -> bool {
        if self.config.shed != Shed::LowestUrgency {
            return false;
        }
        let next = self.after_window();
        if self.now == next {
            self.take_use(next);
            self.count_ticks(1);
            self.window = next;
        }
        self.age_keys();
        self.monitor.over >= u32::from(self.config.overload.ticks)
    }
}
