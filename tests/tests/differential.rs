//! The core in the simulator against the oracle, on random workloads under every policy: same rows, same sheds,
//! same counts. What they agree on is also judged by rules that hold for every schedule.
//!
//! `SEEDS=2000` looks at more workloads per test than the default.

use std::panic::resume_unwind;
use std::thread;

use red_sim::{Execution, Options, Report, simulate};
use red_tests::check::validate;
use red_tests::oracle::{self, Outcome, Policy, Reason, Row, ShedRow};
use red_tests::rng::{Shape, random_workload};
use red_workload::model::Workload;

#[test]
fn the_core_does_what_the_oracle_does() {
    agree(150, &Shape::default());
}

#[test]
fn they_agree_where_memory_is_unlimited() {
    agree(60, &Shape { memory: false, ..Shape::default() });
}

#[test]
fn they_agree_on_one_pool() {
    agree(60, &Shape { pools: 1, ..Shape::default() });
}

#[test]
fn they_agree_where_jobs_have_to_go() {
    agree(60, &Shape { load_percent: (120, 250), ..Shape::default() });
}

#[test]
fn they_agree_on_small_graphs_of_many_tasks() {
    agree(60, &Shape { tasks: 12, nodes: 4, ..Shape::default() });
}

#[test]
fn every_schedule_of_the_core_passes_the_judge() {
    each(100, &Shape::default(), |workload, policy, horizon_ns| {
        let found = outcome(core(workload, &options(policy, horizon_ns)));
        validate(workload, policy, horizon_ns, &found.rows, &found.sheds)
    });
}

#[test]
fn equal_options_give_equal_bytes() {
    each(25, &Shape::default(), |workload, policy, horizon_ns| {
        let wcet = options(policy, horizon_ns);
        let execution = Execution::Uniform { low_ppm: 300_000, high_ppm: 1_000_000 };
        let uniform = Options { execution, ..wcet };
        let preemptive = Options { preempt: true, ..uniform };
        for options in [wcet, uniform, preemptive] {
            let bytes = || serde_json::to_vec(&core(workload, &options)).expect("a report has a JSON form");
            if bytes() != bytes() {
                return Err(format!("two runs differ with {options:?}"));
            }
        }
        Ok(())
    });
}

fn agree(seeds: u64, shape: &Shape) {
    each(seeds, shape, |workload, policy, horizon_ns| {
        let found = outcome(core(workload, &options(policy, horizon_ns)));
        compare(&found, &oracle::simulate(workload, policy, horizon_ns))
    });
}

/// Tests every policy on this many random workloads, or `SEEDS` of them, over 0.1 to 0.3 s.
fn each(seeds: u64, shape: &Shape, test: impl Fn(&Workload, Policy, u64) -> Result<(), String> + Sync) {
    let asked = std::env::var("SEEDS").ok();
    let seeds = asked.map_or(seeds, |asked| asked.parse().expect("SEEDS is a number of workloads"));
    let all = || {
        for seed in 0..seeds {
            let workload = random_workload(seed, shape);
            for policy in Policy::ALL {
                let horizon_ns = 100_000_000 * (1 + seed % 3);
                if let Err(why) = test(&workload, policy, horizon_ns) {
                    panic!("seed {seed}, {policy:?}, {shape:?}:\n{why}");
                }
            }
        }
    };
    // A scheduler for the largest workload file does not fit the stack that a test's thread gets.
    thread::scope(|scope| {
        let thread = thread::Builder::new().stack_size(64 << 20).spawn_scoped(scope, all);
        thread.expect("a thread for the test").join().unwrap_or_else(|panic| resume_unwind(panic));
    });
}

fn options(policy: Policy, horizon_ns: u64) -> Options {
    let named = Policy::ALL.iter().zip(red_workload::policy::Policy::ALL).find(|(ours, _)| **ours == policy);
    let (_, policy) = named.expect("both lists are in the paper's order");
    Options { policy, horizon_ns, seed: 1, execution: Execution::Wcet, preempt: false, schedule: true }
}

fn core(workload: &Workload, options: &Options) -> Report {
    simulate(workload, options).expect("a random workload fits")
}

/// What the test compares.
#[derive(Debug)]
struct Found {
    rows: Vec<Row>,
    sheds: Vec<ShedRow>,
    encoder_runs_saved: u64,
    units_dispatched: u64,
    busy_ns: Vec<u64>,
    /// Released, completed, on time, missed, shed of each task.
    tasks: Vec<[u64; 5]>,
}

fn outcome(report: Report) -> Found {
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
    Found {
        rows: rows.collect(),
        sheds,
        encoder_runs_saved: report.encoder_runs_saved,
        units_dispatched: report.units_dispatched,
        busy_ns: report.pools.iter().map(|pool| pool.busy_ns).collect(),
        tasks: report.tasks.iter().map(|t| [t.released, t.completed, t.on_time, t.missed, t.shed]).collect(),
    }
}

fn compare(found: &Found, expected: &Outcome) -> Result<(), String> {
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
