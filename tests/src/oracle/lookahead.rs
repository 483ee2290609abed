//! Lanes that are left idle for a node that is soon ready (rule 14).

use super::band::Band;
use super::job::{Job, State, SubId};
use super::{Policy, Sim, Unit, keys};

/// A node that takes a lane: key, when it is ready, cost.
type Soon = (i128, u64, u64);

impl Sim<'_> {
    /// Until when the pool starts nothing, though its queue is not empty.
    pub(super) fn waits_until(&self, pool: usize, now: u64) -> Option<u64> {
        if self.policy != Policy::RedrtLookahead || self.workload.pools[pool].memory_bytes.is_some() {
            return None;
        }
        let &(task, index, node) = self.queue(pool).first()?;
        let job = self.job(task, index)?;
        let head = (job.keys[node], now, job.graph.nodes[node].cost_ns);
        let end = now + head.2;
        let mut soon = self.behind_running(pool, job.band, now);
        let least = if job.band == Band::Lowest { 0 } else { self.workload.tasks[task].value };
        soon.extend(self.next_jobs(pool, least));
        soon.retain(|&(key, at, _)| now < at && at < end && key < head.0 && key < i128::from(end));
        soon.sort_unstable();
        soon.truncate(self.workload.pools[pool].lanes as usize);

        let mut before = self.free_from(pool, now);
        let mut behind = before.clone();
        take(&mut behind, head);
        let mut until = None;
        for node in soon {
            let is_late = take(&mut behind, node) > node.0;
            let in_time = take(&mut before, node) <= node.0;
            if is_late && in_time {
                until = Some(until.map_or(node.1, |at: u64| at.min(node.1)));
            }
        }
        until.filter(|_| take(&mut before, head) <= head.0)
    }

    /// Nodes of the pool whose predecessors that are not done all run, of jobs of a band or above.
    fn behind_running(&self, pool: usize, band: Band, now: u64) -> Vec<Soon> {
        let mut found = Vec::new();
        for job in self.jobs.iter().filter(|job| job.band >= band) {
            for (node, sub) in job.graph.nodes.iter().enumerate() {
                let before: Vec<usize> =
                    sub.preds.iter().copied().filter(|&pred| job.state[pred] != State::Done).collect();
                let all_run = before.iter().all(|&pred| matches!(job.state[pred], State::Running(_)));
                if sub.pool != pool || job.state[node] != State::Waiting || before.is_empty() || !all_run {
                    continue;
                }
                let ends =
                    before.iter().filter_map(|&pred| self.end_at_cost((job.task, job.index, pred), now));
                found.extend(ends.max().map(|at| (job.keys[node], at, sub.cost_ns)));
            }
        }
        found
    }

    /// Sources of the next job of each task of at least this value that has released one.
    fn next_jobs(&self, pool: usize, value: u32) -> Vec<Soon> {
        let mut found = Vec::new();
        for (task, model) in self.workload.tasks.iter().enumerate().filter(|(_, model)| model.value >= value)
        {
            let Some((at, graph)) = self.expected_release(task) else { continue };
            let keys = keys::at_release(self.policy, &graph, at, model.deadline_ns);
            let sources = graph.nodes.iter().zip(keys).filter(|(n, _)| n.pool == pool && n.preds.is_empty());
            found.extend(sources.map(|(node, key)| (key, at, node.cost_ns)));
        }
        found
    }

    /// From when on each lane of the pool is free, but those of units that nobody needs.
    fn free_from(&self, pool: usize, now: u64) -> Vec<u64> {
        let of = |lane: u32| {
            let unit = self.running.iter().find(|unit| unit.pool == pool && unit.lane == lane);
            unit.map_or(Some(now), |unit| self.unit_end(unit, now))
        };
        (0..self.workload.pools[pool].lanes).filter_map(of).collect()
    }

    fn end_at_cost(&self, id: SubId, now: u64) -> Option<u64> {
        self.unit_end(self.running.iter().find(|unit| unit.members.contains(&id))?, now)
    }

    /// When the members that live have run their costs, at the earliest now.
    fn unit_end(&self, unit: &Unit, now: u64) -> Option<u64> {
        let end = |&(task, index, node): &SubId| {
            let job: &Job = self.job(task, index)?;
            let State::Running(start) = job.state[node] else { return None };
            Some(now.max(start + job.graph.nodes[node].cost_ns))
        };
        unit.members.iter().filter_map(end).max()
    }
}

/// The lane that is free first, from the node's start on.
fn take(free: &mut [u64], (_, at, cost): Soon) -> i128 {
    let Some(lane) = free.iter_mut().min() else { return i128::MAX };
    let start = at.max(*lane);
    *lane = start + cost;
    i128::from(start)
}
