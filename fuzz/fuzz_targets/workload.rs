//! Any bytes as a workload file, in both notations: refused with a short message, or a workload that can be planned and
//! simulated.
#![no_main]

mod keys;

use libfuzzer_sys::fuzz_target;
use red_sim::{Execution, Options, simulate};
use red_workload::model::{Arrival, Workload};
use red_workload::policy::Policy;
use red_workload::{Format, parse};

/// Longest message that a user is shown; planted, one that some messages exceed.
const LONGEST_MESSAGE: usize = if cfg!(feature = "planted") { 100 } else { 2_000 };
/// Releases of one task: periods may be as short as a nanosecond.
const RELEASES: u64 = 50;

fuzz_target!(|bytes: &[u8]| {
    for format in [Format::Toml, Format::Yaml] {
        match parse(bytes, format, "fuzz") {
            Ok(workload) => run(&workload),
            Err(refusal) => {
                let message = refusal.to_string();
                assert!(
                    message.chars().count() <= LONGEST_MESSAGE,
                    "a message of {} characters",
                    message.chars().count()
                );
            }
        }
    }
});

fn run(workload: &Workload) {
    let gap = |arrival: Arrival| match arrival {
        Arrival::Periodic { period_ns: gap } | Arrival::Sporadic { min_interarrival_ns: gap } => gap,
        Arrival::Once => u64::MAX,
    };
    let shortest = workload.tasks.iter().map(|task| gap(task.arrival)).min().unwrap_or(u64::MAX);
    let horizon_ns = shortest.saturating_mul(RELEASES).min(1_000_000);
    let policy = Policy::NAMED[workload.tasks.len() % Policy::NAMED.len()];
    let options =
        Options { policy, horizon_ns, seed: 1, execution: Execution::Wcet, preempt: false, schedule: false };
    let report = simulate(workload, &options).expect("what is read can be run");
    assert_eq!(report.tasks.len(), workload.tasks.len());
}
