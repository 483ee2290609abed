//! What a simulation at WCET under the default policy shows of a workload that every test says yes to.

use crate::outcome::Failure;
use red_sim::{Execution, Options, simulate};
use red_workload::model::{Arrival, Workload};
use red_workload::plan::{Admission, Guarantee};
use red_workload::policy::Policy;

/// Shortest simulation that counts as evidence, unless it would be too long.
const EVIDENCE_NS: u64 = 60_000_000_000;
/// Longest simulation in sub-jobs: a second or two.
pub(super) const MOST_SUB_JOBS: u128 = 1_000_000;

/// What a simulation under the default policy at WCET shows.
pub(super) enum Seen {
    /// At least one job of each task, after every event too, and all of them on time.
    OnTime,
    /// Not every task, or not every event.
    TooLittle,
    Missed(Missed),
}

/// The task that missed most.
pub(super) struct Missed {
    task: String,
    jobs: u64,
    of: u64,
    tardiness_ns: u64,
}

impl Missed {
    /// A job that misses shows that the workload does not fit, whatever the tests say. Why, in lines.
    pub(super) fn refuse(self, admission: &mut Admission) -> Vec<String> {
        let Self { task, jobs, of, tardiness_ns } = self;
        admission.fits = false;
        admission.guarantee = Guarantee::BestEffort;
        admission.binding = format!("deadlines of task `{task}` in a simulation");
        // Jobs that were given up have no finish: late by something.
        admission.margin_ns = -i128::from(tardiness_ns.max(1));
        vec![
            format!(
                "does not fit: every bound holds, but in a simulation at WCET under redrt task `{task}` misses {jobs} of {of} \
                 deadlines"
            ),
            "other offsets may miss fewer or more; `redrt sim FILE --schedule` shows where".to_owned(),
        ]
    }
}

/// Simulates no more than so many sub-jobs.
pub(super) fn seen(workload: &Workload, most_sub_jobs: u128) -> Result<Seen, Failure> {
    let horizon_ns = evidence_ns(workload, most_sub_jobs);
    let report = simulate(workload, &at_wcet(horizon_ns))?;
    let sees_events = workload.events.iter().all(|event| event.at_ns < horizon_ns);
    let missed = report.tasks.iter().filter(|task| task.missed > 0).max_by_key(|task| task.missed);
    Ok(match missed {
        Some(task) => Seen::Missed(Missed {
            task: task.name.clone(),
            jobs: task.missed,
            of: task.released,
            tardiness_ns: task.tardiness_ns.max.unwrap_or(0),
        }),
        None if sees_events && report.tasks.iter().all(|task| task.on_time > 0) => Seen::OnTime,
        None => Seen::TooLittle,
    })
}

/// The default policy, every node at its WCET.
pub(super) fn at_wcet(horizon_ns: u64) -> Options {
    Options {
        policy: Policy::default(),
        horizon_ns,
        seed: 1,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    }
}

/// Long enough to see two jobs of every task after the last event.
pub(super) fn evidence_ns(workload: &Workload, most_sub_jobs: u128) -> u64 {
    horizon_ns(workload, 2, most_sub_jobs)
}

/// Past the last event by so many jobs of every task; shorter where that would be more sub-jobs.
pub(super) fn horizon_ns(workload: &Workload, jobs: u64, most_sub_jobs: u128) -> u64 {
    let last_event = workload.events.iter().map(|event| event.at_ns).max().unwrap_or(0);
    let all_jobs = workload.tasks.iter().map(|task| {
        let jobs = period_ns(task.arrival).unwrap_or(0).saturating_mul(jobs).saturating_add(task.deadline_ns);
        jobs.saturating_add(task.offset_ns).saturating_add(1)
    });
    let wanted = last_event.saturating_add(all_jobs.max().unwrap_or(0)).max(EVIDENCE_NS);
    let affordable = u128::from(wanted) * most_sub_jobs / sub_jobs(workload, wanted).max(most_sub_jobs);
    u64::try_from(affordable).unwrap_or(wanted)
}

/// About how many sub-jobs are released in so much time.
pub(super) fn sub_jobs(workload: &Workload, horizon_ns: u64) -> u128 {
    let of_tasks = workload.tasks.iter().enumerate().map(|(i, task)| {
        let added = workload.events.iter().filter(|event| event.task == i).flat_map(|event| &event.add);
        let nodes = (task.nodes.len() + added.count()) as u128;
        nodes * period_ns(task.arrival).map_or(1, |period| u128::from(horizon_ns / period) + 1)
    });
    of_tasks.sum()
}

pub(super) const fn period_ns(arrival: Arrival) -> Option<u64> {
    match arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => Some(t),
        Arrival::Once => None,
    }
}
