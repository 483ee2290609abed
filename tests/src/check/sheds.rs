//! Whether each job that was given up might be, and whether each job that was not had its place.

use super::ensure;
use super::jobs::{Facts, JobFacts};
use crate::oracle::{JOBS_IN_FLIGHT, Policy, Reason, TICK_NS};

pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    for job in &facts.jobs {
        places(facts, job)?;
        if let Some((at, reason)) = job.shed {
            legal(facts, job, at, reason)?;
        }
    }
    floors(facts)
}

/// A release is refused exactly where enough jobs are in flight.
fn places(facts: &Facts<'_>, job: &JobFacts) -> Result<(), String> {
    let before = |other: &&JobFacts| (other.release, other.task) < (job.release, job.task);
    let in_flight =
        facts.jobs.iter().filter(before).filter(|other| !other.gone_before_releases(job.release)).count();
    let refused = matches!(job.shed, Some((_, Reason::Full)));
    ensure(refused == (in_flight >= JOBS_IN_FLIGHT), || {
        format!("{} finds {in_flight} jobs in flight, refused: {refused}", facts.name(job))
    })
}

fn legal(facts: &Facts<'_>, job: &JobFacts, at: u64, reason: Reason) -> Result<(), String> {
    let name = || format!("{}, shed at {at} as {}", facts.name(job), reason.name());
    let policy = match reason {
        Reason::Full => true,
        Reason::Urgency => facts.policy == Policy::Red,
        Reason::Hopeless | Reason::Overload => facts.policy.is_ours(),
    };
    ensure(policy, || format!("{}: not a reason of this policy", name()))?;
    ensure(job.release <= at && at < facts.horizon, || format!("{}: not in flight then", name()))?;
    let done = (0..job.runs.len()).all(|node| job.done(node).is_some_and(|done| done < at));
    ensure(!done, || format!("{}: had ended", name()))?;
    let rows = job.runs.iter().flatten().count();
    match reason {
        Reason::Full => {
            ensure(at == job.release && rows == 0, || format!("{}: not refused at its release", name()))
        }
        Reason::Urgency => ensure(at.is_multiple_of(TICK_NS), || format!("{}: not at a tick", name())),
        Reason::Overload => {
            ensure(at.is_multiple_of(TICK_NS), || format!("{}: not at a tick", name()))?;
            ensure(rows == 0, || format!("{}: had started", name()))
        }
        Reason::Hopeless => {
            let due = i128::from(job.release) + i128::from(facts.workload.tasks[job.task].deadline_ns);
            // An encoder that is shared may count what is left of another, longer one.
            let ends = i128::from(at) + i128::from(longest_left(facts, job, at));
            ensure(ends > due, || format!("{}: could end at {ends}, due {due}", name()))
        }
    }
}

/// Longest remaining path at WCET, each encoder counted as the longest of its frame.
fn longest_left(facts: &Facts<'_>, job: &JobFacts, at: u64) -> u64 {
    let left = |node: usize| {
        let running = job.runs[node].iter().find(|run| run.start <= at && at < run.finish);
        match (running, job.done(node)) {
            (Some(run), _) => run.finish - at,
            (None, Some(done)) if done <= at && !facts.may_evict() => 0,
            _ => longest_of_frame(facts, job, node),
        }
    };
    let weights: Vec<u64> = (0..job.runs.len()).map(left).collect();
    job.graph.longest_path(&weights)
}

fn longest_of_frame(facts: &Facts<'_>, job: &JobFacts, node: usize) -> u64 {
    let own = &job.graph.nodes[node];
    let alike = facts.jobs.iter().flat_map(|other| &other.graph.nodes).filter(|other| {
        other.role == crate::graph::Role::Encoder && own.role == other.role && own.stage == other.stage
    });
    alike.map(|other| other.wcet_ns).max().unwrap_or(own.wcet_ns)
}

/// Of any k consecutive jobs of a task, at most k - m are given up by choice.
fn floors(facts: &Facts<'_>) -> Result<(), String> {
    for (task, model) in facts.workload.tasks.iter().enumerate() {
        let Some((m, k)) = model.floor else { continue };
        let jobs: Vec<&JobFacts> = facts.jobs.iter().filter(|job| job.task == task).collect();
        let chosen = |job: &&&JobFacts| matches!(job.shed, Some((_, Reason::Urgency | Reason::Overload)));
        for window in jobs.windows((k as usize).min(jobs.len()).max(1)) {
            let count = window.iter().filter(chosen).count();
            ensure(count <= (k - m) as usize, || format!("the floor of {} is broken", model.name))?;
        }
    }
    Ok(())
}
