//! The core in the simulator against the oracle, on random workloads under every policy: same rows, same sheds,
//! same counts.

use red_core as _;
use red_sim::{Execution, Options, simulate};
use red_tests::oracle::{self, Policy};
use red_tests::rng::{Shape, random_workload};
use red_workload::model::Workload;

/// Horizons are short because the oracle recomputes everything at every event.
const HORIZON_NS: u64 = 300_000_000;

fn ours(workload: &Workload, policy: Policy) -> (Vec<oracle::Row>, Vec<(u64, String, u64, &'static str)>, [u64; 2]) {
    let policy = red_workload::policy::Policy::ALL[Policy::ALL.iter().position(|p| *p == policy).unwrap()];
    let options = Options {
        policy,
        horizon_ns: HORIZON_NS,
        seed: 1,
        execution: Execution::Wcet,
        preempt: false,
        schedule: true,
    };
    let report = simulate(workload, &options).unwrap();
    let rows = report.schedule.unwrap().into_iter().map(|r| oracle::Row {
        start_ns: r.start_ns,
        pool: r.pool,
        lane: r.lane,
        task: r.task,
        job: r.job,
        node: r.node,
        finish_ns: r.finish_ns,
    });
    let mut sheds: Vec<_> =
        report.sheds.unwrap().into_iter().map(|s| (s.at_ns, s.task, s.job, s.reason)).collect();
    sheds.sort();
    (rows.collect(), sheds, [report.encoder_runs_saved, report.units_dispatched])
}

fn compare(seed: u64, shape: &Shape, policy: Policy) -> Result<(), String> {
    let workload = random_workload(seed, shape);
    let expected = oracle::simulate(&workload, policy, HORIZON_NS);
    let (rows, sheds, counts) = ours(&workload, policy);
    let first = rows.iter().zip(&expected.rows).position(|(a, b)| a != b);
    let theirs: Vec<_> = expected.sheds.iter().map(|s| (s.at_ns, s.task.clone(), s.job, s.reason.name())).collect();
    let shed = sheds.iter().zip(&theirs).find(|(a, b)| a != b);
    if let Some(i) = first {
        return Err(format!("seed {seed} {policy:?} row {i}:\n ours   {:?}\n oracle {:?}\n first shed that differs {shed:?}", rows[i], expected.rows[i]));
    }
    if rows.len() != expected.rows.len() || sheds != theirs {
        return Err(format!("seed {seed} {policy:?}: {} rows and {} sheds, expected {} and {}; {shed:?}", rows.len(), sheds.len(), expected.rows.len(), theirs.len()));
    }
    if counts != [expected.encoder_runs_saved, expected.units_dispatched] {
        return Err(format!("seed {seed} {policy:?}: saved, units {counts:?}, expected {:?}", [expected.encoder_runs_saved, expected.units_dispatched]));
    }
    Ok(())
}

fn shape() -> Shape { if std::env::var("NOMEM").is_ok() { Shape { memory: false, ..Shape::default() } } else { Shape::default() } }

#[test]
fn the_core_does_what_the_oracle_does() {
    let seeds = std::env::var("SEEDS").ok().and_then(|s| s.parse().ok()).unwrap_or(100);
    let mut failures = Vec::new();
    for seed in 0..seeds {
        for policy in Policy::ALL {
            if let Err(why) = compare(seed, &shape(), policy) {
                failures.push(why);
            }
        }
    }
    let total = failures.len();
    for f in failures.iter().take(12) {
        println!("{f}");
    }
    assert!(failures.is_empty(), "{total} of {}", seeds * 5);
}
