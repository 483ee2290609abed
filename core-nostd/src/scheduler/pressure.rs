//! Pressure: ranks go before keys while more comes than the lanes can do.
//!
//! *Background.* EDF lets a lower job run while a higher one can wait. Where more comes, the higher one lacks that time
//! later, and giving the lower one up then gives nothing back. Going by rank always would lose what EDF can carry.
//! *Rule.* There is pressure for twice the longest relative deadline after a look at which somebody was late by keys alone, but for no
//! more than 16 times the longest of the late ones: a task that has hours does not keep ranks in front for hours.
//! While it lasts, jobs go by band and then by key. Jobs that are worth more than every task that lost a job of late are one band:
//! nothing of them is lost, so that they need no order by rank. Those below follow by rank. A job that has started counts as
//! owed where its task's floor cannot spare another one: what was overtaken for that would have run for nothing.
//! *Why it ends.* Whether there is pressure is asked of the keys alone, so that what ranks make late does not prolong it
//! once those jobs went.

use super::{Scheduler, bits, forward::Forward, jobs::Job, standing::Rank, those};
use crate::capacity::{Capacity, Empty};
use crate::time::{Duration, Instant};
use core::cmp::Reverse;

impl<C: Capacity> Scheduler<C> {
    /// The forward schedule of all in flight, when pressure and bands are up to date. Time bound: two of these, and
    /// O(jobs * (jobs + nodes + edges)), with floors O(jobs * k) more.
    pub(super) fn forward_by_band(&mut self) -> Forward<C> {
        let before = self.monitor.pressed;
        // By keys alone. Queues follow in `set_bands`.
        self.slots().for_each(|slot| self.jobs[slot].band = 0);
        let forward = self.forward(self.in_flight);
        if forward.late != 0 {
            let time = |slot: usize| self.jobs[slot].deadline.since(self.jobs[slot].release);
            let longest = |jobs: u64| bits(jobs).map(time).max().unwrap_or_default().as_nanos();
            let time = longest(self.in_flight).min(longest(forward.late).saturating_mul(8));
            let until = self.now.saturating_add(Duration::from_nanos(time.saturating_mul(2)));
            self.press_until(before.max(until));
        }
        let forward = if self.set_bands() { self.forward(self.in_flight) } else { forward };
        if forward.late == 0 { forward } else { self.by_deadline().unwrap_or(forward) }
    }

    /// The forward schedule where jobs of a band go by deadline, if all are worth the same and none is late by that; it holds
    /// until the next look.
    fn by_deadline(&mut self) -> Option<Forward<C>> {
        let mut values = self.slots().map(|slot| self.tasks[self.jobs[slot].task.index()].timing.value);
        let first = values.next();
        if values.any(|value| Some(value) != first) {
            return None;
        }
        let mut bands = <C::Jobs<u8>>::EMPTY;
        self.slots().for_each(|slot| bands[slot] = self.jobs[slot].band);
        let mut order = <C::Jobs<Option<(u8, Reverse<Instant>)>>>::EMPTY;
        self.slots().for_each(|slot| order[slot] = Some((bands[slot], Reverse(self.jobs[slot].deadline))));
        self.band_by(|one, other| order[one] < order[other]);
        let forward = self.forward(self.in_flight);
        if forward.late == 0 {
            return Some(forward);
        }
        for slot in self.slots() {
            self.jobs[slot].band = bands[slot];
            self.requeue(slot);
        }
        None
    }

    /// Gives each job in flight the number of those below it for its band; whether bands differ.
    fn band_by(&mut self, is_below: impl Fn(usize, usize) -> bool) -> bool {
        let mut differ = false;
        for slot in self.slots() {
            let below = self.slots().filter(|other| is_below(*other, slot)).count();
            differ |= below > 0;
            self.jobs[slot].band = below as u8;
            self.requeue(slot);
        }
        differ
    }

    /// Sets until when there is pressure. Without it heads of pools start without a look at ranks.
    fn press_until(&mut self, until: Instant) {
        self.monitor.pressed = until;
        for pool in self.pools.as_mut() {
            pool.is_plain = !pool.limited && until == Instant::ZERO;
        }
    }

    /// A node of a task waits for a higher rank: there is pressure at least until its next job has been there, if there is any.
    pub(super) fn prolong_pressure(&mut self, task: usize) {
        if self.is_pressed() {
            let timing = &self.tasks[task].timing;
            let longest = timing.deadline.max(timing.period().unwrap_or_default());
            let until = self.now.saturating_add(longest).saturating_add(longest);
            self.press_until(self.monitor.pressed.max(until));
        }
    }

    /// Whether the last look found pressure.
    pub(super) fn is_pressed(&self) -> bool {
        self.monitor.pressed > Instant::ZERO
    }

    /// Gives each job in flight its band, by the pressure of now; whether bands differ.
    pub(super) fn set_bands(&mut self) -> bool {
        if !self.is_pressed() {
            return false;
        }
        let mut ranks = <C::Jobs<Option<(bool, bool, u32)>>>::EMPTY;
        if self.now < self.monitor.pressed {
            let timing = |slot: usize| &self.tasks[self.jobs[slot].task.index()].timing;
            let lost = self.slots().map(timing).filter(|timing| timing.floor.recently_lost() > 0);
            let level = lost.map(|timing| timing.value).max();
            let first = self.slots().next().map(|slot| self.jobs[slot].task);
            if self.slots().any(|slot| Some(self.jobs[slot].task) != first) {
                let is_owed = |job: &Job<C>| !self.floor_of(job).spares(job.index);
                let owed = those(self.in_flight, |slot| is_owed(&self.jobs[*slot]));
                self.slots().for_each(|slot| ranks[slot] = Some(self.band_rank(slot, owed, level)));
            }
        } else {
            self.press_until(Instant::ZERO);
        }
        self.band_by(|one, other| ranks[one] < ranks[other])
    }

    /// What orders bands: the rank, with what has started as owed as what its floor needs of its task; above the level
    /// all are alike.
    fn band_rank(&self, slot: usize, owed: u64, level: Option<u32>) -> (bool, bool, u32) {
        let job = &self.jobs[slot];
        let is_owed =
            owed >> slot & 1 != 0 || job.started && bits(owed).any(|other| self.jobs[other].task == job.task);
        let Rank { has_chance, value, .. } = self.rank(job, slot, self.floor_of(job));
        let is_safe = has_chance && (is_owed || Some(value) > level);
        if is_safe { (true, true, u32::MAX) } else { (has_chance, is_owed, value) }
    }
}
