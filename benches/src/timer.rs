//! Timed release at 1 kHz: how late a thread wakes, by cyclictest and by others at the same priority.

use std::io;
use std::process::Command;
use std::time::Duration;

use crate::machine::{Machine, PRIORITY};
use crate::measure::Row;
use crate::not_run::NotRun;

/// Period of the releases.
pub(crate) const PERIOD: Duration = Duration::from_millis(1);

/// How late the releases were, in nanoseconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Lateness {
    pub(crate) median: f64,
    pub(crate) p99: f64,
}

/// Something that wakes every [`PERIOD`] on lane 0 for the given time.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    pub(crate) ours: bool,
    pub(crate) measure: fn(&'static Machine, Duration) -> Result<Lateness, NotRun>,
}

/// The reference.
pub(crate) const CYCLICTEST: &str = "cyclictest";

/// Timers that are measured, one after the other: two at once would wait for each other.
pub(crate) const CONTESTANTS: &[Contestant] =
    &[Contestant { name: CYCLICTEST, ours: false, measure: cyclictest }];

/// Medians in the first list, 99th percentiles in the second.
pub(crate) fn measure(machine: &'static Machine, duration: Duration) -> (Vec<Row>, Vec<Row>) {
    let row = |contestant: &Contestant, figure: Result<f64, NotRun>| Row {
        name: contestant.name.to_owned(),
        ours: contestant.ours,
        rounds: figure.map(|figure| vec![figure]),
    };
    CONTESTANTS
        .iter()
        .map(|contestant| {
            let found = (contestant.measure)(machine, duration);
            let p99 = found.clone().map(|lateness| lateness.p99);
            (row(contestant, found.map(|lateness| lateness.median)), row(contestant, p99))
        })
        .unzip()
}

fn cyclictest(machine: &'static Machine, duration: Duration) -> Result<Lateness, NotRun> {
    let output = Command::new("cyclictest")
        .args(["--mlockall", "--quiet", "--threads=1", "--histogram=20000"])
        .arg(format!("--priority={PRIORITY}"))
        .arg(format!("--affinity={}", machine.lanes[0]))
        .arg(format!("--interval={}", PERIOD.as_micros()))
        .arg(format!("--duration={}", duration.as_secs()))
        .output()
        .map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => NotRun::Missing("rt-tests"),
            _ => NotRun::Failed(format!("cyclictest: {error}")),
        })?;
    parse(&String::from_utf8_lossy(&output.stdout)).ok_or_else(|| {
        let said = String::from_utf8_lossy(&output.stderr);
        NotRun::Failed(format!("cyclictest: {}", said.lines().next().unwrap_or("no histogram")))
    })
}

/// Reads the histogram of one thread: lines `microseconds count`, then `# Histogram Overflows: count`. A
/// percentile among the overflows is infinite: later than the histogram reaches.
fn parse(text: &str) -> Option<Lateness> {
    let buckets: Vec<(f64, u64)> = text.lines().filter_map(bucket).collect();
    let total: u64 = buckets.iter().map(|&(_, count)| count).sum();
    let percentile = |percent: u64| {
        let rank = (total * percent).div_ceil(100);
        let mut passed = 0;
        let found = buckets.iter().find(|&&(_, count)| {
            passed += count;
            passed >= rank
        });
        found.map(|&(microseconds, _)| microseconds * 1_000.0)
    };
    if total == 0 {
        return None;
    }
    Some(Lateness { median: percentile(50)?, p99: percentile(99)? })
}

fn bucket(line: &str) -> Option<(f64, u64)> {
    if let Some(count) = line.strip_prefix("# Histogram Overflows:") {
        return Some((f64::INFINITY, count.trim().parse().ok()?));
    }
    let (microseconds, count) = line.split_once(char::is_whitespace)?;
    Some((microseconds.parse().ok()?, count.trim().parse().ok()?))
}

#[cfg(test)]
mod tests;
