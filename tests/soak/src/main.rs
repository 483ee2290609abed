//! `cargo xtask soak`: random workloads, edits and faults on real threads, every event judged while it happens, every
//! run recorded and replayed, memory watched.

mod alarm;
mod allocator;
mod bodies;
mod counts;
mod death;
mod episode;
mod figures;
mod judge;
mod memory;
mod repeat;
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
                        [--length-ms N] [--apart] [--repeat SEED] [--plant FAULT]

Random workloads on real threads, 3 of 8 in real time. Their graphs are edited, tasks are removed, releases come in
bursts; bodies fail, panic and hang; one workload of 4 has a process of its own, in which lane threads die and which is
halted for a while. Every event is held against the workload's graphs while it happens; every run is recorded, and
replayed without a difference; the heap stays flat. A soak in which something of that never happened is not clean, nor is
one of less than 12 workloads, or of so few that nothing can be said about the heap: less than 21.

  --minutes N, --seconds N  how long; 1 minute unless told
  --workloads N             so many at most
  --seed N                  of the first workload, each has one more; 1 unless told
  --best-effort             go on without real-time rights
  --length-ms N             releases of a workload come for so long; 1500 unless told
  --apart                   threads die and the process is halted in every workload, in this process, whose heap is
                            not judged then
  --repeat SEED             the workload of this seed alone
  --plant FAULT             something wrong that has to be found: leak, start, replay, edits, stuck

example: cargo xtask soak --minutes 60

Exit status: 0 nothing was wrong, 1 something was (its seed is told, its log kept for `redrt replay`) or too little was
tried to say so, 2 wrong arguments, 3 this machine does not grant real time. Ctrl-C ends it with its summary.";

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
        Err(Failure::Short) => ExitCode::FAILURE,
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
    let mut wish = Wish {
        time: Duration::from_secs(60),
        workloads: None,
        seed: 1,
        repeats: false,
        best_effort: false,
        to,
    };
    let mut words = words.iter().map(String::as_str);
    while let Some(word) = words.next() {
        let mut number = || {
            let value = words.next().and_then(|value| value.parse::<u64>().ok());
            value.ok_or_else(|| format!("{word}: expected a whole number after it"))
        };
        let some = |number: u64| if number > 0 { Ok(number) } else { Err(format!("{word}: 0 is no soak")) };
        match word {
            "--help" | "-h" => return Ok(None),
            "--minutes" => wish.time = Duration::from_secs(some(number()?)?.saturating_mul(60)),
            "--seconds" => wish.time = Duration::from_secs(some(number()?)?),
            "--workloads" => {
                wish.workloads = Some(some(number()?)?);
                wish.time = Duration::MAX;
            }
            "--repeat" => {
                wish.seed = number()?;
                (wish.workloads, wish.time, wish.repeats) = (Some(1), Duration::MAX, true);
            }
            "--seed" => wish.seed = number()?,
            "--best-effort" => wish.best_effort = true,
            "--length-ms" => wish.to.length = Duration::from_millis(number()?.max(10)),
            "--apart" => wish.to.apart = true,
            "--plant" => {
                let plant = words.next().and_then(Plant::named);
                wish.to.plant = Some(plant.ok_or("--plant: expected leak, start, replay, edits or stuck")?);
            }
            _ => return Err(format!("unknown option {word}")),
        }
    }
    Ok(Some(wish))
}

impl Plant {
    const ALL: [Self; 5] = [Self::Leak, Self::Start, Self::Replay, Self::Edits, Self::Stuck];

    /// As an argument has it.
    const fn name(self) -> &'static str {
        match self {
            Self::Leak => "leak",
            Self::Start => "start",
            Self::Replay => "replay",
            Self::Edits => "edits",
            Self::Stuck => "stuck",
        }
    }

    fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|plant| plant.name() == name)
    }
}
