//! Lanes that are left idle for a node that is soon ready (rule 14).

use super::band::Place;
use super::job::{Job, State, SubId};
use super::{Policy, Sim, Unit, keys};

/// A node that takes a lane: key, when it is ready, cost, whether its job is above the head's.
type Soon = (i128, u64, u64, bool);

impl Sim<'_> {
    /// Until when the pool starts nothing, though its queue is not empty.
    pub(super) fn waits_until(&mut self, pool: usize, now: u64) -> Option<u64> {
        let looks = self.policy == Policy::RedrtLookahead;
        if !looks && !self.pressed[pool] || self.workload.pools[pool].memory_bytes.is_some() {
            return None;
        }
        let &(task, index, node) = self.queue(pool).first()?;
        let job = self.job(task, index)?;
        let head = (job.keys[node], now, job.graph.nodes[node].cost_ns, false);
        let end = now + head.2;
        let mut soon = if looks { self.behind_running(pool, job.band, now) } else { Vec::new() };
        soon.extend(self.next_jobs(pool, job, looks, now));
        soon.retain(|&(key, at, _, above)| {
            now < at && at < end && key < i128::from(end) && (above || looks && key < head.0)
        });
        soon.sort_unstable();
        soon.truncate(self.workload.pools[pool].lanes as usize);

        let mut before = self.free_from(pool, now);
        let mut behind = before.clone();
        take(&mut behind, head);
        let mut until = Vec::new();
        for node in soon {
            let is_late = take(&mut behind, node) > node.0;
            let in_time = take(&mut before, node) <= node.0;
            if is_late && in_time {
                until.push((node.1, node.3));
            }
        }
        let is_in_time = take(&mut before, head) <= head.0;
        if self.pressed[pool] && until.iter().any(|&(_, above)| above) {
            let longest = self.workload.tasks[task].deadline_ns.max(self.gap(task).unwrap_or(0));
            let end = i128::from(now) + 2 * i128::from(longest);
            self.pressure_until[pool] = self.pressure_until[pool].max(end);
        }
        until.into_iter().filter(|&(_, above)| above || is_in_time).map(|(at, _)| at).min()
    }

    /// Nodes of the pool whose predecessors that are not done all run, of jobs of a band or above.
    fn behind_running(&self, pool: usize, band: Place, now: u64) -> Vec<Soon> {
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
                found.extend(ends.max().map(|at| (job.keys[node], at, sub.cost_ns, false)));
            }
        }
        found
    }

    /// Sources of the next job of each task that has released one, but under pressure not those below the head's value.
    fn next_jobs(&self, pool: usize, head: &Job, looks: bool, now: u64) -> Vec<Soon> {
        let mut found = Vec::new();
        let (_, needed, own, due) = self.rank(head, &[], now);
        let least = (needed, if due { u32::MAX } else { own });
        for (task, model) in self.workload.tasks.iter().enumerate() {
            let Some((at, graph)) = self.expected_release(task) else { continue };
            let next = (self.floor_needs_job(task, self.next_index(task), &[]), model.value);
            let above = next > least && (self.pressed[pool] || looks && next.0);
            if self.pressed[pool] && !above && model.value < own {
                continue;
            }
            let keys = keys::at_release(self.policy, &graph, at, model.deadline_ns);
            let sources = graph.nodes.iter().zip(keys).filter(|(n, _)| n.pool == pool && n.preds.is_empty());
            found.extend(sources.map(|(node, key)| (key, at, node.cost_ns, above && key >= i128::from(at))));
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
fn take(free: &mut [u64], (_, at, cost, _): Soon) -> i128 {
    let Some(lane) = free.iter_mut().min() else { return i128::MAX };
    let start = at.max(*lane);
    *lane = start + cost;
    i128::from(start)
}
