//! How a model is explored, and what it tells of that.

use loom::model::Builder;
use std::env;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Preemptions of a model with more than two threads; `cargo xtask loom --deep` says 3.
const PREEMPTIONS: &str = "RED_LOOM_PREEMPTIONS";
const FEW: usize = 2;
/// A model that takes longer than so many seconds counts as not explored.
const SECONDS: &str = "RED_LOOM_SECONDS";
const LIMIT: usize = 120;
/// Steps of one execution: beyond that a loop does not end.
const BRANCHES: usize = 20_000;
/// Between two looks at the clock.
const EXECUTIONS: usize = 512;

/// Explores what `threads` threads may do, the first of which may be the one that starts the others: two in every
/// order, more with a bound on preemptions.
///
/// # Panics
/// Where the claim does not hold, and where the exploration did not come to its end.
pub fn explore(threads: usize, claim: impl Fn() + Sync + Send + 'static) {
    explore_within(threads, (threads > 2).then(|| asked(PREEMPTIONS).unwrap_or(FEW)), claim);
}

/// As [`explore`], within a bound of its own.
///
/// # Panics
/// As [`explore`].
pub fn explore_within(threads: usize, bound: Option<usize>, claim: impl Fn() + Sync + Send + 'static) {
    let mut builder = Builder::new();
    builder.preemption_bound = bound;
    builder.max_branches = BRANCHES;
    let limit = Duration::from_secs(asked(SECONDS).unwrap_or(LIMIT) as u64);
    builder.max_duration = Some(limit);
    builder.checkpoint_interval = EXECUTIONS;
    let executions = Arc::new(AtomicU64::new(0));
    let counted = executions.clone();
    let begin = Instant::now();
    builder.check(move || {
        counted.fetch_add(1, Ordering::Relaxed);
        claim();
    });
    let (took, thread) = (begin.elapsed(), std::thread::current());
    let bound = bound.map_or_else(|| "none".into(), |bound| bound.to_string());
    // The checker returns in silence when its time is up.
    let is_explored = took < limit;
    println!(
        "\nmodel {}: {threads} threads, bound {bound}, {} executions, {:.1} s, {}",
        thread.name().unwrap_or_default(),
        executions.load(Ordering::Relaxed),
        took.as_secs_f64(),
        if is_explored { "explored".into() } else { format!("NOT EXPLORED in {} s", limit.as_secs()) }
    );
    assert!(is_explored, "not explored in {} s", limit.as_secs());
}

fn asked(name: &str) -> Option<usize> {
    env::var(name).ok()?.parse().ok()
}
