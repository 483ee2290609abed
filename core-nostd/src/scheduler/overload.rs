//! Overload: who is given up so that others end in time.
//!
//! *Rule.* The first job x of the forward schedule that is late is looked at beside all that start a node before it
//! ends, where it needs lanes too. If the least of those below it has not started, will wait for x, and is in time though it goes behind
//! all others, nobody goes. If x were in time without all that are below it, the least of those in the way goes, or another of the least's
//! rank that is late, where fewer are late without that one. Otherwise x goes where another, which could be in time, is late beside it, or, if
//! it has not started, where the next one of its task is to be late because of it; and where none is, x stays, and goes last:
//! it costs nobody anything, and so do estimates recover. The schedule is run again, by ranks of then if a floor needs another job because
//! of one that is lost. Of several that went, those come back that need not be gone.
//! *Why it holds.* What goes is below x and saves it, or is late itself. So a job is late because of lower ranks only
//! where these hold lanes already.
//! *Time bound.* A look runs at most 9 * [`MOST`] + 6 * [`Capacity::JOBS`] + 4 forward schedules.

use super::standing::Standing;
use super::{Scheduler, action::ShedReason, bits, forward::Forward, outlook::Case, those};
use crate::capacity::{Capacity, Empty};
use crate::config::Gate;
use crate::policy::floor::Floor;
use crate::time::Instant;

/// Jobs that go in one look; a further look takes up the rest.
const MOST: u32 = 16;

impl<C: Capacity> Scheduler<C> {
    /// Looks at the forward schedule, and gives up who has to go. Time bound: the module's.
    #[cold]
    pub(super) fn look(&mut self) {
        (self.monitor.is_worse, self.monitor.looked) = (false, self.now);
        if let Some(laxity) = self.fits_by_far() {
            debug_assert!(self.forward(self.in_flight).laxity >= laxity, "the bound is enough");
            debug_assert!(self.forward(self.in_flight).late == 0, "the bound is enough");
            self.monitor.laxity = laxity;
            self.set_bands(&self.floors_without(0));
            return;
        }
        let ((forward, floors), warned) = (self.forward_by_band(), self.warnings);
        let (stay, laxity) =
            if forward.late == 0 { (self.in_flight, forward.laxity) } else { self.choose(forward, floors) };
        self.monitor.laxity = laxity;
        self.note_warnings(warned);
        let gone = self.in_flight & !stay;
        self.monitor.is_worse &= gone != 0;
        bits(gone).for_each(|slot| self.end_job(slot, Some(ShedReason::Overload)));
    }

