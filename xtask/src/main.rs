//! The tasks of this workspace: `cargo xtask --help`.

mod depth;
mod fuzz;
mod miri;
mod mutants;
mod nightly;
mod process;
mod report;
mod sanitizers;
mod steps;
mod symbols;
mod tools;
mod workspace;

use std::env;
use std::process::ExitCode;

use depth::Depth;
use process::Failure;
use workspace::Workspace;

/// Of the bench, which has it too; here it needs no build.
const BENCH_HELP: &str = include_str!("bench.txt");

const HELP: &str = "\
Tasks of this workspace.

usage: cargo xtask TASK

  test [STEP]...    every test there is, quick things first; STEPs: only these, --help lists them; --deep: without
                    the bounds that keep them short
  fuzz [TARGET] [--executions N]    random inputs for the readers and the calls; default 1000000 each
  mutants [--sample N] [--seed S]   changes of the core that tests should notice; default 400 of them, seed 1
  bench [ARG]...    what the scheduler costs beside its peers, measured now; --help tells the ARGs
  models [--check]  writes the demo's networks; --check compares the committed ones with their generator

example: cargo xtask test fmt clippy

Exit status: 0 done, 1 something failed, 2 wrong arguments; that of the bench is in its own help. Tools that are
missing are installed where that needs no question (into the target folder, by rustup, as root on Debian by apt-get),
or named with the line that installs them.";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let workspace = Workspace::here();
    match words[..] {
        ["--help" | "-h" | "help"] => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        ["test", ref names @ ..] if asks_for_help(names) => {
            println!("{}", steps::help());
            ExitCode::SUCCESS
        }
        ["bench", ref rest @ ..] if asks_for_help(rest) => {
            print!("{BENCH_HELP}");
            ExitCode::SUCCESS
        }
        ["test", ref words @ ..] => {
            let (depth, names) = Depth::of(words);
            match steps::choose(&names) {
                Ok(chosen) => report::run(&workspace, &chosen, depth),
                Err(reason) => refuse(&reason),
            }
        }
        ["fuzz", ref rest @ ..] => match fuzz::Wish::of(rest) {
            Ok(wish) => finish(fuzz::run(&workspace, &wish)),
            Err(reason) => refuse(&reason),
        },
        ["mutants", ref rest @ ..] => match mutants::Wish::of(rest) {
            Ok(wish) => finish(mutants::run(&workspace, &wish)),
            Err(reason) => refuse(&reason),
        },
        ["bench", ref rest @ ..] => {
            let bench = ["run", "--release", "-p", "red-benches", "--"];
            match workspace.cargo(&bench).args(rest).stream() {
                // The bench has said why, and each status has its meaning.
                Err(Failure::Status { status, .. }) if matches!(status.code(), Some(1..=3)) => {
                    ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
                }
                result => finish(result),
            }
        }
        ["models", ref rest @ ..] if matches!(rest, [] | ["--check"]) => {
            finish(tools::python(&workspace).and_then(|python| python.generate(rest)))
        }
        [] => refuse("which task?"),
        ref other => refuse(&format!("unknown task: {}", other.join(" "))),
    }
}

fn asks_for_help(words: &[&str]) -> bool {
    words.iter().any(|word| matches!(*word, "--help" | "-h"))
}

fn refuse(reason: &str) -> ExitCode {
    eprintln!("xtask: {reason}\n\n{HELP}");
    ExitCode::from(2)
}

fn finish<T>(result: Result<T, Failure>) -> ExitCode {
    match result {
        Ok(_) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("xtask: {failure}");
            ExitCode::FAILURE
        }
    }
}
