//! Lanes that are left idle for a node that is soon ready (rule 14).

use super::band::Place;
use super::job::{Job, State, SubId};
use super::{PROBE_EVERY, Policy, RECENT_JOBS, Sim, Unit, keys};
use crate::graph::Graph;

/// A node that takes a lane: key, when it is ready, cost, whether its job is above the head's.
type Soon = (i128, u64, u64, bool);

/// Why a node does not start.
struct Wait {
    until: u64,
    /// Whether it is for a higher rank.
    for_rank: bool,
}

impl Sim<'_> {
    /// The node that a pool starts, of those in its queue: the head, or the first that need not wait where that one waits for a
    /// higher rank. Until when the pool waits, if it does.
    pub(super) fn first_to_start(&mut self, pool: usize, now: u64) -> (Option<SubId>, Option<u64>) {
        let queue = self.queue(pool);
        let Some(&head) = queue.first() else { return (None, None) };
        let Some(wait) = self.waits(pool, head, now) else { return (Some(head), None) };
        // Of each job only its first that need not wait.
        let goes = queue.into_iter().find(|&id| self.waits(pool, id, now).is_none());
        (goes.filter(|_| wait.for_rank), Some(wait.until))
    }

    /// What a node waits for.
    fn waits(&self, pool: usize, (task, index, node): SubId, now: u64) -> Option<Wait> {
        let looks = self.policy == Policy::RedrtLookahead;
        let waits = looks || self.policy == Policy::Redrt;
        if !waits || self.workload.pools[pool].memory_bytes.is_some() {
            return None;
        }
        let job = self.job(task, index)?;
        let head = (job.keys[node], now, job.graph.nodes[node].cost_ns, false);
        let end = now + head.2;
        let mut soon = if looks { self.behind_running(pool, job.band, now) } else { Vec::new() };
        soon.extend(self.next_jobs(pool, (job, head.2), looks, now));
        soon.retain(|&(key, at, _, above)| {
            now < at && at < end && key < i128::from(end) && (above || key < head.0)
        });
        soon.sort_unstable();

        let mut before = self.free_from(pool, now, Some(self.least_above(job, now)).filter(|_| !looks));
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
        let for_rank = until.iter().any(|&(_, above)| above);
        let until = until.into_iter().filter(|&(_, above)| above || is_in_time).map(|(at, _)| at).min()?;
        Some(Wait { until, for_rank })
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

    /// Nodes of the next job of each task that has released one: for a higher rank the lanes that it needs, else sources.
    fn next_jobs(&self, pool: usize, (head, cost_ns): (&Job, u64), looks: bool, now: u64) -> Vec<Soon> {
        let mut found = Vec::new();
        let (least, own) = (self.least_above(head, now), self.workload.tasks[head.task].value);
        for (task, model) in self.workload.tasks.iter().enumerate() {
            let Some((at, graph)) = self.expected_release(task) else { continue };
            let next = (self.floor_needs_job(task, self.next_index(task), &[]), model.value);
            let may_be_late = self.spare_at_least(task, &graph) < i128::from(cost_ns);
            let above = next > least && may_be_late && self.can_gain(task, &graph);
            if !above && (!looks || self.pressed[pool] && model.value < own) {
                continue;
            }
            if above {
                let lanes = self.workload.pools[pool].lanes as usize;
                let (held, end) = self.spread(&graph, model.deadline_ns, pool, lanes);
                let spare = i128::from(model.deadline_ns.saturating_sub(end)).min(self.slack(task, &graph));
                let held = held.into_iter().filter(|&(_, until)| until > 0);
                found.extend(
                    held.map(|(from, until)| (i128::from(at + from) + spare, at + from, until - from, true)),
                );
                continue;
            }
            let keys = keys::at_release(self.policy, &graph, at, model.deadline_ns);
            for (node, &key) in graph.nodes.iter().zip(&keys) {
                if node.pool == pool && node.preds.is_empty() {
                    found.push((key, at, node.cost_ns, false));
                }
            }
        }
        found
    }

    /// From when to when a job that is released at 0 holds each lane of a pool, and when it ends: on as few lanes as end it in time, or
    /// on all. Of the nodes that are ready the first by key takes the first lane that is free, of several the one that was busy last; in
    /// other pools a node starts when it is ready.
    fn spread(&self, graph: &Graph, due: u64, pool: usize, lanes: usize) -> (Vec<(u64, u64)>, u64) {
        let keys = keys::at_release(self.policy, graph, 0, due);
        let on = |count: usize| {
            let (mut ends, mut held) = (vec![None; graph.nodes.len()], vec![(0, 0); count]);
            let earliest = |node: usize, ends: &[Option<u64>], held: &[(u64, u64)]| {
                let before: Option<Vec<u64>> =
                    graph.nodes[node].preds.iter().map(|&pred| ends[pred]).collect();
                let ready = before?.into_iter().max().unwrap_or(0);
                let free =
                    held.iter().map(|&(_, until)| until).min().filter(|_| graph.nodes[node].pool == pool);
                Some(ready.max(free.unwrap_or(0)))
            };
            loop {
                let open = (0..graph.nodes.len()).filter(|&node| ends[node].is_none());
                let starts = open.filter_map(|node| Some((earliest(node, &ends, &held)?, keys[node], node)));
                let Some((start, _, node)) = starts.min() else { break };
                let end = start + graph.nodes[node].cost_ns;
                ends[node] = Some(end);
                if graph.nodes[node].pool == pool {
                    let free = (0..count).filter(|&lane| held[lane].1 <= start);
                    let lane = free.max_by_key(|&lane| held[lane].1).expect("one is free");
                    held[lane] = (if held[lane].1 == 0 { start } else { held[lane].0 }, end);
                }
            }
            (held, ends.into_iter().flatten().max().unwrap_or(0))
        };
        (1..lanes).map(on).find(|&(_, end)| end <= due).unwrap_or_else(|| on(lanes))
    }

    /// What the next job of a task has to spare at least, on as few lanes of each pool as its work there fits on within its deadline, by
    /// the lengths alone: by its longest path less the part of it that lanes share, and by its work over these lanes.
    fn spare_at_least(&self, task: usize, graph: &Graph) -> i128 {
        let (path, due) = (graph.longest_path(&graph.costs()), self.workload.tasks[task].deadline_ns);
        let pools = self.workload.pools.iter().enumerate().map(|(number, pool)| {
            let work = graph.work(number);
            let few = (1..u64::from(pool.lanes)).find(|few| work <= few * due).unwrap_or(pool.lanes.into());
            (few, work.div_ceil(few))
        });
        let (widest, shared) =
            pools.fold((1, 0), |(widest, sum), (few, share)| (few.max(widest), sum + share));
        i128::from(due) - i128::from(path - path / widest + shared)
    }

    /// What the next job of a task has to spare.
    pub(super) fn slack(&self, task: usize, graph: &Graph) -> i128 {
        i128::from(self.workload.tasks[task].deadline_ns) - self.least_time(graph)
    }

    /// Whether the next job of a task could be in time alone, by its costs and by how its last ones fared.
    pub(super) fn can_gain(&self, task: usize, graph: &Graph) -> bool {
        let lost_all = self.recently_lost(task, &[]) == RECENT_JOBS;
        self.slack(task, graph) >= 0 && (!lost_all || self.next_index(task).is_multiple_of(PROBE_EVERY))
    }

    /// The least time of a job at its costs: its longest path, and its work in each pool over the lanes.
    fn least_time(&self, graph: &Graph) -> i128 {
        let shares = (0..self.workload.pools.len()).map(|pool| self.share(graph, pool));
        i128::from(shares.fold(graph.longest_path(&graph.costs()), u64::max))
    }

    /// The work of a graph in a pool, over its lanes.
    fn share(&self, graph: &Graph, pool: usize) -> u64 {
        graph.work(pool).div_ceil(self.workload.pools[pool].lanes.into())
    }

    /// What others have to be above to be waited for: whether their floor cannot spare them, their value.
    fn least_above(&self, job: &Job, now: u64) -> (bool, u32) {
        let (_, needed, value, due) = self.rank(job, &[], now);
        (needed, if due > 0 { u32::MAX } else { value })
    }

    /// From when on each lane of the pool is free, but those of units that nobody needs: with what follows behind a unit of a job
    /// above, in its longest path, if all of its nodes are of this pool.
    fn free_from(&self, pool: usize, now: u64, least: Option<(bool, u32)>) -> Vec<u64> {
        let behind = |&(task, index, node): &SubId| {
            let job = self.job(task, index)?;
            let goes_on = job.graph.nodes.iter().all(|node| node.pool == pool)
                && least.is_some_and(|least| self.least_above(job, now) > least);
            let path = job.due - job.keys[node] - i128::from(job.graph.nodes[node].cost_ns);
            goes_on.then_some(path as u64)
        };
        let end = |unit: &Unit| {
            let behind = unit.members.iter().filter_map(behind).max().unwrap_or(0);
            self.unit_end(unit, now).map(|end| end + behind)
        };
        let of = |lane: u32| {
            let unit = self.running.iter().find(|unit| unit.pool == pool && unit.lane == lane);
            unit.map_or(Some(now), end)
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
