//! Workload after workload, until the time is over, something is wrong, or a signal comes.

use crate::alarm::{Alarm, kill};
use crate::counts::{Count, Counts, ENOUGH};
use crate::episode::{Conditions, Plant, episode};
use crate::memory::{Memory, Verdict};
use crate::repeat::Repeat;
use crate::rights;
use crate::workload::Drawn;
use red_rt::setup::SetupError;
use red_rt::stop::StopSignals;
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process::{self, Command, Stdio};
use std::time::{Duration, Instant};

/// Between two lines of progress.
const PROGRESS: Duration = Duration::from_secs(60);
/// A workload has ended long before.
const STUCK: Duration = Duration::from_secs(300);
/// The same where it is stuck on purpose.
const STUCK_BY_PLANT: Duration = Duration::from_secs(2);
/// More workloads than there can be in an hour.
const ROOM: usize = 4_096;

/// What was asked for.
#[derive(Clone, Debug)]
pub(crate) struct Wish {
    pub(crate) time: Duration,
    pub(crate) workloads: Option<u64>,
    pub(crate) seed: u64,
    /// One workload, to see it again: nothing is said about the whole.
    pub(crate) repeats: bool,
    pub(crate) best_effort: bool,
    pub(crate) to: Conditions,
}

/// Why a soak is not clean.
pub(crate) enum Failure {
    /// The machine does not grant real time, and best effort was not asked for.
    Machine(SetupError),
    /// Something that must not be, in words of several lines.
    Wrong(String),
    /// Nothing, of too little to say more; the summary tells it.
    Short,
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
        let edits = to.plant != Some(Plant::Edits);
        let drawn = Drawn::of(seed, to.length.as_nanos() as u64, self.cpus, edits);
        if seed % 4 == 3 && !to.apart {
            self.total += self.apart(&drawn).map_err(Failure::Wrong)?;
            return Ok(());
        }
        let log = log(process::id(), seed);
        let repeat = || Repeat::of(&drawn, log.clone(), &self.words(seed));
        let (limit, is_stuck) = (self.limit(), repeat());
        let alarm = Alarm::set(limit, move || {
            let wrong = format!("it has not ended after {} s", limit.as_secs());
            println!("soak: VIOLATION: {}", is_stuck.told(&wrong));
            process::exit(1);
        });
        let (counts, _stopped) =
            episode(&drawn, to, &log).map_err(|wrong| Failure::Wrong(repeat().told(&wrong)))?;
        self.total += counts;
        drop(drawn);
        let _gone = fs::remove_file(log);
        drop(alarm);
        // Threads that died keep what they owned: it would count as left behind.
        if !to.apart {
            self.memory.look();
        }
        Ok(())
    }

    /// A workload whose threads die and whose process is halted: this program again.
    fn apart(&self, drawn: &Drawn) -> Result<Counts, String> {
        // By this name it is the same program even where its file was built anew meanwhile.
        let mut command = Command::new("/proc/self/exe");
        let words = self.words(drawn.seed);
        command.args(&words).arg("--apart").stdin(Stdio::null());
        let told = |e| format!("this program: {e}");
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(told)?;
        let process = child.id();
        // It has an alarm of its own, which comes first unless the process is halted.
        let alarm = Alarm::set(self.limit() * 2, move || kill(process));
        let output = child.wait_with_output().map_err(told)?;
        drop(alarm);
        let text = String::from_utf8_lossy(&output.stdout);
        if output.status.success() {
            return Ok(Counts::read(&text));
        }
        let rest = String::from_utf8_lossy(&output.stderr);
        let wrong = format!("in a process of its own, {}:\n{text}{rest}", output.status);
        // What ended with 1 told all of it itself.
        let is_told = output.status.code() == Some(1);
        let log = log(process, drawn.seed);
        Err(if is_told { wrong } else { Repeat::of(drawn, log, &words).told(&wrong) })
    }

    /// A workload has ended by then.
    fn limit(&self) -> Duration {
        if self.wish.to.plant == Some(Plant::Stuck) { STUCK_BY_PLANT } else { STUCK }
    }

    /// The arguments that repeat this workload.
    fn words(&self, seed: u64) -> Vec<String> {
        let Wish { to, best_effort, .. } = self.wish;
        let mut words = vec!["--repeat".to_owned(), seed.to_string()];
        words.extend(["--length-ms".to_owned(), to.length.as_millis().to_string()]);
        if let Some(plant) = to.plant {
            words.extend(["--plant".to_owned(), plant.name().to_owned()]);
        }
        words.extend(best_effort.then(|| "--best-effort".to_owned()));
        words.extend(to.apart.then(|| "--apart".to_owned()));
        words
    }

    /// The summary, and what only the whole shows.
    fn finish(self, stopped_by: Option<&str>) -> Result<(), Failure> {
        let seconds = self.begin.elapsed().as_secs();
        print!("soak: {seconds} s, seeds from {}\n{}", self.wish.seed, self.total);
        let verdict = self.memory.verdict();
        let is_short =
            self.total[Count::Workloads] < ENOUGH || verdict == Verdict::Unknown && !self.wish.to.apart;
        let grown = match verdict {
            Verdict::Unknown => {
                let why =
                    if self.wish.to.apart { "threads that died keep theirs" } else { "too few workloads" };
                println!("memory: not judged, {why}");
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
        let is_short = is_short && !self.wish.repeats;
        let word = match stopped_by {
            Some(signal) => format!("stopped by {signal}"),
            None if self.wish.repeats => format!("seed {} alone", self.wish.seed),
            None if is_short => "not clean".to_owned(),
            None => "clean".to_owned(),
        };
        let (all, realtime) = (self.total[Count::Workloads], self.total[Count::RealTime]);
        let mode = if self.cpus == 0 {
            "BEST EFFORT, not real time".to_owned()
        } else {
            format!("{realtime} of {all} workloads in real time")
        };
        let short = if is_short { ", but too short to judge" } else { "" };
        println!("soak: {word}: no violation, every log replayed without a difference{short}; {mode}");
        if is_short { Err(Failure::Short) } else { Ok(()) }
    }
}

fn log(process: u32, seed: u64) -> PathBuf {
    env::temp_dir().join(format!("red-soak-{process}-seed-{seed}.redlog"))
}
