//! The clock's side of shedding: when jobs may have become hopeless, and the overload ticks.
//!
//! Looking at every job at every event would cost O(jobs * (nodes + edges)) each time. A job whose worst case
//! still ends in time is not hopeless and has no negative slack, so it needs no look before `safe_until`, its
//! deadline less its longest remaining path; ticks before the first of these instants change nothing and are
//! not asked for.

use super::{Scheduler, action::ShedReason, bits, outlook::Case};
use crate::capacity::Capacity;
use crate::config::{Late, Shed};
use crate::time::{Duration, Instant};

/// The clock's unit: the first instant after another.
const NEXT: Duration = Duration::from_nanos(1);

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Monitor {
        /// Last tick that was looked at, plus one nanosecond; 0 before the first.
        looked_at: u64,
        /// When a lane that is left idle is asked for again.
        pub(super) wake: Instant,
        /// Consecutive ticks with overload.
        pub(super) over: u8,
        /// Whether the worst case of a job may end after its deadline.
        pub(super) behind: bool,
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
        let start = now.as_nanos() / tick * tick;
        let before = Instant::from_nanos(start.saturating_sub(tick));
        // Nothing happened since the last event, so the lanes tell how busy they were up to any instant since.
        for pool in self.pool_numbers() {
            let base =
                if before == self.window { self.pools[pool].mark } else { self.busy_until(pool, before) };
            let mark = self.busy_until(pool, Instant::from_nanos(start));
            self.pools[pool].mark = mark;
            self.pools[pool].tick_busy = mark.wrapping_sub(base);
        }
        (self.window, self.now) = (Instant::from_nanos(start), now);
        now
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

    /// The tick that goes on, as `looked_at` has it: at the last instant of the clock it is none.
    fn this_tick(&self) -> u64 {
        self.window.as_nanos().wrapping_add(1)
    }

    /// The first tick that was not looked at: this one if it begins now.
    fn next_tick(&self) -> Instant {
        let fresh = self.now == self.window && self.monitor.looked_at != self.this_tick();
        if fresh { self.window } else { self.window.saturating_add(self.tick()) }
    }

    /// The first tick that can matter. The paper's rule needs every tick while there is a job, and that after
    /// which no lane had been busy; ours those at which a job may be behind.
    fn tick_at(&self) -> Option<Instant> {
        let busy = || {
            let used = |pool: usize| self.busy_until(pool, self.now) != self.pools[pool].mark;
            self.in_flight != 0 || self.running_units() > 0 || self.pool_numbers().any(used)
        };
        match self.config.shed {
            Shed::Never => None,
            Shed::LowestUrgency => busy().then(|| self.next_tick()),
            Shed::Hopeless if self.in_flight != 0 && self.monitor.behind => Some(self.next_tick()),
            Shed::Hopeless => {
                let tick = self.tick().as_nanos();
                let safe = self.slots().map(|slot| self.jobs[slot].safe_until.as_nanos()).min()?;
                Some(Instant::from_nanos((safe / tick + 1).saturating_mul(tick)).max(self.next_tick()))
            }
        }
    }

    /// When `poll` has to decide even if nothing happens; any other call may change it. Time bound: O(jobs + lanes).
    #[must_use]
    pub fn poll_at(&self) -> Option<Instant> {
        let late = self.slots().map(|slot| self.late_at(slot)).min();
        let at = self.tick_at().into_iter().chain(late).min().unwrap_or(Instant::MAX).min(self.monitor.wake);
        (at < Instant::MAX).then_some(at)
    }

    /// A job was released: `poll` may have to look earlier.
    pub(super) fn watch(&mut self, slot: usize) {
        if self.in_flight.count_ones() == 1 {
            (self.monitor.behind, self.alarm) = (false, Instant::MAX);
        }
        self.alarm = self.alarm.min(self.look_at(slot)).min(self.tick_to_keep());
        self.look_now();
    }

    /// What started, or went to make room, made jobs longer: the next event or tick looks at them.
    pub(super) fn look_soon(&mut self, is_longer: impl Fn(&Self, usize) -> bool) {
        if self.config.shed != Shed::Hopeless {
            return;
        }
        let longer = self.slots().filter(|slot| is_longer(self, *slot)).fold(0, |set, slot| set | 1 << slot);
        if longer == 0 {
            return;
        }
        bits(longer).for_each(|slot| self.jobs[slot].behind = true);
        (self.monitor.behind, self.attends) = (true, true);
        if self.next_tick() == self.now {
            // A tick of this instant came before that.
            (self.monitor.looked_at, self.monitor.over) = (self.this_tick(), 0);
        }
        self.alarm = self.alarm.min(self.now.saturating_add(NEXT));
    }

    /// Something happened: where a job may be lost, `poll` looks, also if time has not moved since it last did.
    pub(super) fn look_now(&mut self) {
        self.reopen();
        if self.monitor.behind {
            self.alarm = Instant::ZERO;
        }
    }

    /// The tick that `poll` must not miss.
    fn tick_to_keep(&self) -> Instant {
        match self.config.shed {
            Shed::LowestUrgency => self.next_tick(),
            Shed::Hopeless if self.monitor.behind => self.next_tick(),
            Shed::Never | Shed::Hopeless => Instant::MAX,
        }
    }

    /// From when on an event must look at a job. Where it may be hopeless no event is made for it: while one of
    /// its nodes runs, the instant moves along with the clock.
    fn look_at(&self, slot: usize) -> Instant {
        let is_watched = self.config.shed == Shed::Hopeless;
        let doubt = if is_watched { self.jobs[slot].safe_until.saturating_add(NEXT) } else { Instant::MAX };
        doubt.min(self.late_at(slot))
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
        let fires = self.tick_fires();
        bits(doomed).for_each(|slot| self.end_job(slot, Some(ShedReason::Hopeless)));
        for slot in self.slots() {
            if self.config.late == Late::AbortJob && self.now > self.jobs[slot].deadline {
                self.end_job(slot, Some(ShedReason::Late));
            }
        }
        if fires {
            self.shed_overload();
        }
        self.monitor.behind = self.slots().any(|slot| self.jobs[slot].behind);
        self.attends = self.observes;
        if self.now >= self.monitor.wake {
            self.reopen();
        }
        let look = self.slots().map(|slot| self.look_at(slot)).min();
        self.alarm = self.tick_to_keep().min(look.unwrap_or(Instant::MAX)).min(self.monitor.wake);
    }

    /// Brings the outlook of every job that needs it up to date; returns those that are lost for certain.
    fn look_ahead(&mut self) -> u64 {
        let mut doomed = 0;
        for slot in self.slots() {
            // A best case may have grown since (a short sample left the window): look at those again, always.
            let waits = self.waits_longer(slot);
            let job = &self.jobs[slot];
            if self.now <= job.safe_until && !job.behind && !waits {
                continue;
            }
            let outlook = |case| {
                let left = job.deadline.as_nanos().checked_sub(self.remaining_path(slot, case));
                left.map(Instant::from_nanos).filter(|latest| self.now <= *latest)
            };
            let worst = outlook(Case::Worst);
            let best = if worst.is_some() && !waits { worst } else { outlook(Case::Best) };
            doomed |= u64::from(best.is_none()) << slot;
            let job = &mut self.jobs[slot];
            (job.safe_until, job.behind) = (worst.or(best).unwrap_or(self.now), worst.is_none());
        }
        doomed
    }

    /// Looks at the tick that begins now, once; whether shedding is due. A tick that nobody looked at in time was
    /// not seen, so nothing goes on over it.
    fn tick_fires(&mut self) -> bool {
        let (overload, tick) = (self.config.overload, self.tick());
        let follows = self.monitor.looked_at == self.this_tick().wrapping_sub(tick.as_nanos());
        if self.next_tick() != self.now {
            return false;
        }
        self.monitor.looked_at = self.this_tick();
        self.age_keys();
        let exceeded = self.pool_numbers().any(|pool| {
            let (p, queued) = (&self.pools[pool], self.queued_in(pool));
            let (busy, lanes) = (Duration::from_nanos(p.tick_busy), p.lanes.count_ones() as u8);
            p.observed > overload.utilisation || overload.exceeded(queued, busy, tick, lanes)
        });
        let late = self.config.shed != Shed::Hopeless || self.slots().any(|slot| self.jobs[slot].behind);
        let before = if follows { self.monitor.over } else { 0 };
        self.monitor.over = if exceeded && late { before.saturating_add(1) } else { 0 };
        self.monitor.over >= overload.ticks
    }
}