    /// Who stays, with a warning for each that does not and each that is late, and the laxity of the forward schedule of these.
    fn choose(&mut self, mut forward: Forward<C>, mut floors: C::Tasks<Floor>) -> (u64, u64) {
        let mut standings = <C::Jobs<Option<Standing>>>::EMPTY;
        for slot in self.slots() {
            standings[slot] = Some(self.standing(slot, &floors[self.jobs[slot].task.index()]));
        }
        let (mut stay, mut kept) = (self.in_flight, 0);
        let (mut behind, mut tried) = (0u64, 0u64);
        let known = those(self.in_flight, |slot| self.is_warned_of(*slot));
        // Each round puts a job behind others, or keeps one or lets one go: either is lost to its task.
        while let Some(x) = self.first_late(&forward, !kept) {
            let below = |slot: &usize| standings[*slot] < standings[x];
            let lower = those(forward.in_the_way(x, stay), below);
            let least = bits(lower).min_by_key(|slot| standings[*slot]);
            if let Some(least) = least.filter(|least| tried >> *least & 1 == 0 && self.may_wait(*least, x)) {
                tried |= 1 << least;
                let late = self.late_in(stay, behind | 1 << least);
                if late & !(forward.late & !(1 << least)) == 0 {
                    behind |= 1 << least;
                    forward = self.forward_behind(stay, behind);
                    continue;
                }
            }
            let is_doubted = self.is_doubted(&self.jobs[x]);
            let is_needed = |y: usize| {
                (!is_doubted || standings[y] > standings[x])
                    && forward.share_a_pool(x, y)
                    && self.can_end_in_time(&self.jobs[y], y, Case::Expected)
            };
            let cause = self.cause_of(x, &forward, stay, &standings);
            let (loses, because, goes) = if let Some(least) = least
                && self.ends_in_time(x, stay & !those(stay, below))
            {
                let rank = |slot: usize| standings[slot].map(|standing| standing.rank);
                let equals = those(lower & !(1 << least), |slot| rank(*slot) == rank(least));
                let late = |without: usize| self.late_in(stay & !(1 << without), behind).count_ones();
                let other = self.first_late(&forward, equals).filter(|other| late(*other) < late(least));
                (other.unwrap_or(least), Some(x), true)
            } else {
                let is_in_the_way = bits(forward.late & !kept & !(1 << x)).any(is_needed);
                (x, cause, is_in_the_way || self.harms_next(x, &forward, stay))
            };
            self.warn(loses, forward.lateness(loses, self.jobs[loses].deadline), because);
            if goes {
                stay &= !(1 << loses);
                forward = self.forward_behind(stay, behind);
            } else {
                kept |= 1 << x;
            }
            if (self.in_flight & !stay).count_ones() >= MOST {
                self.monitor.is_worse = true;
                break;
            }
            let task = self.jobs[loses].task;
            floors[task.index()].ended(self.jobs[loses].index, true);
            let mut is_raised = false;
            for slot in bits(stay).filter(|slot| self.jobs[*slot].task == task) {
                let now = self.standing(slot, &floors[task.index()]);
                is_raised |= standings[slot].is_some_and(|before| before.rank < now.rank);
                standings[slot] = Some(now);
            }
            if is_raised {
                forward = self.forward_again(stay, behind, &floors);
            }
        }
        let mut gone = self.in_flight & !stay;
        // Each round takes one of those that went, the greatest first.
        while let Some(slot) = bits(gone).max_by_key(|slot| standings[*slot]) {
            gone &= !(1 << slot);
            if self.late_in(stay | 1 << slot, behind) & !kept == 0 {
                stay |= 1 << slot;
                forward = self.forward_behind(stay, behind);
                if (known | kept) >> slot & 1 == 0 {
                    self.withdraw_warning(slot);
                }
            }
        }
        self.postpone(stay, &forward);
        (stay, forward.laxity)
    }

    /// Has jobs that stay, have not started and are late by more than their best case saves go behind all others until the
    /// next look: they run where a lane would be idle, and what they began would keep later ones from their lanes. A lane
    /// that may wait for them could still save them.
    fn postpone(&mut self, stay: u64, forward: &Forward<C>) {
        let is_lost = |slot: &usize| {
            let job = &self.jobs[*slot];
            if job.started || self.config.gate == Gate::Lookahead {
                return false;
            }
            let [expected, best] = [Case::Expected, Case::Best].map(|case| self.bound(job, *slot, case));
            forward.lateness(*slot, job.deadline) > expected.saturating_sub(best)
        };
        let lost = those(stay & forward.late, is_lost);
        for slot in self.slots().filter(|_| lost != 0) {
            let band = self.jobs[slot].band;
            self.jobs[slot].band = if lost >> slot & 1 != 0 { 0 } else { band + 1 };
            self.requeue(slot);
        }
    }

    /// Who is late in a forward schedule. Its own frame: none of them takes room in that of a look.
    #[inline(never)]
    fn late_in(&self, group: u64, behind: u64) -> u64 {
        self.forward_behind(group, behind).late
    }

    /// Whether the nodes of a job will wait for one above it, as far as it would be late because of them.
    fn may_wait(&self, low: usize, high: usize) -> bool {
        let own = || self.beside_next(low, self.floor_of(&self.jobs[low]));
        let is_waited_for =
            || self.is_waited_for(high, self.floor_of(&self.jobs[high]), self.jobs[low].task, own());
        !self.jobs[low].started && !self.config.preempt && is_waited_for()
    }

