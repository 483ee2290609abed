//! Runs steps one after another, and says how it went.

use std::io::Write;
use std::ops::Add;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use crate::depth::Depth;
use crate::process::Failure;
use crate::room;
use crate::steps::Step;
use crate::workspace::Workspace;

/// Tests by how they ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tally {
    pub(crate) passed: u32,
    pub(crate) failed: u32,
    pub(crate) ignored: u32,
}

impl Tally {
    /// Takes a line of a test program's output; only its last line says anything.
    pub(crate) fn read(&mut self, line: &str) {
        let Some(counts) = line.strip_prefix("test result: ") else { return };
        let words: Vec<&str> = counts.split_whitespace().collect();
        for pair in words.windows(2) {
            let count = || pair[0].parse::<u32>().unwrap_or(0);
            match pair[1] {
                "passed;" => self.passed += count(),
                "failed;" => self.failed += count(),
                "ignored;" => self.ignored += count(),
                _ => {}
            }
        }
    }

    /// How a step ended. One that reports no tests is a test itself, and so is a failure that no test reported.
    /// A test that was left out did not pass.
    fn of(outcome: &Result<Self, Failure>) -> Self {
        match outcome {
            Ok(Self { passed: 0, failed: 0, ignored: 0 }) => Self { passed: 1, ..Self::default() },
            Ok(tally) => Self { failed: tally.failed + tally.ignored, ..*tally },
            Err(Failure::Status { tally, .. }) => {
                Self { failed: (tally.failed + tally.ignored).max(1), ..*tally }
            }
            Err(_) => Self { failed: 1, ..Self::default() },
        }
    }
}

impl Add for Tally {
    type Output = Self;

    fn add(self, more: Self) -> Self {
        Self {
            passed: self.passed + more.passed,
            failed: self.failed + more.failed,
            ignored: self.ignored + more.ignored,
        }
    }
}

/// Runs `steps` in their order, all of them whatever happens. The last line counts all tests.
pub(crate) fn run(workspace: &Workspace, steps: &[Step], depth: Depth) -> ExitCode {
    let mut rows = Vec::new();
    for step in steps {
        say!("\n== {}: {}", step.name, step.what);
        let begin = Instant::now();
        let outcome = (step.run)(workspace, depth);
        let (tally, time) = (Tally::of(&outcome), begin.elapsed());
        let row = row(step.name, tally, time);
        if let Err(failure) = outcome {
            complain!("{}: {failure}", step.name);
        }
        let free = room::free_mib(workspace);
        let told = free.map_or(String::new(), |mib| format!("   {:.1} GiB free", mib as f64 / 1024.0));
        say!("-- {row}{told}");
        room::make(workspace, step.name, free);
        rows.push((row, tally));
    }
    let sum = |count: fn(&Tally) -> u32| rows.iter().map(|(_, tally)| count(tally)).sum::<u32>();
    let (passed, failed) = (sum(|tally| tally.passed), sum(|tally| tally.failed));
    say!("\n{:<10} {:<6} {:>6} {:>6} {:>8}", "step", "", "passed", "failed", "time");
    rows.iter().for_each(|(row, _)| say!("{row}"));
    say!("\n{passed} passed, {failed} failed");
    // A closed pipe must not turn the answer.
    let _ = std::io::stdout().flush();
    if failed == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

fn row(name: &str, tally: Tally, time: Duration) -> String {
    let word = if tally.failed == 0 { "ok" } else { "FAILED" };
    format!("{name:<10} {word:<6} {:>6} {:>6} {:>6.1} s", tally.passed, tally.failed, time.as_secs_f64())
}

#[cfg(test)]
mod tests;
