//! Frame-cache hits that an encoder run justifies, and encoder runs that no hit or wait could replace.

use super::ensure;
use super::jobs::{Facts, FrameKey, JobFacts};
use super::lanes::{Unit, describe, units};
use crate::graph::Role;

pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    let units: Vec<Unit> = units(facts).into_iter().filter(|unit| unit.key.is_some()).collect();
    for job in &facts.jobs {
        for (node, runs) in job.runs.iter().enumerate() {
            for run in runs.iter().filter(|run| run.lane.is_none()) {
                let name = || format!("{} of {}", job.graph.nodes[node].name, facts.name(job));
                let hit = run.start == run.finish && job.graph.nodes[node].role == Role::Encoder;
                ensure(hit, || format!("{} has no lane and is no hit", name()))?;
                let key = facts.frame(job, node);
                let alive = |unit: &&Unit| unit.key == key && unit.run.finish <= run.start;
                let alive_until = |unit: &Unit| life(facts, unit, Edge::Touching);
                ensure(units.iter().filter(alive).any(|unit| run.start <= alive_until(unit)), || {
                    format!("{} hits at {} what nothing left there", name(), run.start)
                })?;
            }
        }
    }
    if facts.may_evict() {
        return Ok(());
    }
    for unit in &units {
        let start = unit.run.start;
        for other in units.iter().filter(|other| other.key == unit.key && !std::ptr::eq(*other, unit)) {
            let runs = other.run.start <= start && start < other.run.finish;
            // What took no time at this instant may have ended after the lanes were filled.
            let ended = other.run.finish <= start && other.run.start < start;
            let kept = ended && start < life(facts, other, Edge::Overlapping);
            ensure(!runs && !kept, || {
                format!("{} runs although {} has its result", describe(facts, unit), describe(facts, other))
            })?;
        }
    }
    Ok(())
}

/// Whether what `job` needs of frame `key` is surely kept at `at`, after the completions and releases of then.
pub(super) fn is_surely_kept(
    facts: &Facts<'_>,
    units: &[Unit],
    job: &JobFacts,
    key: &FrameKey,
    at: u64,
) -> bool {
    let of_key = |unit: &&Unit| unit.key.as_ref() == Some(key);
    let ended = |unit: &&Unit| unit.run.finish <= at && unit.run.start < at;
    let lives = |unit: &Unit| {
        let until = life(facts, unit, Edge::Overlapping);
        at < until || at == until && job.release < at
    };
    !facts.may_evict() && units.iter().filter(of_key).filter(ended).any(lives)
}

/// How far two needs must overlap for the output to live on: surely, or possibly, since rows do not show the
/// order within an instant.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Edge {
    Overlapping,
    Touching,
}

/// Until when the output of `unit` lives: while any stage of a job in flight needs it.
fn life(facts: &Facts<'_>, unit: &Unit, edge: Edge) -> u64 {
    let key = unit.key.as_ref().expect("only encoder units have a life");
    let needs: Vec<(u64, u64)> = facts.jobs.iter().filter_map(|job| need(facts, job, key)).collect();
    let mut until = unit.run.finish;
    loop {
        let longer = needs.iter().filter(|(from, to)| match edge {
            Edge::Overlapping => *from < until && until < *to,
            Edge::Touching => *from <= until && until < *to,
        });
        match longer.map(|(_, to)| *to).max() {
            Some(to) => until = to,
            None => return until,
        }
    }
}

/// From the release of a job until its last decoder of the frame is done, or the job is given up.
fn need(facts: &Facts<'_>, job: &JobFacts, key: &FrameKey) -> Option<(u64, u64)> {
    let decoder = |&node: &usize| {
        job.graph.nodes[node].role == Role::Decoder && facts.frame(job, node).as_ref() == Some(key)
    };
    let ends = (0..job.runs.len()).filter(decoder).map(|node| job.done(node).unwrap_or(u64::MAX));
    let shed = job.shed.map_or(u64::MAX, |(at, _)| at);
    ends.max().map(|end| (job.release, end.min(shed)))
}
