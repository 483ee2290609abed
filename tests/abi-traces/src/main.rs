//! Random workloads as text, and the traces that the core's own calls make of them.
//!
//! `red-abi-traces workloads COUNT` writes the workloads of the first `COUNT` seeds, one after another;
//! `red-abi-traces traces COUNT` runs them on `red_core::Scheduler` and writes what it answered to every call. Whoever
//! drives the scheduler through the C ABI reads the first and has to write the second, byte for byte: the program in
//! `ffi/tests/trace` does.

mod asks;
mod events;
mod host;
mod script;
mod text;
mod words;

use std::env;
use std::io::{self, BufWriter, Write};
use std::process::ExitCode;

use script::{Class, Script};

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let asked = match &words[..] {
        [what, count] => count.parse().ok().zip(task(what)),
        _ => None,
    };
    let Some((count, write)) = asked else {
        eprintln!("usage: red-abi-traces workloads|traces COUNT");
        return ExitCode::from(2);
    };
    let mut out = BufWriter::new(io::stdout().lock());
    let written = (0..count).try_for_each(|seed| write(&Script::draw(seed), &mut out));
    if written.and_then(|()| out.flush()).is_ok() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

type Task = fn(&Script, &mut dyn Write) -> io::Result<()>;

fn task(name: &str) -> Option<Task> {
    match name {
        "workloads" => Some(text::write),
        "traces" => Some(run),
        _ => None,
    }
}

/// The classes of the C ABI.
fn run(script: &Script, out: &mut dyn Write) -> io::Result<()> {
    use red_core::Caps;
    match script.class {
        Class::Small => host::run::<Caps<4, 16, 16, 4, 2, 1, 64>>(script, out),
        Class::Medium => host::run::<Caps<8, 64, 32, 8, 4, 1, 256>>(script, out),
        Class::Large => host::run::<Caps<16, 256, 64, 32, 32, 4, 1024>>(script, out),
    }
}

#[cfg(test)]
mod tests;
