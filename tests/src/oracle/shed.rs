//! The overload monitor and what gives jobs up.

use std::cmp::Reverse;

use super::dispatch::order;
use super::job::{Job, State};
use super::{FLOOR_MEMORY, OVERLOAD_TICKS, Policy, QUEUE_MAX, Reason, Sim, TICK_NS, UTILISATION_PPM};
use crate::graph::Role;

impl Sim<'_> {
    /// One tick of the monitor.
    pub(super) fn observe(&mut self, now: u64) {
        let pools = 0..self.workload.pools.len();
        let busy =
            pools.into_iter().any(|pool| self.queue(pool).len() > QUEUE_MAX || self.is_saturated(pool, now));
        let overloaded = match self.policy {
            Policy::Redrt | Policy::RedrtLookahead => {
                busy && self.jobs.iter().any(|job| is_lost_at_wcet(job, now))
            }
            _ => busy,
        };
        self.over = if overloaded { self.over + 1 } else { 0 };
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
        }
        if tick && self.over >= OVERLOAD_TICKS {
            match self.policy {
                Policy::Redrt | Policy::RedrtLookahead => self.drop_least_valuable(now),
                _ => self.drop_least_urgent(now),
            }
        }
        self.drop_unused();
    }

    /// Aborts each job that cannot end in time even at its best.
    fn abort_hopeless(&mut self, now: u64) {
        let hopeless: Vec<(usize, u64)> = self
            .jobs
            .iter()
            .filter(|job| i128::from(now) + self.best_path(job, now) > job.due)
            .map(|job| (job.task, job.index))
            .collect();
        for (task, index) in hopeless {
            self.give_up(task, index, now, Reason::Hopeless);
        }
    }

    /// The least that a job can still take. Every execution takes the WCET, so that is the best case. A waiting
    /// encoder whose key runs elsewhere ends when its predecessors and that unit have: behind its predecessors
    /// it may cost nothing, and alone it takes what is left of that unit.
    fn best_path(&self, job: &Job, now: u64) -> i128 {
        let elsewhere = |node: usize| {
            let waits =
                job.graph.nodes[node].role == Role::Encoder && matches!(job.state[node], State::Waiting);
            let key = job.frames[node].as_ref().filter(|key| waits && !self.is_cached(key))?;
            self.running_until(key).map(|finish| finish - now)
        };
        let left = |node: usize| {
            let sub = &job.graph.nodes[node];
            match (job.state[node], &job.frames[node]) {
                (State::Done, _) => 0,
                (State::Running(start), _) => sub.wcet_ns.saturating_sub(now - start),
                (State::Waiting, Some(key)) if sub.role == Role::Encoder && self.is_cached(key) => 0,
                (State::Waiting, _) if elsewhere(node).is_some() => 0,
                (State::Waiting, _) => sub.wcet_ns,
            }
        };
        let nodes = 0..job.state.len();
        let weights: Vec<u64> = nodes.clone().map(left).collect();
        let tails = job.remaining_tails(&weights);
        let alone = nodes.filter_map(|node| Some(i128::from(elsewhere(node)?) + i128::from(tails[node])));
        alone.fold(job.remaining_path(&weights), i128::max)
    }

    /// REDRT: while some job is lost at its WCET, drops not-started jobs: lowest value, then largest remaining
    /// work, then latest release.
    fn drop_least_valuable(&mut self, now: u64) {
        while self.jobs.iter().any(|job| is_lost_at_wcet(job, now)) {
            let work = |job: &Job| job.graph.costs().into_iter().sum::<u64>();
            let candidates = self.jobs.iter().filter(|job| !job.started && self.floor_allows(job));
            let rank = |job: &&Job| {
                let value = self.workload.tasks[job.task].value;
                (value, Reverse(work(job)), Reverse(job.release), Reverse(job.task))
            };
            let Some(victim) = candidates.min_by_key(rank) else { return };
            let (task, index) = (victim.task, victim.index);
            self.give_up(task, index, now, Reason::Overload);
        }
    }

    /// RED: drops the jobs of the queued sub-jobs of lowest urgency, at least one, until no queue is too long.
    fn drop_least_urgent(&mut self, now: u64) {
        self.reassign(now);
        loop {
            let candidates = self.jobs.iter().filter(|job| self.floor_allows(job));
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

    /// Whether the floor of the job's task lets this job be shed by choice: in every k consecutive jobs with
    /// it, at most k - m are. A job whose windows reach further back than sheds are remembered stays.
    fn floor_allows(&self, job: &Job) -> bool {
        let Some((m, k)) = self.workload.tasks[job.task].floor else { return true };
        let (m, k) = (u64::from(m), u64::from(k));
        let newest = self.outcome.newest_shed_by_choice(job.task).unwrap_or(0);
        if newest.saturating_sub(job.index) + k > FLOOR_MEMORY {
            return false;
        }
        let by_choice = |index: u64| index == job.index || self.outcome.was_shed_by_choice(job.task, index);
        let starts = (job.index + 1).saturating_sub(k)..=job.index;
        starts
            .into_iter()
            .all(|start| (start..start + k).filter(|&index| by_choice(index)).count() as u64 <= k - m)
    }

    fn give_up(&mut self, task: usize, index: u64, now: u64, reason: Reason) {
        let at = self.jobs.iter().position(|job| (job.task, job.index) == (task, index));
        let job = self.jobs.remove(at.expect("only jobs in flight are given up"));
        self.outcome.shed(&job, now, reason);
    }
}

/// Whether the longest remaining path at WCET ends beyond the deadline.
fn is_lost_at_wcet(job: &Job, now: u64) -> bool {
    let left = |node: usize| {
        let cost = job.graph.nodes[node].cost_ns;
        match job.state[node] {
            State::Done => 0,
            State::Running(start) => cost.saturating_sub(now - start),
            State::Waiting => cost,
        }
    };
    let weights: Vec<u64> = (0..job.state.len()).map(left).collect();
    i128::from(now) + job.remaining_path(&weights) > job.due
}

/// The paper's C in millionths: elapsed over relative sub-deadline, 1 at and beyond it.
fn urgency(job: &Job, node: usize, now: u64) -> i128 {
    let delta = job.keys[node] - i128::from(job.release);
    let elapsed = i128::from(now - job.release);
    if delta == 0 || elapsed >= delta { 1_000_000 } else { elapsed * 1_000_000 / delta }
}

#[cfg(test)]
mod tests;
