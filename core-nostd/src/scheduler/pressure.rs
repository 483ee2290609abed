//! Pressure: ranks go before keys while more comes than the lanes can do.
//!
//! *Background.* EDF lets a lower job run while a higher one can wait. Where more comes, the higher one lacks that time
//! later, and giving the lower one up then gives nothing back. Going by rank always would lose what EDF can carry.
//! *Rule.* There is pressure for four times the longest relative deadline after a look at which somebody was late by keys alone, but for no
//! more than 16 times the longest of the late ones: a task that has hours does not keep ranks in front for hours. It is in the pools
//! that a late job needs, and in those that jobs in flight tie to them: what fits elsewhere is left alone.
//! While it lasts, jobs go by band and then by key. Jobs that are worth more than every task that lost several of late are one band:
//! next to nothing of them is lost, so that they need no order by rank. Those below follow by rank. A job that has started counts as
//! owed where its task's floor cannot spare another one: what was overtaken for that would have run for nothing.
//! *By deadline.* Latest starts put the longest way first, which may be the newest job's, and bands put first whoever is worth more, though it
//! could wait. So deadlines order a band instead where that has all in time; and all bands from that of a late job on whose task could be
//! whole, if that has all of such tasks in time. Where none of these is late, a late job of a task with a floor gets that in their stead, if it
//! makes nobody late: a floor that lost what it can spare would else go before a higher value that could be in time, too.
//! *Why it ends.* Whether there is pressure is asked of the keys alone, so that what ranks make late does not prolong it
//! once those jobs went.

use super::{Scheduler, bits, forward::Forward, jobs::Job, standing::Rank, those};
use crate::capacity::{Capacity, Empty};
use crate::policy::floor::{Floor, RECENT};
use crate::time::{Duration, Instant};
use core::cmp::Reverse;

/// Of its last 16 jobs. Fewer are chance, or what ranks themselves cost it, and would keep ranks in front for ever.
const SEVERAL: u32 = RECENT / 4;

impl<C: Capacity> Scheduler<C> {
    /// The forward schedule of all in flight, when pressure and bands are up to date, and floors where who is late alone counts as lost.
    /// Time bound: four forward schedules and one of a job for each of a task with a floor, and
    /// O(jobs * (jobs + nodes + edges + pools * tasks * (nodes + jobs))), with floors O(jobs * k) more.
    pub(super) fn forward_by_band(&mut self) -> (Forward<C>, C::Tasks<Floor>) {
        // By keys alone. Queues follow in `set_bands`.
        self.slots().for_each(|slot| self.jobs[slot].band = 0);
        let forward = self.forward(self.in_flight);
        let time = |slot: usize| self.jobs[slot].deadline.since(self.jobs[slot].release);
        let longest = |jobs: u64| bits(jobs).map(time).max().unwrap_or_default().as_nanos();
        let mut pressed = <C::Pools<u64>>::EMPTY;
        for (pools, jobs) in self.tied(forward.late) {
            let time = longest(jobs).min(longest(forward.late & jobs).saturating_mul(4));
            bits(pools.into()).for_each(|pool| pressed[pool] = time.saturating_mul(4));
        }
        for pool in self.pool_numbers().filter(|pool| pressed[*pool] > 0) {
            let until = self.now.saturating_add(Duration::from_nanos(pressed[pool]));
            self.pools[pool].pressed = self.pools[pool].pressed.max(until);
        }
        let floors = self.floors_without(forward.late);
        let forward = if self.set_bands(&floors) { self.forward(self.in_flight) } else { forward };
        (self.by_deadline(forward, self.in_flight, 0), floors)
    }

    /// The same of those that are left of a look so far, if floors stand so. Time bound: three forward schedules.
    #[inline(never)]
    pub(super) fn forward_again(&mut self, group: u64, behind: u64, floors: &C::Tasks<Floor>) -> Forward<C> {
        self.set_bands(floors);
        let forward = self.forward_behind(group, behind);
        self.by_deadline(forward, group, behind)
    }

