//! `cargo xtask soak`: random workloads, edits and faults on real threads, every event judged while it happens, every
//! run recorded and replayed, memory watched.

mod allocator;
mod bodies;
mod counts;
mod death;
mod episode;
mod judge;
mod memory;
mod replayed;
mod rights;
mod soak;
mod text;
mod workload;

use episode::{Conditions, Plant};
use soak::{Failure, Wish, soak};
use std::env;
use std::process::ExitCode;
use std::time::Duration;

#[global_allocator]
static ALLOCATOR: allocator::LiveBytes = allocator::LiveBytes;

const HELP: &str = "\
usage: cargo xtask soak [--minutes N | --seconds N | --workloads N] [--seed N] [--best-effort]
                        [--length-ms N] [--apart] [--plant FAULT]

Random workloads on real threads, 3 of 8 in real time. Their graphs are edited, tasks are removed, releases come in
bursts; bodies fail, panic and hang; one workload of 4 has a process of its own, in which lane threads die and which is
halted for a while. Every event is held against the workload's graphs while it happens; every run is recorded, and
replayed without a difference; the heap stays flat. A soak of 12 workloads or more in which something of that never
happened is not clean.

  --minutes N, --seconds N  how long; 1 minute unless told
  --workloads N             so many at most
  --seed N                  of the first workload, each has one more; 1 unless told
  --best-effort             go on without real-time rights
  --length-ms N             releases of a workload come for so long; 1500 unless told
  --apart                   threads die and the process is halted in every workload, in this process
  --plant FAULT             something wrong that has to be found: leak, start, replay, edits

example: cargo xtask soak --minutes 60

Exit status: 0 nothing was wrong, 1 something was (its seed is told, its log kept for `redrt replay`), 2 wrong arguments,
3 this machine does not grant real time. Ctrl-C ends it with its summary.";

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let wish = match wish(&words) {
        Ok(Some(wish)) => wish,
        Ok(None) => {
            println!("{HELP}");
            return ExitCode::SUCCESS;
        }
        Err(reason) => {
            eprintln!("soak: {reason}\n\n{HELP}");
            return ExitCode::from(2);
        }
    };
    match soak(&wish) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Wrong(wrong)) => {
            println!("soak: VIOLATION: {wrong}");
            ExitCode::FAILURE
        }
        Err(Failure::Machine(why)) => {
            let why = rights::told(&why);
            eprintln!("error: {why}; `--best-effort` runs without real time, labelled so");
            ExitCode::from(3)
        }
    }
}

/// `None`: help.
fn wish(words: &[String]) -> Result<Option<Wish>, String> {
    let to = Conditions { length: Duration::from_millis(1_500), apart: false, plant: None };
    let mut wish = Wish { time: Duration::from_secs(60), workloads: None, seed: 1, best_effort: false, to };
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        let mut number = || {
            let value = words.next().and_then(|value| value.parse::<u64>().ok());
            value.ok_or_else(|| format!("{word}: expected a whole number after it"))
        };
        match word {
            "--help" | "-h" => return Ok(None),
            "--minutes" => wish.time = Duration::from_secs(number()?.saturating_mul(60)),
            "--seconds" => wish.time = Duration::from_secs(number()?),
            "--workloads" => {
                wish.workloads = Some(number()?);
                wish.time = Duration::MAX;
            }
            "--seed" => wish.seed = number()?,
            "--best-effort" => wish.best_effort = true,
            "--length-ms" => wish.to.length = Duration::from_millis(number()?.max(10)),
            "--apart" => wish.to.apart = true,
            "--plant" => {
                let plant = words.next().and_then(Plant::named);
                wish.to.plant = Some(plant.ok_or("--plant: expected leak, start, replay or edits")?);
            }
            _ => return Err(format!("unknown option {word}")),
        }
    }
    Ok(Some(wish))
}

impl Plant {
    const ALL: [Self; 4] = [Self::Leak, Self::Start, Self::Replay, Self::Edits];

    /// As an argument has it.
    const fn name(self) -> &'static str {
        match self {
            Self::Leak => "leak",
            Self::Start => "start",
            Self::Replay => "replay",
            Self::Edits => "edits",
        }
    }

    fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|plant| plant.name() == name)
    }
}
