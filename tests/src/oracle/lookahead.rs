//! Lanes that are left idle for a node that is soon ready (rule 14).

use super::alone::{Alone, Stage};
use super::job::{Job, State, SubId};
use super::rank::Name;
use super::{JOBS_IN_FLIGHT, Policy, RECENT_JOBS, Sim, Unit, keys};
use crate::graph::Graph;
use std::ops::Range;

/// Jobs of a task that have not been released and are waited for.
const JOBS_TO_COME: u64 = 16;

/// How often those that come make the pool look further.
const ROUNDS: u32 = 5;

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
        // What the node itself makes late counts as lost for floors.
        let mut lanes = self.free_from(pool, now);
        take(&mut lanes, head);
        lanes.sort_unstable();
        let again = lanes;
        let lost = self.lost_behind(pool, task, &again, now);
        for other in &self.jobs {
            match self.in_flight_above(pool, other, job, &lost, now) {
                Some(needs) => soon.extend(needs),
                None if looks && other.band >= job.band => soon.extend(self.behind_running(pool, other, now)),
                None => {}
            }
        }
        let mut soon: Vec<(u64, Soon)> = soon.into_iter().map(|node| (0, node)).collect();
        let mut met = 0;
        for _ in 0..ROUNDS {
            // As late as all lanes would be that had to do the head and then all that is above it so far.
            let above = soon.iter().filter(|(_, node)| node.3).map(|(_, node)| node.2);
            let horizon = end + above.sum::<u64>().div_ceil(self.workload.pools[pool].lanes.into());
            let looks_until = Some(end).filter(|_| looks && met == 0);
            soon.extend(self.next_jobs(pool, job, looks_until, (&lost, &again), now, met..horizon));
            met = horizon;
        }
        soon.retain(|&(_, (key, at, _, above, _))| {
            above || now < at && at < end && key < i128::from(end) && key < head.0
        });
        // The next jobs of each task before those after them.
        soon.sort_unstable();
        soon.truncate(JOBS_IN_FLIGHT);
        let mut soon: Vec<Soon> = soon.into_iter().map(|(_, node)| node).collect();
        soon.sort_unstable();

        let mut before = self.free_from(pool, now);
        let mut behind = before.clone();
        take(&mut behind, head);
        // One lane: what it is asked for up to an instant, by all that is above and due by then.
        let lane =
            before.first().filter(|_| self.workload.pools[pool].lanes == 1).map(|&free| i128::from(free));
        let due = |&(key, _, cost, ..): &Soon| key + i128::from(cost);
        let all = soon.clone();
        let leaves_no_time = |node: &Soon| {
            let asked = all.iter().filter(|other| other.3 && due(other) <= due(node)).map(|other| other.2);
            let asked = i128::from(asked.sum::<u64>());
            lane.is_some_and(|free| (free + asked..free + asked + i128::from(cost)).contains(&due(node)))
        };
        let mut until = Vec::new();
        for node in soon {
            let (key, at, _, above, memory) = node;
            let is_crowded =
                budget.is_some_and(|budget| self.held_at(pool, key, now) + head.4 + memory > budget);
            let is_late = take(&mut behind, node) > key || is_crowded;
            let in_time = take(&mut before, node) <= key;
            if is_late && in_time || above && leaves_no_time(&node) {
                until.push((if at <= now { u64::MAX - 1 } else { at }, above));
            }
        }
        let is_in_time = take(&mut before, head) <= head.0;
        let for_rank = until.iter().any(|&(_, above)| above);
        let until = until.into_iter().filter(|&(_, above)| above || is_in_time).map(|(at, _)| at).min()?;
        Some(Wait { until, for_rank })
    }

    /// Of tasks with a floor but one, the jobs in flight that its floor can spare if those before are lost, and that need lanes of the pool
    /// before so many are free.
    fn lost_behind(&self, pool: usize, own: usize, again: &[u64], now: u64) -> Vec<Name> {
        let mut lost = Vec::new();
        let mut others: Vec<&Job> =
            self.jobs.iter().filter(|job| job.task != own && self.has_floor(job.task)).collect();
        others.sort_by_key(|job| job.index);
        for job in others.into_iter().filter(|job| comes_to(pool, job)) {
            let latest = self.needs_of(pool, job, now).into_iter().map(|(key, ..)| key).collect();
            if !self.floor_needs(job, &lost) && are_too_few(again, latest) {
                lost.push((job.task, job.index));
            }
        }
        lost
    }

    /// What a job in flight needs from now on, if it is above where others are lost.
    fn in_flight_above(
        &self,
        pool: usize,
        job: &Job,
        head: &Job,
        lost: &[Name],
        now: u64,
    ) -> Option<Vec<Soon>> {
        (comes_to(pool, job) && self.is_waited_for(job, lost, head, now))
            .then(|| self.needs_of(pool, job, now))
    }

    /// What a job in flight needs from now on.
    fn needs_of(&self, pool: usize, job: &Job, now: u64) -> Vec<Soon> {
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
        held.into_iter().map(need).collect()
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

    /// Nodes of the jobs of each task that has released one, that come between two instants: for a higher rank the lanes that it needs,
    /// else, where the pool looks ahead so far, sources of the next; with how many jobs of the task come before.
    fn next_jobs(
        &self,
        pool: usize,
        head: &Job,
        looks_until: Option<u64>,
        (lost, again): (&[Name], &[u64]),
        now: u64,
        between: Range<u64>,
    ) -> Vec<(u64, Soon)> {
        let mut found = Vec::new();
        let (least, own) = (self.least_above(head, &[], now), self.workload.tasks[head.task].value);
        for (task, model) in self.workload.tasks.iter().enumerate() {
            let Some((at, graph)) = self.expected_release(task) else { continue };
            let period = self.gap(task).unwrap_or_default();
            let due = model.deadline_ns;
            let stages = vec![Stage::ToCome; graph.nodes.len()];
            let (held, end, memory) = self.spread(&graph, (due, due), pool, &stages);
            let spare = i128::from(due.saturating_sub(end)).min(self.slack(task, &graph));
            let mut lost = lost.to_vec();
            let mut is_first_above = false;
            for (nth, at) in (0..JOBS_TO_COME).map(|nth| (nth, at + nth * period)) {
                let index = self.next_index(task) + nth;
                let rank = (self.floor_needs_job(task, index, &lost), model.value);
                let is_above = task != head.task && rank > least && self.can_gain(task, index, &graph);
                is_first_above |= nth == 0 && is_above;
                let needs = held.iter().map(|&(from, until)| {
                    (nth, (i128::from(at + from) + spare, at + from, until - from, true, memory))
                });
                let needs: Vec<(u64, Soon)> = needs.collect();
                let is_late = are_too_few(again, needs.iter().map(|(_, (key, ..))| *key).collect());
                if !is_above && is_late && self.has_floor(task) {
                    lost.push((task, index));
                } else if is_above && between.contains(&at) {
                    found.extend(needs);
                }
            }
            let foresees = looks_until.is_some_and(|end| at < end);
            if is_first_above || !foresees || self.pressed[pool] && model.value < own {
                continue;
            }
            let keys = keys::at_release(self.policy, &graph, at, model.deadline_ns);
            for (node, &key) in graph.nodes.iter().zip(&keys) {
                if node.pool == pool && node.preds.is_empty() {
                    found.push((0, (key, at, node.cost_ns, false, 0)));
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
    pub(super) fn least_above(&self, job: &Job, lost: &[Name], now: u64) -> (bool, u32) {
        let (_, needed, value, due) = self.rank(job, lost, now);
        let learns = due > 0 && !self.tasks[job.task].is_known();
        (needed, if learns && !needed { u32::MAX } else { value })
    }

    /// Whether a job in flight, where others are lost, is one that another task's has to wait for.
    pub(super) fn is_waited_for(&self, job: &Job, lost: &[Name], by: &Job, now: u64) -> bool {
        let rank = (self.least_above(job, lost, now).0, self.workload.tasks[job.task].value);
        job.task != by.task && rank > self.least_above(by, &[], now)
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

/// Whether a job has nodes in a pool that have not started.
fn comes_to(pool: usize, job: &Job) -> bool {
    (0..job.state.len()).any(|node| job.graph.nodes[node].pool == pool && job.state[node] == State::Waiting)
}

/// Whether lanes that are free from these instants on, the first one first, are too late for nodes that have to start by these.
fn are_too_few(free: &[u64], mut latest: Vec<i128>) -> bool {
    latest.sort_unstable();
    let free = free.iter().map(|&free| i128::from(free)).chain(std::iter::repeat(i128::MAX));
    latest.into_iter().zip(free).any(|(latest, free)| latest < free)
}

/// The lane that is free first, from the node's start on.
fn take(free: &mut [u64], (_, at, cost, ..): Soon) -> i128 {
    let Some(lane) = free.iter_mut().min() else { return i128::MAX };
    let start = at.max(*lane);
    *lane = start + cost;
    i128::from(start)
}
