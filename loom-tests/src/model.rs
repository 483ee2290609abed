//! How a model is explored, and what it tells of that.

use loom::model::Builder;
use nix::time::{ClockId, clock_gettime};
use std::env;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Preemptions of a model with more than two threads; `cargo xtask loom --deep` says 3.
const PREEMPTIONS: &str = "RED_LOOM_PREEMPTIONS";
const FEW: u64 = 2;
/// A model that takes longer than so many seconds of its processor counts as not explored: how busy the machine is must
/// not decide.
const SECONDS: &str = "RED_LOOM_SECONDS";
const LIMIT: u64 = 120;
/// Steps of one execution: beyond that a loop does not end.
const BRANCHES: usize = 20_000;
/// Between two looks at the clock.
const EXECUTIONS: u64 = 512;

/// Explores what `threads` threads may do, the first of which may be the one that starts the others: two in every
/// order, more with a bound on preemptions.
///
/// # Panics
/// Where the claim does not hold, and where the exploration did not come to its end.
pub fn explore(threads: usize, claim: impl Fn() + Sync + Send + 'static) {
    explore_within(threads, (threads > 2).then(|| asked(PREEMPTIONS).unwrap_or(FEW) as usize), claim);
}

/// As [`explore`], within a bound of its own.
///
/// # Panics
/// As [`explore`].
pub fn explore_within(threads: usize, bound: Option<usize>, claim: impl Fn() + Sync + Send + 'static) {
    let mut builder = Builder::new();
    builder.preemption_bound = bound;
    builder.max_branches = BRANCHES;
    let limit = asked(SECONDS).unwrap_or(LIMIT);
    let bound = bound.map_or_else(|| "none".into(), |bound| bound.to_string());
    let (executions, begin) = (Arc::new(AtomicU64::new(0)), cpu_time());
    let tell = {
        let executions = executions.clone();
        move |end: &str| {
            let (thread, took) = (std::thread::current(), cpu_time() - begin);
            println!(
                "\nmodel {}: {threads} threads, bound {bound}, {} executions, {:.1} s, {end}",
                thread.name().unwrap_or_default(),
                executions.load(Ordering::Relaxed),
                took.as_secs_f64(),
            );
        }
    };
    let give_up = tell.clone();
    builder.check(move || {
        let so_far = executions.fetch_add(1, Ordering::Relaxed);
        if so_far % EXECUTIONS == 0 && (cpu_time() - begin).as_secs() >= limit {
            give_up(&format!("NOT EXPLORED in {limit} s of its processor; RED_LOOM_SECONDS=N gives it more"));
            panic!("not explored in {limit} s");
        }
        claim();
    });
    tell("explored");
}

/// What this process, which runs one model, has taken of its processor.
fn cpu_time() -> Duration {
    // A limit on a clock that stands still would never be reached.
    clock_gettime(ClockId::CLOCK_PROCESS_CPUTIME_ID).expect("Linux has this clock").into()
}

fn asked(name: &str) -> Option<u64> {
    env::var(name).ok()?.parse().ok()
}
