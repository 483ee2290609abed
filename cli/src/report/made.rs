//! From what was collected to what a page says: figures, misses with their chains, groups of one cause.

use super::collect::Collector;
use red_core::Instant;
use red_report::blame::{Blame, longest};
use red_report::model::{Figures, Group, Kind, Miss, Part, Run};
use red_workload::metrics::{Judged, TaskMetrics, summarise};

/// Works out everything that needs no simulation. Jobs released before `until` count, by what happened before `end`.
pub(super) fn made(
    collected: Collector,
    until_ns: u64,
    end_ns: u64,
) -> (Run, Vec<TaskMetrics>, crate::replay::figures::Figures) {
    let Collector { mut run, logs, ranks, figures, .. } = collected;
    let instant = Instant::from_nanos;
    let named = run.tasks.iter().zip(ranks).zip(&logs).enumerate();
    let metrics: Vec<TaskMetrics> = named
        .map(|(number, ((task, (value, floor)), log))| {
            let judged = Judged { name: &task.name, value, floor };
            let nodes = figures.executions.of(number);
            TaskMetrics { nodes, ..summarise(judged, log, instant(until_ns), instant(end_ns)) }
        })
        .collect();
    run.nodes_missed = figures.nodes_missed;
    for (lane, busy_ns) in run.lanes.iter().zip(figures.busy_ns) {
        run.pools[lane.pool].busy_ns += busy_ns;
    }
    let mut misses = Vec::new();
    for (task, jobs) in run.jobs.iter_mut().enumerate() {
        let mut of_task = Figures::default();
        for (number, job) in jobs.iter_mut().enumerate().filter(|(_, job)| job.release_ns < until_ns) {
            job.counts = true;
            // As the metrics have it.
            let ended = job.end_ns.filter(|at| *at < end_ns || job.shed.as_deref() == Some("full"));
            let missed = match (ended, &job.shed) {
                (Some(_), Some(_)) => true,
                (Some(at), None) => {
                    of_task.responses_ns.push(at.saturating_sub(job.release_ns));
                    at > job.deadline_ns
                }
                (None, _) => job.deadline_ns < end_ns,
            };
            if missed {
                misses.push((task, number as u64, ended.unwrap_or(run.end_ns)));
            }
        }
        let TaskMetrics { released, on_time, missed, shed, response_ns, given_up, floor, .. } =
            &metrics[task];
        run.tasks[task].figures = Figures {
            released: *released,
            on_time: *on_time,
            missed: *missed,
            shed: *shed,
            reasons: given_up.iter().map(|(reason, count)| ((*reason).to_owned(), *count)).collect(),
            floor: floor.map(|floor| (floor.m, floor.k, floor.worst)),
            value: [metrics[task].value_on_time, metrics[task].value_released],
            response_ns: [response_ns.p50, response_ns.p99, response_ns.max],
            ..of_task
        };
    }
    let blame = Blame::new(&run);
    let miss = |(task, job, until_ns)| Miss {
        task,
        job,
        until_ns,
        parts: blame.chain(task, job, until_ns),
        saved_by: None,
    };
    let misses: Vec<Miss> = misses.into_iter().map(miss).collect();
    run.misses = misses;
    run.groups = groups(&run);
    (run, metrics, figures)
}

/// Misses of one task, reason and cause, the most first.
fn groups(run: &Run) -> Vec<Group> {
    let mut groups: Vec<Group> = Vec::new();
    for (number, miss) in run.misses.iter().enumerate() {
        let reason = run.job(miss.task, miss.job).and_then(|job| job.shed.as_deref());
        let cause = cause(run, miss.task, reason, &miss.parts);
        match groups.iter_mut().find(|group| group.cause == cause) {
            Some(group) => group.misses.push(number),
            None => groups.push(Group { cause, misses: vec![number], best: None }),
        }
    }
    groups.sort_by_key(|group| std::cmp::Reverse(group.misses.len()));
    groups
}

fn cause(run: &Run, task: usize, reason: Option<&str>, parts: &[Part]) -> String {
    let whose = |by: Option<usize>| match by {
        Some(by) if by == task => "other jobs or nodes of its own".to_owned(),
        Some(by) => run.task(by).to_owned(),
        None => "nobody".to_owned(),
    };
    let most = match longest(parts) {
        Some((Kind::Lane, by)) => format!("waiting for a lane that {} had", whose(by)),
        Some((Kind::Encoder, by)) => format!("waiting for an encoder of {}", whose(by)),
        Some((kind, _)) => kind.words().to_owned(),
        None => "no place at its release".to_owned(),
    };
    let given_up = reason.map(|reason| format!(", given up ({reason})")).unwrap_or_default();
    format!("{}{given_up}: {most}", run.task(task))
}
