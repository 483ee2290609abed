//! The tasks of this workspace: `cargo xtask --help`.

mod process;
mod report;
mod steps;
mod tools;
mod workspace;

use std::env;
use std::process::ExitCode;

use process::Failure;
use workspace::Workspace;

const HELP: &str = "\
Tasks of this workspace.

usage: cargo xtask TASK

  test [STEP]...    every test there is, quick things first; STEPs: only these
  bench [ARG]...    what the scheduler costs beside its peers, measured now; --help tells the ARGs
  models [--check]  writes the demo's networks; --check compares the committed ones with their generator

example: cargo xtask test fmt clippy

Exit status: 0 done, 1 something failed, 2 wrong arguments. Tools that are missing are installed where that
needs no question (into the target folder, by rustup, as root on Debian by apt-get), or named with the line that
installs them.";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let workspace = Workspace::here();
    match words[..] {
        ["--help" | "-h" | "help"] => {
            println!("{HELP}");
            ExitCode::SUCCESS
        }
        ["test", ref names @ ..] => match steps::choose(names) {
            Ok(chosen) => report::run(&workspace, &chosen),
            Err(reason) => refuse(&reason),
        },
        ["bench", ref rest @ ..] => {
            let bench = ["run", "--release", "-p", "red-benches", "--"];
            finish(workspace.cargo(&bench).args(rest).stream())
        }
        ["models", ref rest @ ..] if matches!(rest, [] | ["--check"]) => {
            finish(tools::python(&workspace).and_then(|python| python.generate(rest)))
        }
        [] => refuse("which task?"),
        ref other => refuse(&format!("unknown task: {}", other.join(" "))),
    }
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
