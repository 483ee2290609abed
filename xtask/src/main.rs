//! The tasks of this workspace: `cargo xtask --help`.

/// Prints a line. A reader who has seen enough, `| head`, ends no task.
macro_rules! say {
    ($($words:tt)*) => {
        // What is printed in a test is the test's, and not among the results that a step counts.
        if cfg!(test) {
            println!($($words)*);
        } else {
            use std::io::Write as _;
            let _or_closed = writeln!(std::io::stdout(), $($words)*);
        }
    };
}

/// [`say`] where errors go.
macro_rules! complain {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _or_closed = writeln!(std::io::stderr(), $($words)*);
    }};
}

mod aarch64;
mod abi;
mod abi_traces;
mod bench;
mod clients;
mod copy;
mod cortex_m;
mod cross;
mod cuda;
mod depth;
mod faults;
mod fuzz;
mod kept;
mod lock_files;
mod loom;
mod loom_mutants;
mod miri;
mod mutants;
mod nightly;
mod paper;
mod preempt_rt;
mod process;
mod report;
mod room;
mod sanitizers;
mod steps;
mod symbols;
mod tools;
mod traces;
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
  faults            the fault table: each row's test is run, and the table printed
  traces [--count N]
                    the same random workloads on every target, compared byte for byte; 100 unless told
  abi-traces [--count N]
                    the same random workloads by an executor in C++ over the C ABI, compared byte for byte; 1000
                    unless told
  fuzz [TARGET] [--executions N]
                    random inputs for the readers and the calls; 1000000 each unless told
  fuzz TARGET --input FILE [--planted BUG]
                    one input again
  mutants [--sample N] [--seed S] [--file PART]...
                    changes of the core that tests should notice; 400 of them and seed 1 unless told
  bench [ARG]...    what the scheduler costs beside its peers, measured now; --help tells the ARGs
  soak [ARG]...     random workloads, edits and faults on real threads; --help tells the ARGs
  gpu [CHECK]...    what only a CUDA device can show, on this machine's; --help lists the CHECKs
  loom [--deep] [MODEL]...
                    explores the models of concurrency; --deep: three preemptions instead of two
  loom --mutants [FILE]...
                    weakens every memory ordering once, each of which a model has to catch
  header [--check]  writes the C header and the table in its manual; --check compares the committed ones
  install --prefix P [--target T]
                    headers, libraries, and files for CMake and pkg-config below P; T without an operating system:
                    red.h and the core; --binutils BEGIN: what the names of T's linker and the like begin with
  paper [--check]   writes docs/paper.md, the tables of `redrt paper`; --check compares the committed one
  scoreboard [ARG]...
                    policies beside each other on random workloads: `redrt paper scoreboard`, with its ARGs
  models [--check]  writes the demo's networks; --check compares the committed ones with their generator

example: cargo xtask test fmt clippy

Exit status: 0 done, 1 something failed, 2 wrong arguments; those of bench, soak and gpu are in their own help. Tools
that are missing are installed where that needs no question (into the target folder, by rustup, as root on Debian by
apt-get), or named with the line that installs them.";

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let workspace = Workspace::here();
    match words[..] {
        ["help"] => tell(HELP),
        ["test", ref names @ ..] if asks_for_help(names) => tell(&steps::help()),
        ["bench", ref rest @ ..] if asks_for_help(rest) => tell(BENCH_HELP.trim_end()),
        // These have a help of their own.
        ["soak", ref rest @ ..] => {
            finish::<()>(steps::soak(&workspace, rest).and_then(|soak| Err(soak.replace())))
        }
        ["gpu", ref rest @ ..] => finish::<()>(Err(cuda::on_device(&workspace, rest))),
        ref words if asks_for_help(words) => tell(HELP),
        ["test", ref words @ ..] => {
            let (depth, names) = Depth::of(words);
            match steps::choose(&names) {
                Ok(chosen) => report::run(&workspace, &chosen, depth),
                Err(reason) => refuse(&reason),
            }
        }
        ["traces", ref rest @ ..] => match traces::count(rest) {
            Some(count) => finish(traces::compare(&workspace, count)),
            None => refuse("traces takes nothing, or --count N"),
        },
        ["abi-traces", ref rest @ ..] => match abi_traces::count(rest) {
            Some(count) => finish(abi_traces::compare(&workspace, count)),
            None => refuse("abi-traces takes nothing, or --count N"),
        },
        ["fuzz", ref rest @ ..] => match fuzz::Wish::of(rest) {
            Ok(wish) => finish(fuzz::run(&workspace, &wish)),
            Err(reason) => refuse(&reason),
        },
        ["mutants", ref rest @ ..] => match mutants::Wish::of(rest) {
            Ok(wish) => finish(mutants::run(&workspace, &wish)),
            Err(reason) => refuse(&reason),
        },
        ["bench", ref rest @ ..] => match bench::run(&workspace, rest) {
            // The bench has said why, and each status has its meaning.
            Err(Failure::Status { status, .. }) if matches!(status.code(), Some(1..=3)) => {
                ExitCode::from(status.code().and_then(|code| u8::try_from(code).ok()).unwrap_or(1))
            }
            result => finish(result),
        },
        ["faults"] => finish(faults::run(&workspace)),
        ["loom", ref words @ ..] => match loom::Wish::of(words) {
            Ok(wish) if wish.mutants => status(loom_mutants::run(&workspace, &wish.names)),
            Ok(wish) => status(loom::run(&workspace, wish.deep, &wish.names)),
            Err(reason) => refuse(&reason),
        },
        ["paper"] => finish(paper::run(&workspace, false)),
        ["paper", "--check"] => finish(paper::run(&workspace, true)),
        ["scoreboard", ref rest @ ..] => finish(paper::scoreboard(&workspace, rest)),
        ["header"] => finish(abi::header(&workspace, false)),
        ["header", "--check"] => finish(abi::header(&workspace, true)),
        ["install", ref rest @ ..] => match abi::Wish::of(rest) {
            Ok(wish) => finish(abi::install(&workspace, &wish)),
            Err(reason) => refuse(&reason),
        },
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

fn tell(text: &str) -> ExitCode {
    say!("{text}");
    ExitCode::SUCCESS
}

fn refuse(reason: &str) -> ExitCode {
    complain!("xtask: {reason}\n\n{HELP}");
    ExitCode::from(2)
}

fn status(result: Result<ExitCode, Failure>) -> ExitCode {
    result.unwrap_or_else(|failure| finish::<()>(Err(failure)))
}

fn finish<T>(result: Result<T, Failure>) -> ExitCode {
    match result {
        Ok(_) => ExitCode::SUCCESS,
        Err(failure) => {
            complain!("xtask: {failure}");
            ExitCode::FAILURE
        }
    }
}
