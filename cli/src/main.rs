//! The command `redrt`: plan, simulate and run pipelines of neural networks with deadlines.
//!
//! Answers go to standard output, messages to standard error. Exit status: 0 done, 1 the answer is no, 2 bad
//! input or usage, 3 this machine cannot do that.

mod demo;
mod denied;
mod doctor;
mod executable;
mod given_up;
mod happened;
mod kept;
mod live;
mod options;
mod outcome;
mod output;
mod paper;
mod place;
mod plan;
mod profile;
mod progress;
mod regular;
mod replay;
mod report;
mod run;
mod session;
mod sim;
mod table;
mod terminal;
mod usage;
mod verify;

use clap::{Parser, Subcommand};
use outcome::{Answer, Failure};
use std::process::ExitCode;

/// Counts what lanes allocate outside of node bodies: nothing.
#[global_allocator]
static ALLOCATOR: red_rt::allocations::CountingAllocator = red_rt::allocations::CountingAllocator;

const AFTER_HELP: &str = "\
Without a subcommand, `redrt` is `redrt demo`.

Exit status: 0 done, 1 the answer is no, 2 bad input or usage, 3 this machine cannot do that.

Example:
  redrt plan examples/cruise.toml";

/// Real-time scheduling of neural-network pipelines on robots.
#[derive(Parser)]
#[command(name = "redrt", version, after_help = AFTER_HELP, args_conflicts_with_subcommands = true)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    demo: demo::Args,
}

#[derive(Subcommand)]
enum Command {
    Demo(demo::Args),
    Plan(plan::Args),
    Sim(sim::Args),
    Run(run::Args),
    Replay(replay::Args),
    Report(report::Args),
    Profile(profile::Args),
    Doctor(doctor::Args),
    Paper(paper::Args),
    Verify(verify::Args),
}

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage::report(error),
    };
    // Where this is forbidden, a log or a trace that grows too large ends the process: nothing else depends on it.
    let _as_before = red_rt::setup::file_size_limit_is_an_error();
    let result = match cli.command.unwrap_or(Command::Demo(cli.demo)) {
        Command::Demo(args) => demo::main(&args),
        Command::Plan(args) => plan::main(&args),
        Command::Sim(args) => sim::main(&args),
        Command::Run(args) => run::main(&args),
        Command::Replay(args) => replay::main(&args),
        Command::Report(args) => report::main(&args),
        Command::Profile(args) => profile::main(&args),
        Command::Doctor(args) => doctor::main(&args),
        Command::Paper(args) => paper::main(&args),
        Command::Verify(args) => verify::main(&args),
    };
    result.map_or_else(Failure::report, Answer::exit_code)
}
