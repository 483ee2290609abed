//! Who goes first when somebody has to.
//!
//! *Rule.* By rank: who can end in time by estimates before who cannot; who is owed by a floor; the value; whose turn
//! it is. Among equals a job that has not started goes before one that has, then more remaining work before less,
//! weighed by how its task fared of late, then by that alone, then the newest.
//! *Why nobody starves.* Each 17th job of a task is a probe, of each task another one: it ranks as if it could end in time, so that an
//! estimate that is wrong gets another sample. If more than the last 16 were lost it is due: its nodes count as their best case, and it goes
//! before its equals, of several such the one that lost the most in a row, and before who is above them as long as something is left to learn of its times. If its nodes take too long, what was seen of them is no proof then, and its probe goes only for who is above it.

use super::{Scheduler, jobs::Job, outlook::Case, tasks::Task};
use crate::capacity::Capacity;
use crate::config::Shed;
use crate::id::TaskId;
use crate::policy::floor::{Floor, MEMORY, RECENT};
use crate::time::Instant;
use core::cmp::Reverse;

/// One job in so many is a probe: a prime, or probes would meet the same jobs of others each time.
const PROBE: i64 = 17;

impl<C: Capacity> Task<C> {
    /// Whether its job of an index is one of each so many. What tasks have to spare has those of one period take theirs at different
    /// times, whatever their order, or one that never fits would always take the place of another's.
    fn is_nth(&self, index: u64, of: i64) -> bool {
        index.cast_signed().wrapping_add(self.newest().slack) % of == 0
    }

    /// Whether a job of it may be a probe.
    pub(super) fn is_probe(&self, index: u64) -> bool {
        self.is_nth(index, PROBE)
    }
}

crate::capacity::values! {
    /// What a job is worth beside others, the least first.
    #[derive(PartialOrd, Ord)]
    pub(super) struct Rank {
        /// Whether it can end in time by estimates, or is a probe.
        pub(super) has_chance: bool,
        /// Whether its floor cannot spare it.
        is_owed: bool,
        pub(super) value: u32,
        /// Of a probe of a task that lost all of late: how many in a row, as far as it is remembered.
        pub(super) due: u32,
    }
}

/// The whole order: of equal ranks the least goes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Standing {
    pub(super) rank: Rank,
    started: bool,
    last: Reverse<(u64, u8, Instant, usize, u64)>,
}

impl<C: Capacity> Scheduler<C> {
    /// Where a job stands, if the jobs of its task fared as `floor` remembers. Time bound: O(nodes + edges).
    pub(super) fn standing(&self, slot: usize, floor: &Floor) -> Standing {
        let job = &self.jobs[slot];
        let kept = RECENT - floor.recently_lost();
        let weight = self.remaining_work(job, slot).saturating_mul(u64::from(RECENT + kept));
        let last = Reverse((weight, floor.fortune(), job.release, job.task.index(), job.index));
        Standing { rank: self.rank(job, slot, floor), started: job.started, last }
    }

    /// The rank of a job, which need not be in a slot yet.
    pub(super) fn rank(&self, job: &Job<C>, slot: usize, floor: &Floor) -> Rank {
        let in_time = |case| self.can_end_in_time(job, slot, case);
        let task = &self.tasks[job.task.index()];
        let is_probe = task.is_probe(job.index) && in_time(Case::Best);
        Rank {
            has_chance: is_probe || in_time(Case::Expected),
            is_owed: !floor.spares(job.index),
            value: task.timing.value,
            due: if is_probe && floor.lost_in_row() > RECENT { floor.lost_in_row() } else { 0 },
        }
    }

    /// What another job, in flight or to come, has to be above for this one to wait for it: any hope, owed, value. A probe that is due, of a task of whose times something is left to
    /// learn, gets its lane, but not before whom a floor cannot spare; a job that will be late, of a task that lost all of late as its nodes take too long, waits for everybody.
    pub(super) fn beside_next(&self, slot: usize, floor: &Floor) -> (bool, bool, u32) {
        let job = &self.jobs[slot];
        let Rank { has_chance, is_owed, value, due } = self.rank(job, slot, floor);
        let task = &self.tasks[job.task.index()];
        let is_hopeless = floor.recently_lost() == RECENT && task.is_slow();
        let learns = due > 0 && !is_owed && !task.is_known();
        (has_chance || !is_hopeless, is_owed, if learns { u32::MAX } else { value })
    }

