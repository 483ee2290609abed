//! The overload ticks of the paper's rule, on a real clock.
//!
//! *Rule.* They are at multiples of the tick. One at which `poll` is called sees what all events of the instant left.
//! Those that lie between two calls saw what the first of these left: lanes as busy as since then, queues as long. The
//! next call counts them all.

use super::{Scheduler, bits};
use crate::capacity::Capacity;
use crate::config::Shed;
use crate::time::{Duration, Instant};

/// A tick is at least this long.
const SHORTEST: Duration = Duration::from_nanos(1);

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
        self.config.overload.tick.max(SHORTEST)
    }

    /// The tick that `poll` must not miss: this one, if it begins now and was not counted, or the next. None under
    /// other rules.
    pub(super) fn next_tick(&self) -> Instant {
        match self.config.shed {
            Shed::LowestUrgency if !self.monitor.counted => self.window,
            Shed::LowestUrgency => self.window.saturating_add(self.tick()),
            Shed::Never | Shed::Hopeless => Instant::MAX,
        }
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
        if !self.monitor.counted {
            self.count_ticks(1);
        }
        self.age_keys();
        self.monitor.over >= u32::from(self.config.overload.ticks)
    }
}
