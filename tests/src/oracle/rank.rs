//! What is left of a job, until when it can end, and who goes first (8.2, 8.6).

use std::cmp::Reverse;

use super::job::{Job, State};
use super::{FLOOR_MEMORY, PROBE_EVERY, RECENT_JOBS, Sim};
use crate::graph::Role;

/// A job: its task, and which of its jobs.
pub(super) type Name = (usize, u64);

/// In time; not spared by its floor; value; of a probe of a task that only loses, how many in a row.
pub(super) type Rank = (bool, bool, u32, u64);

/// The order in which jobs go, the least first: rank, started, work, how the task fared, release, task, job index.
pub(super) type Standing =
    (Rank, bool, Reverse<u128>, Reverse<u64>, Reverse<u64>, Reverse<usize>, Reverse<u64>);

impl Sim<'_> {
    /// What remains of each node. Every execution takes the WCET, so that this is estimate and best case.
    fn left(&self, job: &Job, now: u64) -> Vec<u64> {
        let left = |node: usize| {
            let sub = &job.graph.nodes[node];
            let encodes = job.frames[node].as_ref().filter(|_| sub.role == Role::Encoder);
            let is_there =
                encodes.is_some_and(|key| self.is_cached(key) || self.running_until(key).is_some());
            match job.state[node] {
                State::Done => 0,
                State::Running(start) => sub.wcet_ns.saturating_sub(now - start),
                State::Waiting if is_there => 0,
                State::Waiting => sub.wcet_ns,
            }
        };
        (0..job.state.len()).map(left).collect()
    }

    /// The earliest instant at which the job can end: its longest path, and its work, but for encoders, on all
    /// lanes of a pool.
    pub(super) fn bound(&self, job: &Job, now: u64) -> i128 {
        let left = self.left(job, now);
        let mut longest = job.remaining_path(&left);
        for (pool, model) in self.workload.pools.iter().enumerate() {
            let own = |node: usize| job.graph.nodes[node].role != Role::Encoder;
            let here = (0..left.len()).filter(|&node| job.graph.nodes[node].pool == pool && own(node));
            let work: u64 = here.map(|node| left[node]).sum();
            longest = longest.max(i128::from(work.div_ceil(u64::from(model.lanes))));
        }
        i128::from(now) + longest
    }

    /// The rank of a job in flight, or of one that is released now, where jobs of these names are lost, too.
    /// A probe is in time: what is certain and what is predicted are one bound here.
    pub(super) fn rank(&self, job: &Job, lost: &[Name], now: u64) -> Rank {
        let in_time = self.bound(job, now) <= job.due;
        let probe = in_time && self.is_probe(job.task, job.index);
        let value = self.workload.tasks[job.task].value;
        let in_row = self.lost_in_row(job.task, lost);
        let due = if probe && in_row > RECENT_JOBS { in_row } else { 0 };
        (in_time, self.floor_needs(job, lost), value, due)
    }

    /// Whether a job of a task is a probe, by its index: it and what the next job has to spare at its costs.
    pub(super) fn is_probe(&self, task: usize, index: u64) -> bool {
        let spare = self.slack(task, &self.tasks[task].graph);
        (i128::from(index) + spare).rem_euclid(i128::from(PROBE_EVERY)) == 0
    }

    /// The place of a job in the order of who goes first, where jobs of these names are lost, too.
    pub(super) fn standing(&self, job: &Job, lost: &[Name], now: u64) -> Standing {
        let work: u64 = self.left(job, now).iter().sum();
        let weight = u128::from(work) * u128::from(RECENT_JOBS + self.recently_kept(job.task, lost));
        let (release, task, index) = (Reverse(job.release), Reverse(job.task), Reverse(job.index));
        let fortune = Reverse(self.fortune(job.task, lost));
        (self.rank(job, lost, now), job.started, Reverse(weight), fortune, release, task, index)
    }

    /// How many of the last jobs of a task, up to the newest that ended, are not lost. Those before the first are not.
    fn recently_kept(&self, task: usize, lost: &[Name]) -> u64 {
        RECENT_JOBS - self.recently_lost(task, lost)
    }

    /// How a task fared: of its last jobs those not lost, then how far back the last that was not, in steps.
    pub(super) fn fortune(&self, task: usize, lost: &[Name]) -> u64 {
        8 * self.recently_kept(task, lost) + (FLOOR_MEMORY - self.lost_in_row(task, lost)) / 16
    }

    /// How many of these are.
    pub(super) fn recently_lost(&self, task: usize, lost: &[Name]) -> u64 {
        let Some(newest) = self.newest_ended(task, lost) else { return 0 };
        let last = (newest + 1).saturating_sub(RECENT_JOBS)..=newest;
        last.filter(|&index| self.is_lost(task, index, lost)).count() as u64
    }

    /// How many jobs of a task were lost in a row, of those that are remembered, up to the newest that ended.
    pub(super) fn lost_in_row(&self, task: usize, lost: &[Name]) -> u64 {
        let Some(newest) = self.newest_ended(task, lost) else { return 0 };
        let remembered = (newest + 1).saturating_sub(FLOOR_MEMORY)..=newest;
        remembered.rev().take_while(|&index| self.is_lost(task, index, lost)).count() as u64
    }

    /// Whether a job is lost, or counts as that.
    fn is_lost(&self, task: usize, index: u64, lost: &[Name]) -> bool {
        lost.contains(&(task, index)) || self.outcome.is_lost(task, index)
    }

    /// Index of the newest job of a task that ended, or is lost.
    fn newest_ended(&self, task: usize, lost: &[Name]) -> Option<u64> {
        let lost = lost.iter().filter(|(of, _)| *of == task).map(|&(_, index)| index);
        lost.chain(self.outcome.newest_ended(task)).max()
    }

    /// Those of these jobs that cannot be in time even without all others in flight, of tasks whose floor needs some.
    pub(super) fn lost_anyway(&self, late: &[usize], now: u64) -> Vec<Name> {
        let is_lost =
            |at: usize| self.forward(&[at], now).iter().any(|fate| fate.job == at && self.is_late(fate));
        let has_floor = |at: usize| self.has_floor(self.jobs[at].task);
        let lost = late.iter().copied().filter(|&at| has_floor(at) && is_lost(at));
        lost.map(|at| (self.jobs[at].task, self.jobs[at].index)).collect()
    }

    /// Whether the floor of a task needs any job.
    pub(super) fn has_floor(&self, task: usize) -> bool {
        self.workload.tasks[task].floor.is_some_and(|(m, _)| m > 0)
    }

    /// Whether the floor of the job's task cannot spare the job: some window of consecutive jobs with it would lose
    /// too many. Neither can it where the window reaches further back than jobs are remembered.
    pub(super) fn floor_needs(&self, job: &Job, lost: &[Name]) -> bool {
        self.floor_needs_job(job.task, job.index, lost)
    }

    /// The same of any job of a task.
    pub(super) fn floor_needs_job(&self, task: usize, index: u64, lost: &[Name]) -> bool {
        let Some((m, k)) = self.workload.tasks[task].floor else { return false };
        let (m, k) = (u64::from(m), u64::from(k));
        let (window, spare) = (k.min(FLOOR_MEMORY), (k - m) / k.div_ceil(FLOOR_MEMORY));
        let newest = self.newest_ended(task, lost).unwrap_or(0);
        if newest.saturating_sub(index) + window > FLOOR_MEMORY {
            return true;
        }
        let counts = |of: &u64| *of == index || self.is_lost(task, *of, lost);
        let mut starts = (index + 1).saturating_sub(window)..=index;
        starts.any(|start| (start..start + window).filter(counts).count() as u64 > spare)
    }
}

#[cfg(test)]
mod tests;
