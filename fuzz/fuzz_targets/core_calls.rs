//! Any sequence of core calls, judged by `red_tests::calls`; now and then a host that keeps to the rules on a random
//! workload, compared with the oracle.
#![no_main]

use libfuzzer_sys::fuzz_target;
use red_tests::calls::{Call, Host, configurations};
use red_tests::differential::agree;
use red_tests::oracle::Policy;
use red_tests::rng::{Shape, random_workload};

/// Calls of one input: more reach nothing new, and cost time.
const CALLS: usize = 200;
/// The first byte of inputs that are seeds of workloads.
const SEED: u8 = u8::MAX;

fuzz_target!(|bytes: &[u8]| {
    match bytes {
        [SEED, policy, seed, ..] => obey(*policy, *seed, bytes.len() as u64),
        [config, calls @ ..] => disturb(*config, calls),
        [] => {}
    }
});

fn disturb(config: u8, calls: &[u8]) {
    let all = configurations();
    let host = Host::new(all[usize::from(config) % all.len()]);
    let mut host = if cfg!(feature = "planted") { host.with_planted_bug() } else { host };
    let mut bytes = calls.iter().copied();
    std::iter::from_fn(|| Call::read(&mut bytes)).take(CALLS).for_each(|call| host.call(call));
    host.finish();
}

fn obey(policy: u8, seed: u8, length: u64) {
    let shape = Shape { tasks: 3, nodes: 5, load_percent: (30, 250), ..Shape::default() };
    let workload = random_workload(u64::from(seed) << 16 | length, &shape);
    let policy = Policy::ALL[usize::from(policy) % Policy::ALL.len()];
    agree(&workload, policy, 20_000_000).unwrap_or_else(|why| panic!("{policy:?}: {why}"));
}