    /// Whether a job in flight is of another task than one that counts as `own`, and above it.
    pub(super) fn is_waited_for(
        &self,
        slot: usize,
        floor: &Floor,
        task: TaskId,
        own: (bool, bool, u32),
    ) -> bool {
        let job = &self.jobs[slot];
        let (has_hope, is_owed, _) = self.beside_next(slot, floor);
        job.task != task && (has_hope, is_owed, self.tasks[job.task.index()].timing.value) > own
    }

    /// Whether a job is a probe of a task that lost more than its last 16, if it can end in time.
    pub(super) fn is_due(&self, job: &Job<C>) -> bool {
        self.tasks[job.task.index()].is_probe(job.index) && self.floor_of(job).lost_in_row() > RECENT
    }

    /// Whether what was seen of a job proves nothing: such a one of a slow task.
    pub(super) fn is_doubted(&self, job: &Job<C>) -> bool {
        self.is_due(job) && self.tasks[job.task.index()].is_slow()
    }

    /// Whether a job may take what it is declared to take, whatever was seen: now and then, of a task that lost all that is remembered, or
    /// one slow run would keep it waiting for ever for who is owed every job.
    pub(super) fn is_forgiven(&self, job: &Job<C>) -> bool {
        self.tasks[job.task.index()].is_nth(job.index, 8 * PROBE)
            && self.floor_of(job).lost_in_row() == MEMORY
    }

    /// Whether a job could end in time if the lanes were its own, at best case or by estimates. Time bound: O(nodes + edges),
    /// and O(1) where all of it still fits at WCET, which is enough where no WCET was exceeded of late.
    pub(super) fn can_end_in_time(&self, job: &Job<C>, slot: usize, case: Case) -> bool {
        let task = &self.tasks[job.task.index()];
        let spare = u64::try_from(task.version_of(job).slack);
        if !task.overran && spare.is_ok_and(|spare| self.now.since(job.release).as_nanos() <= spare) {
            return true;
        }
        let left = job.deadline.as_nanos().checked_sub(self.now.as_nanos());
        left.is_some_and(|left| self.bound(job, slot, case) <= left)
    }

    /// Whether a job to come of a task could be in time alone, by its WCET and by how its last ones fared.
    pub(super) fn can_gain(&self, task: &Task<C>, index: u64) -> bool {
        let version = task.newest();
        let may_win = task.timing.floor.recently_lost() < RECENT || task.is_probe(index);
        version.slack >= 0 && version.pool_mask & self.lost == 0 && may_win
    }

    /// How a task fared of late: of two equal keys the one with less goes first.
    pub(super) fn fortune_of(&self, t: usize) -> u8 {
        if self.config.shed == Shed::Hopeless { self.tasks[t].timing.floor.fortune() } else { 0 }
    }

    pub(super) fn floor_of(&self, job: &Job<C>) -> &Floor {
        &self.tasks[job.task.index()].timing.floor
    }

    /// Whose place a new job takes where there is none left: that of the least, if it ranks below, of equal ones of the task that has the
    /// most jobs in flight; else the newest of that, where it is an equal and has two more, so that equals share the table.
    /// Time bound: O(jobs * (jobs + nodes + edges)).
    pub(super) fn gives_way_to(&self, new: &Job<C>) -> Option<usize> {
        let own = self.rank(new, C::JOBS, self.floor_of(new));
        let rank = |slot: usize| self.rank(&self.jobs[slot], slot, self.floor_of(&self.jobs[slot]));
        let least = self.slots().map(rank).min()?;
        let jobs_of = |task| self.slots().filter(|slot| self.jobs[*slot].task == task).count();
        if least < own {
            let standing = |slot: usize| self.standing(slot, self.floor_of(&self.jobs[slot]));
            let order = |slot: &usize| (Reverse(jobs_of(self.jobs[*slot].task)), standing(*slot));
            return self.slots().filter(|slot| rank(*slot) == least).min_by_key(order);
        }
        let enough = jobs_of(new.task) + 2;
        let is_equal = |(share, slot): &(usize, usize)| {
            *share >= enough && !self.jobs[*slot].started && rank(*slot) == own
        };
        let order =
            |(share, slot): &(usize, usize)| (*share, self.jobs[*slot].index, self.jobs[*slot].task.index());
        let shares = self.slots().map(|slot| (jobs_of(self.jobs[slot].task), slot));
        Some(shares.filter(is_equal).max_by_key(order)?.1)
    }
}
