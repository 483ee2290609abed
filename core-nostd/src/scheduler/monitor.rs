//! The clock's side of shedding: when jobs may have become hopeless, and the overload ticks.
//!
//! Looking at every job at every event would cost O(jobs * (nodes + edges)) each time. A job whose worst case
//! still ends in time is not hopeless and has no negative slack, so it needs no look before `safe_until`, its
//! deadline less its longest remaining path; ticks before the first of these instants change nothing and are
//! not asked for.

use super::Scheduler;
use super::action::ShedReason;
use super::bits;
use super::outlook::Case;
use crate::capacity::Capacity;
use crate::config::{Late, Shed};
use crate::time::{Duration, Instant};

/// The clock's unit: the first instant after another.
const NEXT: Duration = Duration::from_nanos(1);

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Monitor {
        /// Next tick that can matter.
        tick_at: Instant,
        /// When the host has to poll even if nothing happens.
        pub(super) wake: Instant,
        /// Last tick that was looked at, plus one nanosecond; 0 before the first.
        looked_at: u64,
        /// Consecutive ticks with overload.
        pub(super) over: u8,
        /// Jobs whose worst case ends after their deadline.
        pub(super) behind: u8,
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
        let tick = self.tick();
        let start = Instant::from_nanos(now.as_nanos() / tick.as_nanos() * tick.as_nanos());
        let before = Instant::from_nanos(start.as_nanos().saturating_sub(tick.as_nanos()));
        // Nothing happened since the last event, so the lanes tell how busy they were up to any instant since.
        for pool in 0..usize::from(self.pool_count) {
            let base =
                if before == self.window { self.pools[pool].mark } else { self.busy_until(pool, before) };
            let mark = self.busy_until(pool, start);
            self.pools[pool].mark = mark;
            self.pools[pool].tick_busy = mark.saturating_sub(base);
        }
        let follows = before == self.window;
        self.window = start;
        self.now = now;
        if self.config.shed == Shed::LowestUrgency && self.in_flight == 0 && now > start {
            self.pass_idle_tick(follows);
        }
        now
    }

    /// A tick passed that nobody asked for, because no job was in flight: nothing was queued, but lanes may have
    /// been busy up to it.
    fn pass_idle_tick(&mut self, follows: bool) {
        let overload = self.config.overload;
        let busy = (0..usize::from(self.pool_count)).any(|pool| {
            let p = &self.pools[pool];
            overload.exceeded(0, Duration::from_nanos(p.tick_busy), self.tick(), p.lanes.count_ones() as u8)
        });
        let over = self.monitor.over + 1;
        self.monitor.over = if follows && busy && over < overload.ticks { over } else { 0 };
        self.monitor.looked_at = self.window.as_nanos() + 1;
    }

    /// Lane time of a pool used up to `instant`, which is not before the last event.
    fn busy_until(&self, pool: usize, instant: Instant) -> u64 {
        let lanes = bits(self.pools[pool].lanes.into()).map(|l| &self.lanes[l]);
        let running = lanes.filter(|l| l.is_busy()).map(|l| instant.since(l.started).as_nanos());
        self.pools[pool].busy + running.sum::<u64>()
    }

    fn tick(&self) -> Duration {
        self.config.overload.tick.max(Duration::from_nanos(1))
    }

    /// The first tick that was not looked at: this one if it begins now.
    fn next_tick(&self) -> Instant {
        let fresh = self.now == self.window && self.monitor.looked_at != self.window.as_nanos() + 1;
        if fresh { self.window } else { self.window.saturating_add(self.tick()) }
    }

    /// A job was released: ticks and its own outlook may matter earlier.
    pub(super) fn watch(&mut self, slot: usize) {
        if self.in_flight.count_ones() == 1 {
            self.monitor.tick_at = Instant::MAX;
            self.monitor.wake = Instant::MAX;
            self.alarm = Instant::MAX;
        }
        let tick = match self.config.shed {
            Shed::Never => Instant::MAX,
            Shed::LowestUrgency => self.next_tick(),
            Shed::Hopeless if self.jobs[slot].behind => self.next_tick(),
            Shed::Hopeless => self.tick_after(self.jobs[slot].safe_until),
        };
        self.monitor.tick_at = self.monitor.tick_at.min(tick);
        self.monitor.wake = self.monitor.wake.min(self.monitor.tick_at).min(self.late_at(slot));
        self.alarm = self.alarm.min(self.monitor.wake).min(self.look_at(slot));
    }

    /// A unit that started makes jobs longer: the next event looks at them, or the next tick if that is earlier.
    pub(super) fn look_soon(&mut self) {
        // A tick of this instant came before what started.
        self.monitor.tick_at = self.monitor.tick_at.min(self.window.saturating_add(self.tick()));
        self.monitor.wake = self.monitor.wake.min(self.monitor.tick_at);
        self.alarm = self.alarm.min(self.now.saturating_add(NEXT));
    }

    /// The first tick after `instant` that was not looked at.
    fn tick_after(&self, instant: Instant) -> Instant {
        let tick = self.tick().as_nanos();
        let next = (instant.as_nanos() / tick + 1).saturating_mul(tick);
        Instant::from_nanos(next).max(self.next_tick())
    }

    /// From when on an event must look at a job. No event is made for it: while one of its nodes runs, the
    /// instant moves along with the clock.
    fn look_at(&self, slot: usize) -> Instant {
        match self.config.shed {
            Shed::Hopeless => self.jobs[slot].safe_until.saturating_add(NEXT),
            _ => Instant::MAX,
        }
    }

    /// When a job is given up for being late.
    fn late_at(&self, slot: usize) -> Instant {
        match self.config.late {
            Late::AbortJob => self.jobs[slot].deadline.saturating_add(NEXT),
            Late::Continue => Instant::MAX,
        }
    }

    /// Tick, sheds, and when to look again.
    pub(super) fn monitor_and_shed(&mut self) {
        let doomed = if self.config.shed == Shed::Hopeless { self.look_ahead() } else { 0 };
        let fires = self.now >= self.monitor.tick_at && self.tick_fires();
        for slot in bits(doomed) {
            self.end_job(slot, Some(ShedReason::Hopeless));
        }
        if self.config.late == Late::AbortJob {
            let late = self.slots().filter(|s| self.now > self.jobs[*s].deadline).fold(0, |m, s| m | 1 << s);
            for slot in bits(late) {
                self.end_job(slot, Some(ShedReason::Late));
            }
        }
        if fires {
            self.shed_overload();
        }
        self.monitor.behind = self.slots().filter(|s| self.jobs[*s].behind).count() as u8;
        self.monitor.tick_at = match self.config.shed {
            Shed::Never => Instant::MAX,
            Shed::LowestUrgency => self.next_tick(),
            Shed::Hopeless if self.monitor.behind > 0 => self.next_tick(),
            Shed::Hopeless => {
                let first = self.slots().map(|s| self.jobs[s].safe_until).min();
                first.map_or(Instant::MAX, |safe| self.tick_after(safe))
            }
        };
        let late = self.slots().map(|slot| self.late_at(slot)).min();
        let look = self.slots().map(|slot| self.look_at(slot)).min();
        self.monitor.wake = self.monitor.tick_at.min(late.unwrap_or(Instant::MAX));
        self.alarm = self.monitor.wake.min(look.unwrap_or(Instant::MAX));
    }

    /// Brings the outlook of every job that needs it up to date; returns those that are lost for certain.
    fn look_ahead(&mut self) -> u64 {
        let mut doomed = 0;
        for slot in self.slots() {
            let deadline = self.jobs[slot].deadline;
            let outlook = |path: u64| {
                let left = deadline.as_nanos().checked_sub(path);
                left.map(Instant::from_nanos).filter(|latest| self.now <= *latest)
            };
            // A best case may have grown since (a short sample left the window): look at those again, always.
            let waits = self.waits_longer(slot);
            if self.now <= self.jobs[slot].safe_until && !self.jobs[slot].behind && !waits {
                continue;
            }
            let worst = outlook(self.remaining_path(slot, Case::Worst));
            let best = if worst.is_some() && !waits {
                worst
            } else {
                outlook(self.remaining_path(slot, Case::Best))
            };
            doomed |= u64::from(best.is_none()) << slot;
            self.jobs[slot].safe_until = worst.or(best).unwrap_or(self.now);
            self.jobs[slot].behind = worst.is_none();
        }
        doomed
    }

    /// Looks at a tick; whether shedding is due.
    fn tick_fires(&mut self) -> bool {
        let asked = self.monitor.tick_at;
        self.monitor.tick_at = Instant::MAX;
        self.age_keys();
        if asked != self.window {
            // A tick that nobody looked at in time: nothing was seen, so nothing goes on.
            self.monitor.over = 0;
            return false;
        }
        let tick = self.tick();
        let follows = self.monitor.looked_at == (self.window.as_nanos() + 1).wrapping_sub(tick.as_nanos());
        self.monitor.looked_at = self.window.as_nanos() + 1;
        let overload = self.config.overload;
        let exceeded = (0..usize::from(self.pool_count)).any(|pool| {
            let p = &self.pools[pool];
            overload.exceeded(
                self.queued_in(pool),
                Duration::from_nanos(p.tick_busy),
                tick,
                p.lanes.count_ones() as u8,
            )
        });
        let late = self.config.shed != Shed::Hopeless || self.slots().any(|s| self.jobs[s].behind);
        let before = if follows { self.monitor.over } else { 0 };
        self.monitor.over = if exceeded && late { before.saturating_add(1) } else { 0 };
        self.monitor.over >= overload.ticks
    }
}
