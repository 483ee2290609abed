//! The core in the simulator beside the oracle: same rows, same sheds, same counts.

use red_sim::{Execution, Options, Report, simulate};
use red_workload::model::Workload;

use crate::oracle::{self, Policy, Reason, Row, ShedRow};

/// Whether the core does what the oracle does; else the first difference.
pub fn agree(workload: &Workload, policy: Policy, horizon_ns: u64) -> Result<(), String> {
    compare(&Found::of(core(workload, &options(policy, horizon_ns))), workload, policy, horizon_ns)
}

/// How the simulator has to run so that the two can be compared.
///
/// # Panics
///
/// Never: both lists of policies have the same length.
pub fn options(policy: Policy, horizon_ns: u64) -> Options {
    let named =
        Policy::ALL.iter().zip(red_workload::policy::Policy::NAMED).find(|(ours, _)| **ours == policy);
    let (_, policy) = named.expect("both lists are in the paper's order");
    Options { policy, horizon_ns, seed: 1, execution: Execution::Wcet, preempt: false, schedule: true }
}

/// The core's run.
///
/// # Panics
///
/// If the workload does not fit the simulator.
pub fn core(workload: &Workload, options: &Options) -> Report {
    simulate(workload, options).expect("a random workload fits")
}

/// What is compared.
#[derive(Debug)]
pub struct Found {
    /// Sub-jobs that started.
    pub rows: Vec<Row>,
    /// Jobs given up.
    pub sheds: Vec<ShedRow>,
    encoder_runs_saved: u64,
    units_dispatched: u64,
    busy_ns: Vec<u64>,
    /// Released, completed, on time, missed, shed of each task.
    tasks: Vec<[u64; 5]>,
}

impl Found {
    /// A report in the oracle's words.
    ///
    /// # Panics
    ///
    /// If a job was given up for a reason that no simulation has.
    pub fn of(report: Report) -> Self {
        let rows = report.schedule.unwrap_or_default().into_iter().map(|row| Row {
            start_ns: row.start_ns,
            pool: row.pool,
            lane: row.lane,
            task: row.task,
            job: row.job,
            node: row.node,
            finish_ns: row.finish_ns,
        });
        let reason = |name: &str| {
            let all = [Reason::Hopeless, Reason::Overload, Reason::Urgency, Reason::Full];
            all.into_iter().find(|reason| reason.name() == name).expect("a reason that a simulation gives")
        };
        let sheds = report.sheds.unwrap_or_default().into_iter();
        let shed = |shed: red_sim::Shed| ShedRow {
            at_ns: shed.at_ns,
            task: shed.task,
            job: shed.job,
            reason: reason(shed.reason),
        };
        let mut sheds: Vec<ShedRow> = sheds.map(shed).collect();
        sheds.sort();
        Self {
            rows: rows.collect(),
            sheds,
            encoder_runs_saved: report.encoder_runs_saved,
            units_dispatched: report.units_dispatched,
            busy_ns: report.pools.iter().map(|pool| pool.busy_ns).collect(),
            tasks: report
                .tasks
                .iter()
                .map(|t| [t.released, t.completed, t.on_time, t.missed, t.shed])
                .collect(),
        }
    }
}

/// Whether a run is what the oracle makes of `workload`; else the first difference.
pub fn compare(found: &Found, workload: &Workload, policy: Policy, horizon_ns: u64) -> Result<(), String> {
    let expected = oracle::simulate(workload, policy, horizon_ns);
    let equal = first_difference("shed", &found.sheds, &expected.sheds);
    first_difference("row", &found.rows, &expected.rows).map_err(|why| {
        format!("{why}{}", equal.as_ref().err().map_or(String::new(), |shed| format!("\n{shed}")))
    })?;
    equal?;
    let tasks: Vec<[u64; 5]> =
        expected.tasks.iter().map(|t| [t.released, t.completed, t.on_time, t.missed, t.shed]).collect();
    let counts = |what: &str, ours: String, theirs: String| {
        if ours == theirs { Ok(()) } else { Err(format!("{what}: {ours}, expected {theirs}")) }
    };
    counts("tasks", format!("{:?}", found.tasks), format!("{tasks:?}"))?;
    counts("busy", format!("{:?}", found.busy_ns), format!("{:?}", expected.busy_ns))?;
    counts("saved", found.encoder_runs_saved.to_string(), expected.encoder_runs_saved.to_string())?;
    counts("units", found.units_dispatched.to_string(), expected.units_dispatched.to_string())
}

fn first_difference<T: PartialEq + std::fmt::Debug>(
    what: &str,
    found: &[T],
    expected: &[T],
) -> Result<(), String> {
    let longest = found.len().max(expected.len());
    match (0..longest).find(|&i| found.get(i) != expected.get(i)) {
        Some(i) => Err(format!("{what} {i}:\n core   {:?}\n oracle {:?}", found.get(i), expected.get(i))),
        None => Ok(()),
    }
}
