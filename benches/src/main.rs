//! What the scheduler costs beside its peers, measured in one run on this machine.
//!
//! Every table prints each contestant's figure, its ratio to the reference of the table, and for ours the bound
//! that the product is held to. Exit status: 0 all bounds kept, 1 one exceeded, 2 wrong arguments, 3 something
//! could not be measured that should have been.

mod companion;
mod count;
mod edit;
mod graphs;
mod growth;
mod handoff;
mod line;
mod machine;
mod measure;
mod not_run;
mod ours;
mod overload;
mod peers;
mod queue;
mod sections;
mod table;
mod timer;

use std::env;
use std::fs;
use std::process::ExitCode;

use machine::Machine;
use sections::{Bench, SECTIONS, Section};
use table::Outcome;

/// One text for the bench and for the task that builds it, which tells it without a build.
const HELP: &str = include_str!("../../xtask/src/bench.txt");

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [count::MODE, ..] = arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        return match count::run(&arguments[1..]) {
            Ok(()) => ExitCode::SUCCESS,
            Err(reason) => refuse(&reason, 2),
        };
    }
    if arguments.iter().any(|word| matches!(word.as_str(), "--help" | "-h")) {
        print!("{HELP}");
        return ExitCode::SUCCESS;
    }
    let (quick, chosen) = match parse(&arguments) {
        Ok(choice) => choice,
        Err(reason) => return refuse(&format!("{reason}\n\n{HELP}"), 2),
    };
    let machine: &'static Machine = match Machine::enter() {
        Ok(machine) => Box::leak(Box::new(machine)),
        Err(error) => return refuse(&format!("cannot pin this process to a CPU: {error}"), 3),
    };
    println!("{machine}");
    if let Ok(load) = fs::read_to_string("/proc/loadavg") {
        println!("load before: {}", load.trim());
    }
    println!("\n{}", table::LEGEND);
    let bench = Bench { machine, quick };
    let outcome: Outcome = chosen.iter().map(|(_, section)| section(&bench)).sum();
    let Outcome { above, missing, absent } = outcome;
    println!(
        "\n{above} above their bound, {missing} not measured, {absent} rows of peers that are not at hand"
    );
    match outcome {
        Outcome { missing: 1.., .. } => ExitCode::from(3),
        Outcome { above: 1.., .. } => ExitCode::from(1),
        Outcome { .. } => ExitCode::SUCCESS,
    }
}

fn refuse(reason: &str, status: u8) -> ExitCode {
    eprintln!("red-benches: {reason}");
    ExitCode::from(status)
}

/// Whether the run is a quick one, and its sections: all, unless some are named.
fn parse(arguments: &[String]) -> Result<(bool, Vec<Section>), String> {
    let (mut quick, mut chosen) = (false, Vec::new());
    let mut words = arguments.iter();
    while let Some(word) = words.next() {
        match word.as_str() {
            "--quick" => quick = true,
            "--section" => {
                let names = SECTIONS.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
                let name = words.next().ok_or_else(|| format!("--section wants one of {names}"))?;
                let section = SECTIONS.iter().find(|(section, _)| section == name);
                chosen.push(*section.ok_or_else(|| format!("no section {name:?}; there are {names}"))?);
            }
            other => return Err(format!("unexpected argument {other:?}")),
        }
    }
    if chosen.is_empty() {
        chosen.extend_from_slice(SECTIONS);
    }
    Ok((quick, chosen))
}

#[cfg(test)]
mod tests;
