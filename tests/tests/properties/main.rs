//! What holds for every input: of the formulas, of the queue, of the floors, and of whole runs.

mod calls;
mod floors;
mod graphs;
mod queue;
mod rules;
mod runs;

use proptest::test_runner::Config;

/// So many cases; a failure prints its input and leaves no file.
fn cases(count: u32) -> Config {
    Config { failure_persistence: None, ..Config::with_cases(count) }
}
