//! Whether each job that was given up might be, and whether each job that was not had its place.

use super::cache::is_surely_kept;
use super::ensure;
use super::jobs::{Facts, JobFacts};
use super::lanes::{Unit, units};
use crate::graph::Role;
use crate::oracle::{FLOOR_MEMORY, JOBS_IN_FLIGHT, Policy, Reason, TICK_NS};
use red_workload::model::Arrival;

pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    let units = units(facts);
    for job in &facts.jobs {
        places(facts, job)?;
        if let Some((at, reason)) = job.shed {
            legal(facts, &units, job, at, reason)?;
        }
    }
    Ok(())
}

fn is_full_at(job: &JobFacts, at: u64) -> bool {
    job.shed == Some((at, Reason::Full))
}

/// A release into a full table costs one job that is there by then: itself, or under ours perhaps another.
fn places(facts: &Facts<'_>, job: &JobFacts) -> Result<(), String> {
    let at = job.release;
    let released_by = |other: &&JobFacts| (other.release, other.task) <= (at, job.task);
    let is_there = |other: &&JobFacts| other.release == at || !other.gone_before_releases(at);
    let there = facts.jobs.iter().filter(released_by).filter(is_there).count();
    let too_many = there.saturating_sub(JOBS_IN_FLIGHT);
    let name = || format!("{} is the {there}th job in flight", facts.name(job));
    if !facts.policy.is_ours() {
        let refused = is_full_at(job, at);
        return ensure(refused == (too_many > 0), || format!("{}, refused: {refused}", name()));
    }
    let full = |other: &&JobFacts| is_full_at(other, at);
    let full_by_then = facts.jobs.iter().filter(full).filter(released_by).count();
    let all_full = facts.jobs.iter().filter(full).count();
    let is_last = !facts.jobs.iter().any(|other| other.release == at && other.task > job.task);
    let fits = full_by_then >= too_many && (!is_last || all_full == too_many);
    ensure(fits, || format!("{}, but {all_full} were refused or replaced", name()))
}

fn legal(facts: &Facts<'_>, units: &[Unit], job: &JobFacts, at: u64, reason: Reason) -> Result<(), String> {
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
    // What goes in later rounds of an instant may have started in the first.
    let first_round = match reason {
        Reason::Full | Reason::Urgency => true,
        Reason::Overload => !facts.may_evict(),
        Reason::Hopeless => false,
    };
    let starts = job.runs.iter().flatten().any(|run| run.lane.is_some() && run.start == at);
    ensure(!first_round || !starts, || format!("{}: starts at that instant", name()))?;
    let released = |keeps: fn(&JobFacts) -> bool| {
        facts.jobs.iter().any(|other| other.release == at && (keeps(other) || !is_full_at(other, at)))
    };
    match reason {
        Reason::Full if facts.policy.is_ours() => {
            ensure(released(|_| true), || format!("{}: nobody is released", name()))
        }
        Reason::Full => {
            let rows = job.runs.iter().flatten().count();
            ensure(at == job.release && rows == 0, || format!("{}: not refused at its release", name()))
        }
        Reason::Urgency => {
            ensure(at.is_multiple_of(TICK_NS), || format!("{}: not at a tick", name()))?;
            ensure(is_spared(facts, job, at), || format!("{}: its floor is broken", name()))
        }
        Reason::Overload => {
            // A wait for a higher rank may have ended.
            let tasks = &facts.workload.tasks;
            let waits = tasks.iter().any(|task| task.floor.is_some() || task.value != tasks[0].value);
            let is_due = waits || facts.may_evict() || released(|_| false);
            ensure(is_due, || format!("{}: no job came", name()))?;
            let stays = |other: &JobFacts| {
                let goes = other.shed.is_some_and(|(gone, reason)| {
                    // A start that throws a result away has another look follow at the same instant.
                    let went_too = matches!(reason, Reason::Overload | Reason::Full) && !facts.may_evict();
                    gone < at || gone == at && went_too
                });
                other.release <= at && !goes && other.end.is_none_or(|end| end >= at)
            };
            // What has not started may go for the next one of its task.
            let started = job.runs.iter().flatten().any(|run| run.start < at);
            let is_for_next = !started && may_delay_next(facts, job, at);
            ensure(is_for_next || facts.jobs.iter().any(stays), || format!("{}: for nobody", name()))
        }
        Reason::Hopeless => {
            let due = i128::from(job.release) + i128::from(facts.workload.tasks[job.task].deadline_ns);
            let ends = i128::from(at) + i128::from(least_left(facts, units, job, at));
            ensure(ends > due, || format!("{}: could end at {ends}, due {due}", name()))
        }
    }
}