    /// Whether a late job that has not started makes the next one of its task late, by its period. A probe may.
    fn harms_next(&self, x: usize, forward: &Forward<C>, stay: u64) -> bool {
        let job = &self.jobs[x];
        let task = &self.tasks[job.task.index()];
        let due = task.timing.period().map(|period| task.released.saturating_add(period));
        let Some(due) = due.filter(|due| *due > self.now) else { return false };
        let beside = bits(stay & !(1 << x)).filter(|y| forward.share_a_pool(x, *y));
        let others = beside.map(|y| forward.end[y]).filter(|end| *end < u64::MAX).max().unwrap_or_default();
        let latest = due.as_nanos().saturating_add_signed(task.newest().slack);
        // Whom its estimates make late on lanes of its own, these make late again.
        let fits = || self.bound(job, x, Case::Expected) <= job.deadline.since(job.release).as_nanos();
        !job.started
            && fits()
            && !task.is_probe(job.index)
            && self.can_gain(task, task.next_job)
            && (others..forward.end[x]).contains(&latest)
    }

    /// The late job that ends first, of some.
    fn first_late(&self, forward: &Forward<C>, among: u64) -> Option<usize> {
        let order = |slot: &usize| {
            let job = &self.jobs[*slot];
            (forward.end[*slot], job.release, job.task.index(), job.index)
        };
        bits(forward.late & among).min_by_key(order)
    }

    /// Whether all that is in flight ends before the earliest deadline in any order, and by how much: a test that is
    /// enough, by Graham's bound at WCET. Time bound: O(jobs * pools), where no WCET was exceeded of late.
    fn fits_by_far(&mut self) -> Option<u64> {
        let (mut work, mut path, mut encoders, mut needed) = (<C::Pools<u64>>::EMPTY, 0u64, 0, 0);
        let mut due = Instant::MAX;
        for slot in self.slots() {
            let task = self.jobs[slot].task.index();
            if self.tasks[task].overran {
                if !self.tasks[task].has_settled() {
                    return None;
                }
                self.find_blocked();
            }
            let version = self.version(slot);
            self.pool_numbers().for_each(|pool| work[pool] = work[pool].saturating_add(version.work[pool]));
            path = path.max(version.least(self.tasks[task].timing.deadline));
            encoders += version.encoders.len();
            needed |= version.pool_mask;
            due = due.min(self.jobs[slot].deadline);
        }
        for lane in (0..self.lanes()).filter(|lane| self.lanes[*lane].is_busy()) {
            let l = &self.lanes[lane];
            if l.merged || l.members == 0 {
                // Of a job that was given up, perhaps.
                let left = self.left_on(lane);
                work[usize::from(l.pool)] = work[usize::from(l.pool)].saturating_add(left);
                path = path.saturating_add(left);
            }
        }
        for lane in bits(self.promised.into()) {
            // A lane works for nobody as long as it waits.
            let after = self.promise_on(lane).map_or(0, |promised| promised.after);
            let waits = bits(after.into()).map(|before| self.left_on(before)).fold(0, u64::max);
            let pool = usize::from(self.lanes[lane].pool);
            work[pool] = work[pool].saturating_add(waits);
        }
        let mut all = 0u64;
        for pool in self.pool_numbers() {
            let lanes = self.pools[pool].lanes.count_ones();
            if lanes == 0 && needed >> pool & 1 != 0 {
                return None;
            }
            // Who waits for another's encoder waits for work that is counted, but perhaps not along a path.
            let lanes = if encoders > 1 { 1 } else { lanes.max(1) };
            all = all.saturating_add(work[pool].div_ceil(lanes.into()));
        }
        // On one lane the path is part of the work.
        let path = if encoders > 1 || self.lane_count == 1 { 0 } else { path };
        due.as_nanos().checked_sub(self.now.as_nanos())?.checked_sub(all.saturating_add(path))
    }
}

#[cfg(test)]
mod tests;
