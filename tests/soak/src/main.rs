//! `cargo xtask soak`: random workloads, edits and faults on real threads, every event judged while it happens, every
//! run recorded and replayed, memory watched.

mod episode;
mod judge;

use episode::{Done, episode};
use std::env;
use std::fs;
use std::process::ExitCode;
use std::time::{Duration, Instant};

const HELP: &str = "\
usage: cargo xtask soak [--minutes N | --seconds N] [--seed N]

Random workloads, edits and faults on real threads. Every event is held against the workload's graphs while it
happens; every run is recorded, and replayed without a difference; the memory of the process stays flat. Real time
where the machine grants it, in about a third of the episodes.

example: cargo xtask soak --minutes 60

Exit status: 0 nothing was wrong, 1 something was (its seed is told, its log kept), 2 wrong arguments.";

/// Episodes before the memory counts as grown in.
const WARM_UP: u64 = 8;
/// What the memory may grow by afterwards: what allocators keep for later.
const FLAT_KIB: u64 = 16 * 1024;

struct Arguments {
    time: Duration,
    seed: u64,
}

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    match arguments(&words) {
        Ok(Some(arguments)) => soak(&arguments),
        Ok(None) => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        Err(reason) => {
            eprintln!("soak: {reason}\n\n{HELP}");
            ExitCode::from(2)
        }
    }
}

fn arguments(words: &[String]) -> Result<Option<Arguments>, String> {
    let mut found = Arguments { time: Duration::from_secs(60), seed: 1 };
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        if matches!(word, "--help" | "-h") {
            return Ok(None);
        }
        let value = words.next().and_then(|value| value.parse::<u64>().ok());
        let value = value.ok_or_else(|| format!("{word}: expected a whole number after it"))?;
        match word {
            "--minutes" => found.time = Duration::from_secs(value.saturating_mul(60)),
            "--seconds" => found.time = Duration::from_secs(value),
            "--seed" => found.seed = value,
            _ => return Err(format!("unknown option {word}")),
        }
    }
    Ok(Some(found))
}

fn soak(arguments: &Arguments) -> ExitCode {
    let begin = Instant::now();
    let log = env::temp_dir().join(format!("red-soak-{}.redlog", std::process::id()));
    let (mut total, mut realtime) = (Done::default(), 0);
    let (mut warm, mut most) = (0, 0);
    let mut episodes = 0;
    while begin.elapsed() < arguments.time && !total.stopped {
        let seed = arguments.seed + episodes;
        let done = match episode(seed, &log) {
            Ok(done) => done,
            Err(wrong) => {
                println!("\nsoak: seed {seed}: {wrong}\nits log: {}", log.display());
                return ExitCode::FAILURE;
            }
        };
        episodes += 1;
        add(&mut total, &done);
        realtime += u64::from(done.realtime);
        let resident = resident_kib();
        if episodes == WARM_UP {
            warm = resident;
        }
        most = most.max(resident);
        if episodes > WARM_UP && resident > warm + FLAT_KIB {
            println!("\nsoak: seed {seed}: memory has grown from {warm} to {resident} KiB");
            return ExitCode::FAILURE;
        }
        if episodes.is_multiple_of(10) {
            println!("{}", line(begin, episodes, realtime, &total, resident));
        }
    }
    let _gone = fs::remove_file(&log);
    let word = if total.stopped { "stopped" } else { "clean" };
    println!("{}", line(begin, episodes, realtime, &total, most));
    println!("soak: {word}: no violation, every log replayed without a difference, memory flat");
    ExitCode::SUCCESS
}

fn add(total: &mut Done, done: &Done) {
    total.seen.jobs += done.seen.jobs;
    total.seen.given_up += done.seen.given_up;
    total.seen.sub_jobs += done.seen.sub_jobs;
    total.seen.hits += done.seen.hits;
    total.seen.edits += done.seen.edits;
    total.units += done.units;
    total.faults += done.faults;
    total.inputs += done.inputs;
    total.stopped |= done.stopped;
}

fn line(begin: Instant, episodes: u64, realtime: u64, total: &Done, resident_kib: u64) -> String {
    let seen = &total.seen;
    format!(
        "{:>5} s  {episodes} workloads ({realtime} in real time), {} jobs ({} given up), {} sub-jobs, {} hits, {} edits, \
         {} faults of bodies, {} inputs replayed, {} MiB",
        begin.elapsed().as_secs(),
        seen.jobs,
        seen.given_up,
        seen.sub_jobs,
        seen.hits,
        seen.edits,
        total.faults,
        total.inputs,
        resident_kib / 1024
    )
}

/// Memory of this process that is in use, in KiB.
fn resident_kib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
