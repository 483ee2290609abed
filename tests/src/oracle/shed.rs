//! The overload monitor of RED, and what gives jobs up (8.1, 8.3, 8.5).

use std::cmp::Reverse;

use super::dispatch::order;
use super::forward::Fate;
use super::job::Job;
use super::rank::Standing;
use super::{LEAVE_AT_MOST, OVERLOAD_TICKS, QUEUE_MAX, Reason, Sim, TICK_NS, UTILISATION_PPM};

impl Sim<'_> {
    /// One tick of the monitor.
    pub(super) fn observe(&mut self, now: u64) {
        let pools = 0..self.workload.pools.len();
        let busy =
            pools.into_iter().any(|pool| self.queue(pool).len() > QUEUE_MAX || self.is_saturated(pool, now));
        self.over = if busy { self.over + 1 } else { 0 };
        self.executions.retain(|&(_, _, finish)| finish > now);
    }

    /// Whether the lanes were busy for more than the threshold during the last tick.
    fn is_saturated(&self, pool: usize, now: u64) -> bool {
        let window = now.saturating_sub(TICK_NS);
        let here = self.executions.iter().filter(|execution| execution.0 == pool);
        let busy: u64 =
            here.map(|&(_, start, finish)| finish.min(now).saturating_sub(start.max(window))).sum();
        let lanes = u128::from(self.workload.pools[pool].lanes);
        u128::from(busy) * 1_000_000 > UTILISATION_PPM * lanes * u128::from(TICK_NS)
    }

    /// Gives up jobs, by the policy's rule.
    pub(super) fn shed(&mut self, now: u64, tick: bool) {
        if self.policy.is_ours() {
            self.abort_hopeless(now);
            if std::mem::take(&mut self.look_due) {
                self.look(now);
            }
        }
        if tick && self.over >= OVERLOAD_TICKS {
            self.drop_least_urgent(now);
        }
        self.drop_unused();
    }

    /// Aborts each job that cannot end in time even at its best (8.3).
    fn abort_hopeless(&mut self, now: u64) {
        let hopeless = self.jobs.iter().filter(|job| self.bound(job, now) > job.due);
        for (task, index) in hopeless.map(|job| (job.task, job.index)).collect::<Vec<_>>() {
            self.give_up(task, index, now, Reason::Hopeless);
        }
    }

    /// Gives up those who make others late, and looks again as long as so many of them are found at once (8.5).
    fn look(&mut self, now: u64) {
        loop {
            let (outside, cut_short) = self.predict(now);
            for &(task, index) in &outside {
                self.give_up(task, index, now, Reason::Overload);
            }
            if !cut_short || outside.is_empty() {
                return;
            }
        }
    }

    /// The jobs that have to go, and whether as many left as one look lets go.
    fn predict(&self, now: u64) -> (Vec<(usize, u64)>, bool) {
        let standing: Vec<Standing> = self.jobs.iter().map(|job| self.standing(job, now)).collect();
        let mut group: Vec<usize> = (0..self.jobs.len()).collect();
        let mut kept: Vec<usize> = Vec::new();
        let mut left: Vec<usize> = Vec::new();
        while left.len() < LEAVE_AT_MOST {
            let fates = self.forward(&group, now);
            let Some(x) = self.first_late(&fates, &kept) else { break };
            let starts_before = |j: &&Fate| j.first_start.is_some_and(|start| start < x.end) && j.meets(x);
            let in_the_way = fates.iter().filter(|j| j.job == x.job || starts_before(j));
            let least = in_the_way.map(|j| j.job).min_by_key(|&job| standing[job]).expect("x is among them");
            if least != x.job || self.harms(x, &fates, &kept, now) {
                group.retain(|&job| job != least);
                left.push(least);
            } else {
                kept.push(x.job);
            }
        }
        let cut_short = left.len() == LEAVE_AT_MOST;
        if left.len() >= 2 {
            left.sort_by_key(|&job| Reverse(standing[job]));
            left.retain(|&job| {
                group.push(job);
                let stays_out = self.first_late(&self.forward(&group, now), &kept).is_some();
                if stays_out {
                    group.pop();
                }
                stays_out
            });
        }
        (left.into_iter().map(|job| (self.jobs[job].task, self.jobs[job].index)).collect(), cut_short)
    }

    /// Of the late jobs that are not kept all the same, the one that ends first.
    fn first_late<'a>(&self, fates: &'a [Fate], kept: &[usize]) -> Option<&'a Fate> {
        let late = fates.iter().filter(|fate| self.is_late(fate) && !kept.contains(&fate.job));
        late.min_by_key(|fate| {
            let job = &self.jobs[fate.job];
            (fate.end, job.release, job.task, job.index)
        })
    }

    fn is_late(&self, fate: &Fate) -> bool {
        fate.end > self.jobs[fate.job].due
    }

    /// Whether another job that could be in time is late where `x` takes lanes.
    fn harms(&self, x: &Fate, fates: &[Fate], kept: &[usize], now: u64) -> bool {
        let in_time = |y: &Fate| self.bound(&self.jobs[y.job], now) <= self.jobs[y.job].due;
        fates
            .iter()
            .any(|y| y.job != x.job && !kept.contains(&y.job) && self.is_late(y) && in_time(y) && y.meets(x))
    }

    /// RED: drops the jobs of the queued sub-jobs of lowest urgency, at least one, until no queue is too long.
    fn drop_least_urgent(&mut self, now: u64) {
        self.reassign(now);
        loop {
            let candidates = self.jobs.iter().filter(|job| !self.floor_needs(job));
            let queued = candidates.flat_map(|job| {
                let ready = (0..job.state.len()).filter(|&node| job.is_ready(node, false));
                ready.map(move |node| (urgency(job, node, now), Reverse(order(job, node))))
            });
            let Some((_, Reverse((_, _, task, index, _)))) = queued.min() else { break };
            self.give_up(task, index, now, Reason::Urgency);
            if (0..self.workload.pools.len()).all(|pool| self.queue(pool).len() <= QUEUE_MAX) {
                break;
            }
        }
        self.over = 0;
    }

    /// Ends a job that is in flight. What runs for it runs on.
    pub(super) fn give_up(&mut self, task: usize, index: u64, now: u64, reason: Reason) {
        let at = self.jobs.iter().position(|job| (job.task, job.index) == (task, index));
        let job = self.jobs.remove(at.expect("only jobs in flight are given up"));
        self.outcome.shed(&job, now, reason);
    }
}

/// The paper's C in millionths: elapsed over relative sub-deadline, 1 at and beyond it.
fn urgency(job: &Job, node: usize, now: u64) -> i128 {
    let delta = job.keys[node] - i128::from(job.release);
    let elapsed = i128::from(now - job.release);
    if delta == 0 || elapsed >= delta { 1_000_000 } else { elapsed * 1_000_000 / delta }
}

#[cfg(test)]
mod tests;
