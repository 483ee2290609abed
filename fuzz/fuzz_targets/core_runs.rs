//! Hosts that keep to the rules, on workloads drawn from the bytes: the core against the oracle.
#![no_main]

mod keys;

use libfuzzer_sys::fuzz_target;
use red_tests::differential::{Found, compare, core, options};
use red_tests::oracle::Policy;
use red_tests::rng::{Shape, random_workload};

const HORIZON_NS: u64 = 20_000_000;

fuzz_target!(|bytes: [u8; 6]| {
    let [policy, tasks, nodes, load, low, high] = bytes;
    let percent = u64::from(load) + 20;
    let shape = Shape {
        tasks: u64::from(tasks % 6) + 1,
        nodes: u64::from(nodes % 6) + 1,
        load_percent: (percent, percent + 50),
        ..Shape::default()
    };
    let workload = random_workload(u64::from(u16::from_le_bytes([low, high])), &shape);
    let mut expected = workload.clone();
    // A lane that one of the two does not have.
    expected.pools[0].lanes += u32::from(cfg!(feature = "planted"));
    let policy = Policy::ALL[usize::from(policy) % Policy::ALL.len()];
    let found = Found::of(core(&workload, &options(policy, HORIZON_NS)));
    compare(&found, &expected, policy, HORIZON_NS).unwrap_or_else(|why| panic!("{policy:?}: {why}"));
});
