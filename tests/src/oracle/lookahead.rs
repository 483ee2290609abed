//! Lanes that are left idle for a node that is soon ready (rule 14).

use super::alone::{Alone, Stage};
use super::job::{Job, State, SubId};
use super::{JOBS_IN_FLIGHT, Policy, RECENT_JOBS, Sim, Unit, keys};
use crate::graph::Graph;
use std::ops::Range;

/// Jobs of a task that have not been released and are waited for.
const JOBS_TO_COME: u64 = 16;

/// A node that takes a lane: key, when it is ready, cost, whether its job is above the head's, bytes that this needs.
type Soon = (i128, u64, u64, bool, u64);

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
        let goes = queue.into_iter().find(|&id| !self.has_to_wait(pool, id, now));
        (goes.filter(|_| wait.for_rank), Some(wait.until))
    }

    pub(super) fn has_to_wait(&self, pool: usize, id: SubId, now: u64) -> bool {
        self.waits(pool, id, now).is_some()
    }

    /// What a node waits for.
    fn waits(&self, pool: usize, (task, index, node): SubId, now: u64) -> Option<Wait> {
        let budget = self.workload.pools[pool].memory_bytes;
        let looks = self.policy == Policy::RedrtLookahead && budget.is_none();
        if !matches!(self.policy, Policy::RedrtLookahead | Policy::Redrt) {
            return None;
        }
        let job = self.job(task, index)?;
        let (cost, memory) = (job.graph.nodes[node].cost_ns, job.graph.nodes[node].memory_bytes);
        let head = (job.keys[node], now, cost, false, memory);
        let end = now + cost;
        let mut soon = Vec::new();
        for other in &self.jobs {
            match self.in_flight_above(pool, other, (job, cost), now) {
                Some(needs) => soon.extend(needs),
                None if looks && other.band >= job.band => soon.extend(self.behind_running(pool, other, now)),
                None => {}
            }
        }
        soon.extend(self.next_jobs(pool, (job, cost), looks, now, 0..1));
        let counts = |&(key, at, _, above, _): &Soon| {
            let is_soon = now < at || budget.is_some() && above;
            is_soon && at < end && key < i128::from(end) && (above || key < head.0)
        };
        soon.retain(counts);
        soon.sort_unstable();
        soon.truncate(JOBS_IN_FLIGHT);
        let later = self.next_jobs(pool, (job, cost), false, now, 1..JOBS_TO_COME);
        let places = JOBS_IN_FLIGHT - soon.len();
        soon.extend(later.into_iter().filter(counts).take(places));
        soon.sort_unstable();

        let mut before = self.free_from(pool, now);
        let mut behind = before.clone();
        take(&mut behind, head);
        let mut until = Vec::new();
        for node in soon {
            let (key, at, _, above, memory) = node;
            let is_crowded =
                budget.is_some_and(|budget| self.held_at(pool, key, now) + head.4 + memory > budget);
            if at <= now {
                until.extend(is_crowded.then_some((u64::MAX - 1, above)));
                continue;
            }
            let is_late = take(&mut behind, node) > key || is_crowded;
            let in_time = take(&mut before, node) <= key;
            if is_late && in_time {
                until.push((at, above));
            }
        }
        let is_in_time = take(&mut before, head) <= head.0;
        let for_rank = until.iter().any(|&(_, above)| above);
        let until = until.into_iter().filter(|&(_, above)| above || is_in_time).map(|(at, _)| at).min()?;
        Some(Wait { until, for_rank })
    }

    /// What a job in flight needs from now on, if it is above and may be late because of the head.
    fn in_flight_above(
        &self,
        pool: usize,
        job: &Job,
        (head, cost_ns): (&Job, u64),
        now: u64,
    ) -> Option<Vec<Soon>> {
        let is_limited = self.workload.pools[pool].memory_bytes.is_some();
        let is_to_come = |node: usize| {
            let is_ready = job.is_ready(node, false) && !self.waits_for_key(job, node);
            let is_here = job.graph.nodes[node].pool == pool && job.state[node] == State::Waiting;
            is_here && (is_limited || !is_ready)
        };
        let next = self.expected_release(job.task);
        let may_be_late =
            next.is_some_and(|(_, graph)| self.spare_at_least(job.task, &graph) < i128::from(cost_ns));
        let is_above =
            (self.least_above(job, now).0, self.workload.tasks[job.task].value) > self.least_above(head, now);
        if !(0..job.state.len()).any(is_to_come) || !is_limited && !may_be_late || !is_above {
            return None;
        }
        let stage = |node: usize| match job.state[node] {
            State::Done => Stage::Done,
            State::Running(start) => {
                Stage::Running((start + job.graph.nodes[node].cost_ns).saturating_sub(now))
            }
            _ => Stage::ToCome,
        };
        let stages: Vec<Stage> = (0..job.state.len()).map(stage).collect();
        let due = u64::try_from(job.due - i128::from(now)).unwrap_or(0);
        let deadline = self.workload.tasks[job.task].deadline_ns;
        let (held, end, memory) = self.spread(&job.graph, (deadline, due), pool, &stages);
        let spare = i128::from(due.saturating_sub(end));
        let need = |(from, until)| (i128::from(now + from) + spare, now + from, until - from, true, memory);
        Some(held.into_iter().map(need).collect())
    }

    /// Nodes of the pool, of a job, whose predecessors that are not done all run.
    fn behind_running(&self, pool: usize, job: &Job, now: u64) -> Vec<Soon> {
        let mut found = Vec::new();
        for (node, sub) in job.graph.nodes.iter().enumerate() {
            let before: Vec<usize> =
                sub.preds.iter().copied().filter(|&pred| job.state[pred] != State::Done).collect();
            let all_run = before.iter().all(|&pred| matches!(job.state[pred], State::Running(_)));
            if sub.pool != pool || job.state[node] != State::Waiting || before.is_empty() || !all_run {
                continue;
            }
            let ends = before.iter().filter_map(|&pred| self.end_at_cost((job.task, job.index, pred), now));
            found.extend(ends.max().map(|at| (job.keys[node], at, sub.cost_ns, false, 0)));
        }
        found
    }

    /// Nodes of the jobs of this turn of each task that has released one: for a higher rank the lanes that it needs, else sources of the next.
    fn next_jobs(
        &self,
        pool: usize,
        (head, cost_ns): (&Job, u64),
        looks: bool,
        now: u64,
        turn: Range<u64>,
    ) -> Vec<Soon> {
        let mut found = Vec::new();
        let is_limited = self.workload.pools[pool].memory_bytes.is_some();
        let (least, own) = (self.least_above(head, now), self.workload.tasks[head.task].value);
        for (task, model) in self.workload.tasks.iter().enumerate() {
            let Some((at, graph)) = self.expected_release(task) else { continue };
            let may_be_late = is_limited || self.spare_at_least(task, &graph) < i128::from(cost_ns);
            let above = |nth: u64| {
                let index = self.next_index(task) + nth;
                let rank = (self.floor_needs_job(task, index, &[]), model.value);
                rank > least && may_be_late && self.can_gain(task, index, &graph)
            };
            let period = self.gap(task).unwrap_or_default();
            let come = turn.clone().filter(|&nth| at + nth * period < now + cost_ns && above(nth));
            let come: Vec<u64> = come.map(|nth| at + nth * period).collect();
            if !come.is_empty() {
                let due = model.deadline_ns;
                let stages = vec![Stage::ToCome; graph.nodes.len()];
                let (held, end, memory) = self.spread(&graph, (due, due), pool, &stages);
                let spare = i128::from(due.saturating_sub(end)).min(self.slack(task, &graph));
                for at in come {
                    found.extend(held.iter().map(|&(from, until)| {
                        (i128::from(at + from) + spare, at + from, until - from, true, memory)
                    }));
                }
            }
            if above(0) || !looks || self.pressed[pool] && model.value < own {
                continue;
            }
            let keys = keys::at_release(self.policy, &graph, at, model.deadline_ns);
            for (node, &key) in graph.nodes.iter().zip(&keys) {
                if node.pool == pool && node.preds.is_empty() {
                    found.push((key, at, node.cost_ns, false, 0));
                }
            }
        }
        found
    }

    /// From when to when a job holds each lane of a pool, from now on, behind what it runs there; when it ends; and the most bytes that
    /// it has there at once, but for what runs: on as few lanes as end it in time, or on all. Of the nodes that are ready the first by key
    /// takes the first lane of its pool that is free once there is memory, of several the one that was busy last; results of encoders are
    /// kept; memory of other pools is not looked at.
    fn spread(
        &self,
        graph: &Graph,
        (deadline, due): (u64, u64),
        pool: usize,
        stages: &[Stage],
    ) -> (Vec<(u64, u64)>, u64, u64) {
        let here = |node: usize| graph.nodes[node].pool == pool;
        let running =
            (0..stages.len()).filter(|&node| here(node) && matches!(stages[node], Stage::Running(_)));
        let left = |node: usize| stages[node].left(graph.nodes[node].cost_ns);
        let work: u64 = (0..stages.len()).filter(|&node| here(node)).map(left).sum();
        let least = (running.count() as u64).max(work.div_ceil(due.max(1))).max(1) as usize;
        let all: Vec<usize> = self.workload.pools.iter().map(|pool| pool.lanes as usize).collect();
        let budget = self.workload.pools[pool].memory_bytes;
        let on = |count: usize| {
            let mut lanes = all.clone();
            lanes[pool] = count;
            Alone::new(self.policy, graph, deadline, pool, stages, &lanes, budget)
        };
        let alone =
            (least..all[pool]).map(on).find(|alone| alone.end() <= due).unwrap_or_else(|| on(all[pool]));
        (alone.held(), alone.end(), budget.map_or(0, |budget| alone.most.min(budget)))
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

    /// Whether a job to come of a task could be in time alone, by its costs and by how its last ones fared.
    pub(super) fn can_gain(&self, task: usize, index: u64, graph: &Graph) -> bool {
        let lost_all = self.recently_lost(task, &[]) == RECENT_JOBS;
        self.slack(task, graph) >= 0 && (!lost_all || self.is_probe(task, index))
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
    pub(super) fn least_above(&self, job: &Job, now: u64) -> (bool, u32) {
        let (_, needed, value, due) = self.rank(job, &[], now);
        (needed, if due > 0 && !needed { u32::MAX } else { value })
    }

    /// From when on each lane of the pool is free, but those of units that nobody needs.
    fn free_from(&self, pool: usize, now: u64) -> Vec<u64> {
        let of = |lane: u32| {
            let unit = self.running.iter().find(|unit| unit.pool == pool && unit.lane == lane);
            unit.map_or(Some(now), |unit| self.unit_end(unit, now))
        };
        (0..self.workload.pools[pool].lanes).filter_map(of).collect()
    }

    /// Bytes of a pool that are still held at an instant, if nothing more starts: results of encoders are kept.
    fn held_at(&self, pool: usize, at: i128, now: u64) -> u64 {
        let is_there = |unit: &&Unit| {
            let is_kept = self.policy.caches() && unit.key.is_some();
            unit.pool == pool && (is_kept || self.unit_end(unit, now).is_none_or(|end| i128::from(end) > at))
        };
        self.kept(pool) + self.running.iter().filter(is_there).map(|unit| unit.memory).sum::<u64>()
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
fn take(free: &mut [u64], (_, at, cost, ..): Soon) -> i128 {
    let Some(lane) = free.iter_mut().min() else { return i128::MAX };
    let start = at.max(*lane);
    *lane = start + cost;
    i128::from(start)
}
