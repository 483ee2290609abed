//! Any sequence of core calls, judged by `red_tests::calls`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use red_tests::calls::{Call, Host, configurations};

/// Calls of one input: more reach nothing new, and cost time.
const CALLS: usize = 200;

fuzz_target!(|bytes: &[u8]| {
    let Some((config, calls)) = bytes.split_first() else { return };
    let all = configurations();
    let host = Host::new(all[usize::from(*config) % all.len()]);
    let mut host = if cfg!(feature = "planted") { host.with_planted_bug() } else { host };
    let mut bytes = calls.iter().copied();
    std::iter::from_fn(|| Call::read(&mut bytes)).take(CALLS).for_each(|call| host.call(call));
    host.finish();
});
