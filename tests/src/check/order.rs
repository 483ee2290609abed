//! No lane idles while a node waits for it, and nodes start in key order.

use super::ensure;
use super::jobs::{Facts, JobFacts};
use super::lanes::{Unit, describe, units};
use crate::graph::Role;
use crate::oracle::Policy;
use crate::plan::{level_offsets, level_sums};

/// Key, release, task, job index, node index.
type Order = (i128, u64, usize, u64, usize);

/// A node between the instant it became ready and the instant it started, or would not any more.
struct Wait {
    pool: usize,
    from: u64,
    to: u64,
    job: usize,
    node: usize,
    order: Order,
}

pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    let waits_for_grid = facts.workload.sync.is_some() && facts.policy.waits_for_grid();
    if facts.may_evict() || waits_for_grid {
        return Ok(());
    }
    let units = units(facts);
    let keys: Vec<Vec<i128>> = facts.jobs.iter().map(|job| keys(facts, job)).collect();
    let waits = waits(facts, &keys);
    for pool in 0..facts.workload.pools.len() {
        if facts.workload.pools[pool].memory_bytes.is_some() {
            continue;
        }
        let here: Vec<&Wait> = waits.iter().filter(|wait| wait.pool == pool).collect();
        if facts.policy != Policy::RedrtLookahead {
            idle_lanes(facts, pool, &units, &here)?;
        }
        // Re-assigned keys do not show in the rows.
        if !facts.policy.reassigns() {
            starts_in_order(facts, pool, &units, &keys, &here)?;
        }
    }
    Ok(())
}

fn waits(facts: &Facts<'_>, keys: &[Vec<i128>]) -> Vec<Wait> {
    let mut waits = Vec::new();
    for (index, (job, keys)) in facts.jobs.iter().zip(keys).enumerate() {
        for (node, &key) in keys.iter().enumerate() {
            let Some(from) = job.ready(node, facts.policy.gates_levels()) else { continue };
            let start = job.runs[node].first().map_or(facts.horizon, |run| run.start);
            let to = job.shed.map_or(start, |(at, _)| start.min(at));
            let pool = job.graph.nodes[node].pool;
            waits.push(Wait { pool, from, to, job: index, node, order: order(job, node, key) });
        }
    }
    waits
}

/// Spans in which a lane of the pool is free, cut where an encoder of any pool starts or ends.
fn idle_spans(facts: &Facts<'_>, pool: usize, units: &[Unit]) -> Vec<(u64, u64)> {
    let here: Vec<&Unit> = units.iter().filter(|unit| unit.pool == pool).collect();
    let cuts = units.iter().filter(|unit| unit.pool == pool || unit.key.is_some());
    let mut instants: Vec<u64> = cuts.flat_map(|unit| [unit.run.start, unit.run.finish]).collect();
    instants.extend([0, facts.horizon]);
    instants.retain(|&instant| instant <= facts.horizon);
    instants.sort_unstable();
    instants.dedup();
    let lanes = facts.workload.pools[pool].lanes as usize;
    let busy = |now: u64| here.iter().filter(|unit| unit.run.start <= now && now < unit.run.finish).count();
    let spans = instants.windows(2).map(|pair| (pair[0], pair[1]));
    spans.filter(|&(from, _)| busy(from) < lanes).collect()
}

fn idle_lanes(facts: &Facts<'_>, pool: usize, units: &[Unit], waits: &[&Wait]) -> Result<(), String> {
    for (from, to) in idle_spans(facts, pool, units) {
        for wait in waits.iter().filter(|wait| from.max(wait.from) < to.min(wait.to)) {
            let job = &facts.jobs[wait.job];
            let since = from.max(wait.from);
            let mut here = waits.iter().filter(|wait| (wait.from..wait.to).contains(&since));
            let is_held = here.any(|head| awaits_rank(facts, head, since));
            ensure(is_held || awaits_key(facts, units, wait, since), || {
                let node = &job.graph.nodes[wait.node].name;
                format!("{node} of {} waits while a lane idles in {from}..{to}", facts.name(job))
            })?;
        }
    }
    Ok(())
}

/// Whether the node may wait for a job of a task with a larger value or a floor: one that is released before the node would
/// end, or what is above and comes until then, or that has a node of the pool that has not started.
fn awaits_rank(facts: &Facts<'_>, wait: &Wait, now: u64) -> bool {
    let (job, tasks) = (&facts.jobs[wait.job], &facts.workload.tasks);
    let end = now + job.graph.nodes[wait.node].cost_ns;
    let is_above = |task: usize| tasks[task].value > tasks[job.task].value || tasks[task].floor.is_some();
    let is_to_come = |other: &JobFacts, node: usize| {
        let has_not_started = other.runs[node].first().is_none_or(|run| run.start > now);
        other.graph.nodes[node].pool == wait.pool && has_not_started
    };
    let is_in_flight = |other: &JobFacts| {
        let is_there = other.release <= now && other.end.is_none_or(|end| end > now);
        let is_given_up = other.shed.is_some_and(|(at, _)| at <= now);
        is_there && !is_given_up && (0..other.runs.len()).any(|node| is_to_come(other, node))
    };
    let others = || facts.jobs.iter().filter(|other| other.task != job.task && is_above(other.task));
    // What is above and comes meanwhile can be late because of the node, too.
    let lanes = u64::from(facts.workload.pools[wait.pool].lanes);
    let work = |other: &JobFacts| other.graph.costs().iter().sum::<u64>() * lanes;
    let mut horizon = end;
    for _ in 0..6 {
        let meets = |other: &&JobFacts| is_in_flight(other) || (now..horizon).contains(&other.release);
        horizon = end + others().filter(meets).map(work).sum::<u64>();
    }
    let is_next = |other: &JobFacts| now < other.release && other.release < horizon;
    facts.policy.is_ours()
        && (horizon > facts.horizon || others().any(|other| is_next(other) || is_in_flight(other)))
}

