//! Lanes and units: one unit at a time per lane, for exactly its time; merged rows that may be merged; memory.

use super::ensure;
use super::jobs::{Facts, FrameKey, Run};
use crate::graph::Role;
use crate::oracle::MERGE_WINDOW_NS;

/// One execution on a lane.
pub(super) struct Unit {
    pub(super) pool: usize,
    pub(super) run: Run,
    /// Frame, where it is an encoder that may be shared.
    pub(super) key: Option<FrameKey>,
    /// Position of the job in the facts, and node.
    pub(super) members: Vec<(usize, usize)>,
}

/// The executions of a schedule: rows of one lane, instant and frame are one unit where the policy merges.
pub(super) fn units(facts: &Facts<'_>) -> Vec<Unit> {
    let mut units: Vec<Unit> = Vec::new();
    for (index, job) in facts.jobs.iter().enumerate() {
        for (node, runs) in job.runs.iter().enumerate() {
            let encoder = job.graph.nodes[node].role == Role::Encoder && facts.policy.merges();
            let key = facts.frame(job, node).filter(|_| encoder);
            let pool = job.graph.nodes[node].pool;
            for &run in runs.iter().filter(|run| run.lane.is_some()) {
                let same = |unit: &&mut Unit| {
                    key.is_some() && unit.key == key && unit.run == run && unit.pool == pool
                };
                match units.iter_mut().find(same) {
                    Some(unit) => unit.members.push((index, node)),
                    None => units.push(Unit { pool, run, key: key.clone(), members: vec![(index, node)] }),
                }
            }
        }
    }
    units.sort_by_key(|unit| (unit.pool, unit.run.lane, unit.run.start, unit.run.finish));
    units
}

pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    let units = units(facts);
    for unit in &units {
        let wcet = |&(job, node): &(usize, usize)| facts.jobs[job].graph.nodes[node].wcet_ns;
        let longest = unit.members.iter().map(wcet).max().unwrap_or(0);
        let took = unit.run.finish.checked_sub(unit.run.start);
        ensure(took == Some(longest), || {
            format!("{} runs for {took:?}, not {longest}", describe(facts, unit))
        })?;
        let releases: Vec<u64> = unit.members.iter().map(|&(job, _)| facts.jobs[job].release).collect();
        let spread = releases.iter().max().unwrap_or(&0) - releases.iter().min().unwrap_or(&0);
        // Encoders of no cost may follow each other on a lane within one instant.
        ensure(spread <= MERGE_WINDOW_NS || longest == 0, || {
            format!("{} is merged too widely", describe(facts, unit))
        })?;
        ensure(longest == 0 || guarded(facts, unit), || {
            format!("{} delays a member too far", describe(facts, unit))
        })?;
        ensure(lowest_lane(&units, unit), || format!("{} skips a free lane", describe(facts, unit)))?;
    }
    for pair in units.windows(2) {
        let same_lane = (pair[0].pool, pair[0].run.lane) == (pair[1].pool, pair[1].run.lane);
        ensure(!same_lane || pair[0].run.finish <= pair[1].run.start, || {
            format!("{} and {} overlap", describe(facts, &pair[0]), describe(facts, &pair[1]))
        })?;
    }
    memory(facts, &units)
}

/// Whether every member that waits for a costlier one still meets its latest finish.
fn guarded(facts: &Facts<'_>, unit: &Unit) -> bool {
    let cost = |&(job, node): &(usize, usize)| facts.jobs[job].graph.nodes[node].cost_ns;
    let longest = unit.members.iter().map(cost).max().unwrap_or(0);
    let latest = |&(job, node): &(usize, usize)| {
        let job = &facts.jobs[job];
        let due = i128::from(job.release) + i128::from(facts.workload.tasks[job.task].deadline_ns);
        due - i128::from(job.graph.tails(&job.graph.costs())[node])
    };
    let end = i128::from(unit.run.start) + i128::from(longest);
    unit.members.iter().all(|member| cost(member) == longest || end <= latest(member))
}

/// Whether every lower lane of the pool was taken, or used within that instant.
fn lowest_lane(units: &[Unit], unit: &Unit) -> bool {
    let start = unit.run.start;
    let taken = |lane: u32| {
        units.iter().any(|other| {
            (other.pool, other.run.lane) == (unit.pool, Some(lane))
                && other.run.start <= start
                && (other.run.finish > start || other.run.start == start)
        })
    };
    (0..unit.run.lane.unwrap_or(0)).all(taken)
}

/// Footprints of what runs together stay within the budget. Cached outputs come on top, unseen here.
fn memory(facts: &Facts<'_>, units: &[Unit]) -> Result<(), String> {
    for (pool, model) in facts.workload.pools.iter().enumerate() {
        let Some(budget) = model.memory_bytes else { continue };
        let here: Vec<&Unit> = units.iter().filter(|unit| unit.pool == pool).collect();
        for unit in &here {
            let now = unit.run.start;
            let together = here.iter().filter(|other| other.run.start <= now && now < other.run.finish);
            let footprint = |unit: &&&Unit| {
                let member = |&(job, node): &(usize, usize)| facts.jobs[job].graph.nodes[node].memory_bytes;
                unit.members.iter().map(member).max().unwrap_or(0)
            };
            let used: u64 = together.map(|unit| footprint(&unit)).sum();
            ensure(used <= budget, || {
                format!("{} runs beyond the memory of its pool", describe(facts, unit))
            })?;
        }
    }
    Ok(())
}

pub(super) fn describe(facts: &Facts<'_>, unit: &Unit) -> String {
    let names: Vec<String> = unit
        .members
        .iter()
        .map(|&(job, node)| {
            format!("{} of {}", facts.jobs[job].graph.nodes[node].name, facts.name(&facts.jobs[job]))
        })
        .collect();
    format!("{} at {}", names.join(" + "), unit.run.start)
}
