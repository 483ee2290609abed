//! Workload after workload, until the time is over, something is wrong, or a signal comes.

use crate::counts::{Count, Counts};
use crate::episode::{Conditions, Plant, episode};
use crate::memory::{Memory, Verdict};
use crate::rights;
use crate::workload::Drawn;
use red_rt::setup::SetupError;
use red_rt::stop::StopSignals;
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::{self, Command};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(60);
/// A workload has ended long before.
const STUCK: Duration = Duration::from_secs(300);
/// More workloads than there can be in an hour.
const ROOM: usize = 4_096;

/// What was asked for.
#[derive(Clone, Debug)]
pub(crate) struct Wish {
    pub(crate) time: Duration,
    pub(crate) workloads: Option<u64>,
    pub(crate) seed: u64,
    pub(crate) best_effort: bool,
    pub(crate) to: Conditions,
}

/// Why a soak is not clean.
pub(crate) enum Failure {
    /// The machine does not grant real time, and best effort was not asked for.
    Machine(SetupError),
    /// Something that must not be, in words of several lines.
    Wrong(String),
}

/// A soak that goes on.
struct Soak<'a> {
    wish: &'a Wish,
    /// CPUs for lanes in real time.
    cpus: usize,
    begin: Instant,
    total: Counts,
    memory: Memory,
}

/// Runs it to its end and prints its summary.
pub(crate) fn soak(wish: &Wish) -> Result<(), Failure> {
    // Held to the end, so that no Ctrl-C costs the summary.
    let signals = StopSignals::install().map_err(Failure::Machine)?;
    let cpus = match rights::granted() {
        Ok(cpus) => cpus,
        Err(why) if wish.best_effort => {
            println!("soak: BEST EFFORT, not real time: {}", rights::told(&why));
            0
        }
        Err(why) => return Err(Failure::Machine(why)),
    };
    let (begin, memory) = (Instant::now(), Memory::with_room(ROOM));
    let mut soak = Soak { wish, cpus, begin, total: Counts::default(), memory };
    let mut told = begin;
    let mut stopped_by = None;
    let mut seed = wish.seed;
    while stopped_by.is_none() && begin.elapsed() < wish.time && wish.workloads != Some(seed - wish.seed) {
        soak.workload(seed)?;
        stopped_by = signals.requested();
        seed += 1;
        if told.elapsed() >= PROGRESS {
            told = Instant::now();
            println!("{:>6} s  {}", begin.elapsed().as_secs(), soak.total.line());
        }
    }
    soak.finish(stopped_by.map(|signal| signal.as_str()))
}

impl Soak<'_> {
    /// One workload: here, or in a process of its own.
    fn workload(&mut self, seed: u64) -> Result<(), Failure> {
        let to = self.wish.to;
        if seed % 4 == 3 && !to.apart {
            self.total += self.apart(seed).map_err(Failure::Wrong)?;
            return Ok(());
        }
        let alarm = alarm(seed);
        let edits = to.plant != Some(Plant::Edits);
        let log = self.log(seed);
        let drawn = Drawn::of(seed, to.length.as_nanos() as u64, self.cpus, edits);
        let (counts, _stopped) = episode(&drawn, to, &log).map_err(|wrong| {
            let lanes: u32 = drawn.workload.pools.iter().map(|pool| pool.lanes).sum();
            let mode = if drawn.realtime { "real time" } else { "best effort" };
            let replay = if log.exists() {
                format!("\nits log: redrt replay {}", log.display())
            } else {
                String::new()
            };
            Failure::Wrong(format!(
                "seed {seed} (policy {}, lanes: {lanes}, {mode}): {wrong}{replay}\nagain: {}",
                drawn.policy,
                self.again(seed)
            ))
        })?;
        self.total += counts;
        drop(drawn);
        let _gone = fs::remove_file(log);
        drop(alarm);
        self.memory.look();
        Ok(())
    }

    /// A workload whose threads die and whose process is halted: this program again.
    fn apart(&self, seed: u64) -> Result<Counts, String> {
        // By this name it is the same program even where its file was built anew meanwhile.
        let mut command = Command::new("/proc/self/exe");
        command.args(self.words(seed)).arg("--apart");
        let output = command.output().map_err(|e| format!("this program: {e}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        if output.status.success() {
            return Ok(Counts::read(&text));
        }
        let told = String::from_utf8_lossy(&output.stderr);
        Err(format!("in a process of its own, {}:\n{text}{told}", output.status))
    }

    /// The arguments that repeat this workload.
    fn words(&self, seed: u64) -> Vec<String> {
        let Wish { to, best_effort, .. } = self.wish;
        let mut words = vec!["--workloads".to_owned(), "1".to_owned(), "--seed".to_owned(), seed.to_string()];
        words.extend(["--length-ms".to_owned(), to.length.as_millis().to_string()]);
        if let Some(plant) = to.plant {
            words.extend(["--plant".to_owned(), plant.name().to_owned()]);
        }
        words.extend(best_effort.then(|| "--best-effort".to_owned()));
        words.extend(to.apart.then(|| "--apart".to_owned()));
        words
    }

    fn again(&self, seed: u64) -> String {
        format!("cargo xtask soak {}", self.words(seed).join(" "))
    }

    fn log(&self, seed: u64) -> PathBuf {
        env::temp_dir().join(format!("red-soak-{}-seed-{seed}.redlog", process::id()))
    }

    /// The summary, and what only the whole shows.
    fn finish(self, stopped_by: Option<&str>) -> Result<(), Failure> {
        let seconds = self.begin.elapsed().as_secs();
        print!("soak: {seconds} s, seeds from {}\n{}", self.wish.seed, self.total);
        let grown = match self.memory.verdict() {
            Verdict::Unknown => {
                println!("memory: not judged, too few workloads");
                None
            }
            Verdict::Flat(growth) => {
                println!("memory: {growth}");
                None
            }
            Verdict::Grows(growth) => Some(format!("memory grows: {growth}")),
        };
        let missing = self.total.missing(self.cpus > 0);
        let untried = (!missing.is_empty()).then(|| format!("it never happened: {}", missing.join("; ")));
        if let Some(wrong) = grown.or(untried) {
            return Err(Failure::Wrong(wrong));
        }
        let word = stopped_by.map_or_else(|| "clean".to_owned(), |signal| format!("stopped by {signal}"));
        let (all, realtime) = (self.total[Count::Workloads], self.total[Count::RealTime]);
        let mode = if self.cpus == 0 {
            "BEST EFFORT, not real time".to_owned()
        } else {
            format!("{realtime} of {all} workloads in real time")
        };
        println!("soak: {word}: no violation, every log replayed without a difference; {mode}");
        Ok(())
    }
}

/// Ends the process if this is not dropped in time: threads that wait for each other tell nobody.
fn alarm(seed: u64) -> Sender<()> {
    let (held, is_held) = channel();
    thread::spawn(move || {
        if is_held.recv_timeout(STUCK) == Err(RecvTimeoutError::Timeout) {
            println!("soak: VIOLATION: seed {seed} has not ended after {} s", STUCK.as_secs());
            process::exit(1);
        }
    });
    held
}