/// Whether the encoder waits for a running one of its frame.
fn awaits_key(facts: &Facts<'_>, units: &[Unit], wait: &Wait, now: u64) -> bool {
    let job = &facts.jobs[wait.job];
    if !facts.policy.caches() || job.graph.nodes[wait.node].role != Role::Encoder {
        return false;
    }
    let key = facts.frame(job, wait.node);
    units.iter().any(|unit| unit.key == key && unit.run.start <= now && now < unit.run.finish)
}

fn starts_in_order(
    facts: &Facts<'_>,
    pool: usize,
    units: &[Unit],
    keys: &[Vec<i128>],
    waits: &[&Wait],
) -> Result<(), String> {
    let loses: Vec<bool> = (0..facts.workload.tasks.len()).map(|task| loses(facts, task)).collect();
    for unit in units.iter().filter(|unit| unit.pool == pool) {
        let now = unit.run.start;
        let member = |&(job, node): &(usize, usize)| order(&facts.jobs[job], node, keys[job][node]);
        let Some(first) = unit.members.iter().map(member).min() else { continue };
        // Of two that only their tasks' fortunes or their order tell apart, either may go first once a task has lost jobs.
        let is_before = |wait: &&&Wait| {
            let (key, release, task, index, _) = wait.order;
            let is_told = (key, release) < (first.0, first.1) || (task, index) == (first.2, first.3);
            wait.order < first && (is_told || !facts.policy.is_ours() || !(loses[task] || loses[first.2]))
        };
        for wait in waits.iter().filter(is_before).filter(|wait| wait.to > now) {
            if unit.members.iter().any(|&(job, _)| may_pass(facts, job, wait.job)) {
                continue;
            }
            // Others go before one that waits for a higher rank, and with lookahead before others that wait.
            let looks = facts.policy == Policy::RedrtLookahead;
            let mut here = waits.iter().filter(|other| (other.from..other.to).contains(&now));
            if awaits_rank(facts, wait, now) || looks && here.any(|other| awaits_rank(facts, other, now)) {
                continue;
            }
            let ready = wait.from < now || wait.from == now && !late_in_instant(facts, wait);
            ensure(!ready || awaits_key(facts, units, wait, now), || {
                let job = &facts.jobs[wait.job];
                let node = &job.graph.nodes[wait.node].name;
                format!(
                    "{} starts before {node} of {}, whose key is smaller",
                    describe(facts, unit),
                    facts.name(job)
                )
            })?;
        }
    }
    Ok(())
}

/// Whether a task has a job that was given up, is late, or has not ended.
fn loses(facts: &Facts<'_>, task: usize) -> bool {
    let is_late = |end: u64, release: u64| end > release + facts.workload.tasks[task].deadline_ns;
    let mut jobs = facts.jobs.iter().filter(|job| job.task == task);
    jobs.any(|job| job.shed.is_some() || job.end.is_none_or(|end| is_late(end, job.release)))
}

/// Whether nodes of a job may go before those of another one that have smaller keys: under pressure (8.10), by rank or deadline.
fn may_pass(facts: &Facts<'_>, first: usize, other: usize) -> bool {
    let (first, other) = (&facts.jobs[first], &facts.jobs[other]);
    let [task, other_task] = [first, other].map(|job| &facts.workload.tasks[job.task]);
    let due = other.release + other_task.deadline_ns;
    let may_be_late = other.end.is_none_or(|end| end > due);
    let is_due_before = first.release + task.deadline_ns < due;
    let is_above = task.value > other_task.value || task.floor.is_some() || may_be_late || is_due_before;
    facts.policy.is_ours() && (first.task, first.index) != (other.task, other.index) && is_above
}

/// Whether the node became ready through something that took no time at that instant, so that lanes may have
/// been filled before.
fn late_in_instant(facts: &Facts<'_>, wait: &Wait) -> bool {
    let job = &facts.jobs[wait.job];
    let mut runs = job.runs.iter().flatten();
    runs.any(|run| run.start == wait.from && run.finish == wait.from)
}

fn order(job: &JobFacts, node: usize, key: i128) -> Order {
    (key, job.release, job.task, job.index, node)
}

/// Keys at release, on the time axis.
fn keys(facts: &Facts<'_>, job: &JobFacts) -> Vec<i128> {
    let deadline = facts.workload.tasks[job.task].deadline_ns;
    let due = i128::from(job.release) + i128::from(deadline);
    let costs = job.graph.costs();
    match facts.policy {
        Policy::Edf => vec![due; costs.len()],
        Policy::RedFg | Policy::RedIda | Policy::Red => {
            let ends = level_offsets(&level_sums(&job.heights, &costs), deadline);
            job.heights.iter().map(|&height| i128::from(job.release) + i128::from(ends[height])).collect()
        }
        Policy::Redrt | Policy::RedrtLookahead => {
            let tails = job.graph.tails(&costs);
            (0..costs.len()).map(|v| due - i128::from(tails[v]) - i128::from(costs[v])).collect()
        }
    }
}