    /// Some jobs in flight by what ties them: the pools of each tie, and all jobs that need these. Time bound: O(jobs * pools).
    fn tied(&self, mut some: u64) -> impl Iterator<Item = (u32, u64)> + '_ {
        let needs = |slot: usize| self.version(slot).pool_mask;
        core::iter::from_fn(move || {
            let first = bits(some).next()?;
            let (mut pools, mut jobs) = (needs(first), 1 << first);
            loop {
                let more = those(self.in_flight & !jobs, |slot| needs(*slot) & pools != 0);
                if more == 0 {
                    some &= !jobs;
                    return Some((pools, jobs));
                }
                pools = bits(more).fold(pools, |pools, slot| pools | needs(slot));
                jobs |= more;
            }
        })
    }

    /// The forward schedule where jobs that are tied to a late one go by band and deadline; from the lowest band on of a late one whose task
    /// could be whole, by deadline alone. It holds until the next look, where so none of such tasks is late there; else the one that there was
    /// does. Where no late one is of such a task, those with a floor are meant: what the floor needs goes first, and it holds where nobody is
    /// late there who was not, either. Where there is none of these, it holds where nobody is late.
    fn by_deadline(&mut self, by_band: Forward<C>, group: u64, behind: u64) -> Forward<C> {
        let late = by_band.late;
        if late == 0 {
            return by_band;
        }
        let mut order = <C::Jobs<Option<(u8, bool, Reverse<Instant>, u8)>>>::EMPTY;
        let (mut ties, mut tied, mut saved) = (<C::Pools<u64>>::EMPTY, 0, 0);
        for (tie, (_, jobs)) in ties.as_mut().iter_mut().zip(self.tied(late)) {
            let band = |slot: usize| self.jobs[slot].band;
            let mut main = those(jobs, |slot| self.can_be_whole(self.jobs[*slot].task.index()));
            let is_by_floor = late & main == 0;
            if is_by_floor {
                main = those(jobs, |slot| self.floor_of(&self.jobs[*slot]).needs_some());
            }
            let first = bits(late & main).map(band).min();
            let is_above = |slot: &usize| first.is_some_and(|first| first <= band(*slot));
            for slot in bits(jobs) {
                let (job, by_rank, is_first) = (&self.jobs[slot], band(slot), is_above(&slot));
                let by_floor = is_by_floor && is_first;
                let is_owed = by_floor && !self.floor_of(job).spares(job.index);
                let band = if is_first { u8::MAX } else { by_rank };
                order[slot] =
                    Some((band, is_owed, Reverse(job.deadline), if by_floor { by_rank } else { 0 }));
            }
            let to_save = if is_by_floor { main | jobs & !late } else { main };
            let needed = if first.is_some() { those(to_save, is_above) } else { jobs };
            (*tie, tied, saved) = (jobs, tied | jobs, saved | needed);
        }
        let mut bands = <C::Jobs<u8>>::EMPTY;
        self.slots().for_each(|slot| bands[slot] = self.jobs[slot].band);
        self.band_by(tied, |one, other| order[one] < order[other]);
        let forward = self.forward_behind(group, behind);
        let failed = ties.as_ref().iter().filter(|jobs| forward.late & saved & *jobs != 0);
        let failed = failed.fold(0, |all, jobs| all | jobs);
        for slot in bits(failed) {
            self.jobs[slot].band = bands[slot];
            self.requeue(slot);
        }
        match failed {
            0 => forward,
            _ if failed == tied => by_band,
            _ => self.forward_behind(group, behind),
        }
    }

    /// Gives each of some jobs the number of those below it for its band; whether bands differ.
    fn band_by(&mut self, jobs: u64, is_below: impl Fn(usize, usize) -> bool) -> bool {
        let mut differ = false;
        for slot in bits(jobs) {
            let below = bits(jobs).filter(|other| is_below(*other, slot)).count();
            differ |= below > 0;
            self.jobs[slot].band = below as u8;
            self.requeue(slot);
        }
        differ
    }

    /// Whether the last look found pressure in a pool.
    pub(super) fn is_pressed(&self, pool: usize) -> bool {
        self.pools[pool].pressed > Instant::ZERO
    }

    /// Gives each job in flight its band, by the pressure of now and as floors stand; whether bands differ.
    pub(super) fn set_bands(&mut self, floors: &C::Tasks<Floor>) -> bool {
        let (mut before, mut pressed) = (0, 0);
        for pool in self.pool_numbers() {
            let p = &mut self.pools[pool];
            before |= u32::from(p.pressed > Instant::ZERO) << pool;
            if self.now < p.pressed {
                pressed |= 1 << pool;
            } else {
                p.pressed = Instant::ZERO;
            }
        }
        if before == 0 {
            return false;
        }
        let mut ranks = <C::Jobs<Option<(bool, bool, u32, u32)>>>::EMPTY;
        let is_in = |slot: &usize| self.version(*slot).pool_mask & pressed != 0;
        for (_, jobs) in self.tied(those(self.in_flight, is_in)) {
            let timing = |slot: usize| &self.tasks[self.jobs[slot].task.index()].timing;
            let lost = bits(jobs).map(timing).filter(|timing| timing.floor.recently_lost() >= SEVERAL);
            let level = lost.map(|timing| timing.value).max();
            let first = bits(jobs).next().map(|slot| self.jobs[slot].task);
            if bits(jobs).any(|slot| Some(self.jobs[slot].task) != first) {
                let is_owed = |job: &Job<C>| !floors[job.task.index()].spares(job.index);
                let owed = those(jobs, |slot| is_owed(&self.jobs[*slot]));
                bits(jobs).for_each(|slot| ranks[slot] = Some(self.band_rank(slot, owed, level)));
            }
        }
        self.band_by(self.in_flight, |one, other| ranks[one] < ranks[other])
    }

    /// What orders bands: the rank, so that a probe that is due goes before its equals, with what has started as owed as what
    /// its floor needs of its task; above the level all are alike.
    fn band_rank(&self, slot: usize, owed: u64, level: Option<u32>) -> (bool, bool, u32, u32) {
        let job = &self.jobs[slot];
        let is_owed =
            owed >> slot & 1 != 0 || job.started && bits(owed).any(|other| self.jobs[other].task == job.task);
        let Rank { has_chance, value, due, .. } = self.rank(job, slot, self.floor_of(job));
        let is_safe = has_chance && (is_owed || Some(value) > level);
        if is_safe { (true, true, u32::MAX, 0) } else { (has_chance, is_owed, value, due) }
    }
}
