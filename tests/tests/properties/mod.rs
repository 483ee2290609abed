//! What holds for every input: of the formulas, of the queue, of the floors, and of whole runs.

mod calls;
mod floors;
mod graphs;
mod queue;
mod rules;
mod runs;

use proptest::test_runner::Config;

/// So many cases, or `PROPTEST_CASES` of them; a failure prints its input and leaves no file.
fn cases(count: u32) -> Config {
    let cases =
        std::env::var("PROPTEST_CASES").map_or(count, |asked| asked.parse().expect("a number of cases"));
    Config { failure_persistence: None, ..Config::with_cases(cases) }
}
