//! The core in the simulator against the oracle, on random workloads under every policy: same rows, same sheds,
//! same counts. What they agree on is also judged by rules that hold for every schedule.
//!
//! `SEEDS=2000` looks at more workloads per test than the default.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use red_sim::{Execution, Options};
use red_tests::check::validate;
use red_tests::differential::{self, Found, core, options};
use red_tests::oracle::Policy;
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

/// A node that went before the waiting head was once still queued after its start.
#[test]
fn they_agree_where_one_goes_before_a_head_that_waits() {
    let shape = Shape { tasks: 5, nodes: 1, load_percent: (244, 294), ..Shape::default() };
    let workload = random_workload(59_248, &shape);
    differential::agree(&workload, Policy::RedrtLookahead, 20_000_000).unwrap_or_else(|why| panic!("{why}"));
}

#[test]
fn every_schedule_of_the_core_passes_the_judge() {
    each(100, &Shape::default(), |workload, policy, horizon_ns| {
        let found = Found::of(core(workload, &options(policy, horizon_ns)));
        validate(workload, policy, horizon_ns, &found.rows, &found.sheds)
    });
}

#[test]
fn lanes_wait_under_lookahead() {
    let (looked, waited) = (AtomicUsize::new(0), AtomicUsize::new(0));
    each(60, &Shape { memory: false, ..Shape::default() }, |workload, policy, horizon_ns| {
        if policy == Policy::RedrtLookahead {
            let rows = |policy| Found::of(core(workload, &options(policy, horizon_ns))).rows;
            let differs = rows(Policy::Redrt) != rows(policy);
            looked.fetch_add(1, Ordering::Relaxed);
            waited.fetch_add(differs.into(), Ordering::Relaxed);
        }
        Ok(())
    });
    // Else the comparison above says nothing of it.
    let (looked, waited) = (looked.into_inner(), waited.into_inner());
    assert!(6 * waited >= looked, "lanes waited in {waited} of {looked} workloads");
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
    each(seeds, shape, differential::agree);
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

#[test]
fn a_unit_of_several_encoders_is_expected_to_take_the_longest_of_them() {
    // A wake by the shortest would be an event that nothing explains, and find a job lost before its time.
    let shape = Shape { tasks: 3, nodes: 5, load_percent: (247, 297), ..Shape::default() };
    let workload = random_workload(0x25, &shape);
    differential::agree(&workload, Policy::RedrtLookahead, 20_000_000).unwrap_or_else(|why| panic!("{why}"));
}
