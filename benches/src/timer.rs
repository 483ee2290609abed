//! Timed release at 1 kHz: how late cyclictest wakes, and how late a body of ours starts, at the same priority on
//! the same CPU.

mod red;

use std::io;
use std::process::Command;
use std::time::{Duration, Instant};

use crate::machine::{Machine, PRIORITY, cpu_time};
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

impl Lateness {
    /// Of exact samples; `None` without any.
    fn of(samples: &[u64]) -> Option<Self> {
        let mut sorted = samples.to_vec();
        sorted.sort_unstable();
        let percentile = |percent: usize| {
            let rank = (sorted.len() * percent).div_ceil(100);
            Some(*sorted.get(rank.checked_sub(1)?)? as f64)
        };
        Some(Self { median: percentile(50)?, p99: percentile(99)? })
    }
}

/// Something that is released every [`PERIOD`] on lane 0 for the given time.
#[derive(Clone, Copy)]
pub(crate) struct Contestant {
    pub(crate) name: &'static str,
    pub(crate) ours: bool,
    pub(crate) measure: fn(&'static Machine, Duration) -> Result<Lateness, NotRun>,
}

/// The reference.
pub(crate) const CYCLICTEST: &str = "cyclictest";

/// Timers that are measured.
pub(crate) const CONTESTANTS: &[Contestant] = &[
    Contestant { name: CYCLICTEST, ours: false, measure: cyclictest },
    Contestant { name: "RED", ours: true, measure: red::measure },
];

/// What is told of a contestant, a table each.
pub(crate) struct Rows {
    pub(crate) medians: Vec<Row>,
    pub(crate) p99s: Vec<Row>,
    /// Processor time of all threads of the contestant, per cent of the time that passed.
    pub(crate) cpu: Vec<Row>,
}

/// Measures all contestants by turns, so many each: two at once would wait for each other.
pub(crate) fn measure(machine: &'static Machine, turns: usize, duration: Duration) -> Rows {
    let empty = || CONTESTANTS.iter().map(Row::of).collect::<Vec<_>>();
    let mut rows = Rows { medians: empty(), p99s: empty(), cpu: empty() };
    for _ in 0..turns {
        for (place, contestant) in CONTESTANTS.iter().enumerate() {
            let (start, cpu_before) = (Instant::now(), cpu_time());
            let found = (contestant.measure)(machine, duration);
            let cpu = (cpu_time() - cpu_before).as_secs_f64() / start.elapsed().as_secs_f64();
            rows.medians[place].add(found.clone().map(|lateness| lateness.median));
            rows.p99s[place].add(found.clone().map(|lateness| lateness.p99));
            rows.cpu[place].add(found.map(|_| 100.0 * cpu));
        }
    }
    rows
}

impl Row {
    fn of(contestant: &Contestant) -> Self {
        Self { name: contestant.name.to_owned(), ours: contestant.ours, rounds: Ok(Vec::new()) }
    }

    /// Takes in the figure of a turn. A turn without one leaves the row without any.
    fn add(&mut self, figure: Result<f64, NotRun>) {
        match (&mut self.rounds, figure) {
            (Ok(figures), Ok(figure)) => figures.push(figure),
            (Ok(_), Err(reason)) => self.rounds = Err(reason),
            (Err(_), _) => {}
        }
    }
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