/// Whether all that is there, one after the other, ends too late for the next job of a task: it could have at least its
/// deadline less its longest path and its work over lanes.
fn may_delay_next(facts: &Facts<'_>, job: &JobFacts, at: u64) -> bool {
    let task = &facts.workload.tasks[job.task];
    let gap = match task.arrival {
        Arrival::Periodic { period_ns } => period_ns,
        Arrival::Sporadic { min_interarrival_ns } => min_interarrival_ns,
        Arrival::Once => return false,
    };
    if facts.may_evict() || !facts.workload.events.is_empty() {
        return true;
    }
    let of_task = facts.jobs.iter().filter(|other| other.task == job.task && other.release <= at);
    let next = of_task.map(|other| other.release + gap).max().unwrap_or_default();
    let graph = &job.graph;
    let over_lanes = facts.workload.pools.iter().enumerate().map(|(pool, model)| {
        let here = graph.nodes.iter().filter(|sub| sub.pool == pool);
        here.map(|sub| sub.cost_ns).sum::<u64>().div_ceil(model.lanes.into())
    });
    let least = over_lanes.fold(graph.longest_path(&graph.costs()), u64::max);
    let left = |other: &JobFacts| -> u64 {
        let is_there = other.release <= at && other.shed.is_none_or(|(gone, _)| gone >= at);
        let of = |node: usize| {
            let runs = &other.runs[node];
            match runs.iter().find(|run| run.start <= at && at < run.finish) {
                Some(run) => other.graph.nodes[node].cost_ns.saturating_sub(at - run.start),
                None if is_there && other.done(node).is_none_or(|done| done > at) => {
                    other.graph.nodes[node].cost_ns
                }
                None => 0,
            }
        };
        (0..other.runs.len()).map(of).sum()
    };
    let ends = at + facts.jobs.iter().map(left).sum::<u64>();
    i128::from(ends) > i128::from(next) + i128::from(task.deadline_ns) - i128::from(least)
}

/// What a job takes at least from `at` on: its longest path, and its work but for encoders over the lanes of each
/// pool. On the path an encoder counts unless its result is surely there or on its way.
fn least_left(facts: &Facts<'_>, units: &[Unit], job: &JobFacts, at: u64) -> u64 {
    let is_there = |node: usize| {
        let key = facts.frame(job, node).filter(|_| job.graph.nodes[node].role == Role::Encoder);
        key.is_some_and(|key| {
            let runs =
                |unit: &Unit| unit.key.as_ref() == Some(&key) && unit.run.start < at && at < unit.run.finish;
            units.iter().any(runs) || is_surely_kept(facts, units, job, &key, at)
        })
    };
    let left = |node: usize| {
        let sub = &job.graph.nodes[node];
        let running = job.runs[node].iter().find(|run| run.start <= at && at < run.finish);
        let runs_once = !facts.may_evict() || sub.role != Role::Encoder;
        match (running, job.done(node)) {
            (Some(run), _) => sub.wcet_ns.saturating_sub(at - run.start),
            (None, Some(done)) if done <= at && runs_once => 0,
            _ if is_there(node) => 0,
            _ => sub.wcet_ns,
        }
    };
    let left: Vec<u64> = (0..job.runs.len()).map(left).collect();
    let on_all_lanes = facts.workload.pools.iter().enumerate().map(|(pool, model)| {
        let nodes = job.graph.nodes.iter().enumerate();
        let here =
            nodes.filter(|(_, sub)| sub.pool == pool && sub.role != Role::Encoder).map(|(node, _)| node);
        here.map(|node| left[node]).sum::<u64>().div_ceil(u64::from(model.lanes))
    });
    on_all_lanes.fold(job.graph.longest_path(&left), u64::max)
}

/// Whether the floor of a job that went by choice spared it: of every window with it, few enough were lost by then,
/// those that went with it included.
fn is_spared(facts: &Facts<'_>, job: &JobFacts, at: u64) -> bool {
    let model = &facts.workload.tasks[job.task];
    let Some((m, k)) = model.floor else { return true };
    let (m, k) = (u64::from(m), u64::from(k));
    let (window, spare) = (k.min(FLOOR_MEMORY), (k - m) / k.div_ceil(FLOOR_MEMORY));
    let lost = |other: &&JobFacts| {
        let due = i128::from(other.release) + i128::from(model.deadline_ns);
        let late = other.end.is_some_and(|end| end < at && i128::from(end) > due);
        late || other.shed.is_some_and(|(gone, _)| gone <= at)
    };
    let starts = (job.index + 1).saturating_sub(window)..=job.index;
    starts.into_iter().all(|start| {
        let within = |other: &&JobFacts| (start..start + window).contains(&other.index);
        let task = facts.jobs.iter().filter(|other| other.task == job.task);
        task.filter(within).filter(lost).count() as u64 <= spare
    })
}
