//! What holds for every input: of the formulas, of the queue, of the floors, and of whole runs.

mod calls;
mod floors;
mod graphs;
mod queue;
mod rules;
mod runs;

use proptest::test_runner::{Config, RngSeed};

/// So many cases, or `PROPTEST_CASES` of them, the same each time, or those of `PROPTEST_RNG_SEED`; a failure prints its input and leaves no file.
fn cases(count: u32) -> Config {
    let cases =
        std::env::var("PROPTEST_CASES").map_or(count, |asked| asked.parse().expect("a number of cases"));
    let config = Config::with_cases(cases);
    let rng_seed = if config.rng_seed == RngSeed::Random { RngSeed::Fixed(1) } else { config.rng_seed };
    Config { failure_persistence: None, rng_seed, ..config }
}
