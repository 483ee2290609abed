//! The same random workloads on every target, and what they wrote, compared byte for byte.

use std::env::consts::ARCH;
use std::path::PathBuf;

use crate::cross::{self, AARCH64, CORTEX_M0, CORTEX_M4};
use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

const PROGRAM: &str = "red-traces";
/// How many workloads.
const QUICK: u32 = 100;
const DEEP: u32 = 1_000;
/// The run with a planted difference: a tie is broken the other way.
const PLANTED: &str = "10 last-lane-first";
/// Lines shown before a difference.
const CONTEXT: usize = 5;

/// Where workloads run; the first is what the others are compared with.
const TARGETS: [Target; 4] =
    [Target::Here, Target::Aarch64, Target::CortexM(CORTEX_M4), Target::CortexM(CORTEX_M0)];

#[derive(Clone, Copy)]
enum Target {
    Here,
    Aarch64,
    /// Code for this target on the emulated board: its Cortex-M4 runs that of a Cortex-M0 too.
    CortexM(&'static str),
}

/// A program for a target.
struct Built<'a> {
    workspace: &'a Workspace,
    target: Target,
    program: PathBuf,
}

/// The step: as many workloads as the depth says.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    compare(workspace, if depth == Depth::Deep { DEEP } else { QUICK })
}

/// What `cargo xtask traces` was asked for.
pub(crate) fn count(words: &[&str]) -> Option<u32> {
    match words {
        [] => Some(QUICK),
        ["--count", count] => count.parse().ok().filter(|count| *count > 0),
        _ => None,
    }
}

/// Writes the traces of `count` workloads on every target and compares them; then a planted difference has to be
/// found on each.
///
/// # Errors
/// A program cannot be built or run, or writes something else.
pub(crate) fn compare(workspace: &Workspace, count: u32) -> Result<Tally, Failure> {
    let mut tally = Tally::default();
    let [here, others @ ..] = TARGETS;
    let here = here.build(workspace)?;
    let (ours, few) = (here.run(&count.to_string())?, here.run("10")?);
    say!("{:<28} {count} workloads, {} lines, {} bytes", ARCH, ours.lines().count(), ours.len());
    for target in others {
        let built = target.build(workspace)?;
        let name = target.name();
        if let Some(difference) = first_difference(&ours, &built.run(&count.to_string())?) {
            return Err(Failure::Wrong(format!("{name} does something else:\n{difference}")));
        }
        say!("{name:<28} the same");
        let planted = first_difference(&few, &built.run(PLANTED)?)
            .ok_or_else(|| Failure::Wrong(format!("{name}: the planted difference is not found")))?;
        say!("{name:<28} with a tie broken the other way:\n{planted}");
        tally.passed += 2;
    }
    Ok(tally)
}

impl Target {
    fn name(self) -> &'static str {
        match self {
            Self::Here => ARCH,
            Self::Aarch64 => "aarch64 (qemu-user)",
            Self::CortexM(CORTEX_M4) => "Cortex-M4 (mps2-an386)",
            Self::CortexM(_) => "Cortex-M0 (on the same)",
        }
    }

    /// Builds the program as it would ship.
    fn build(self, workspace: &Workspace) -> Result<Built<'_>, Failure> {
        let build = ["build", "--quiet", "--release", "--package", PROGRAM];
        let (run, folder) = match self {
            Self::Here => (workspace.cargo(&build), ""),
            Self::Aarch64 => (cross::aarch64(workspace, &build)?, AARCH64),
            Self::CortexM(target) => {
                cross::library(workspace, target)?;
                (workspace.cargo(&build).args(&["--target", target]), target)
            }
        };
        run.stream()?;
        let program = workspace.target.join(folder).join("release").join(PROGRAM);
        Ok(Built { workspace, target: self, program })
    }
}

impl Built<'_> {
    /// What the program writes when it is given these words.
    fn run(&self, words: &str) -> Result<String, Failure> {
        let Self { workspace, target, program } = self;
        let list: Vec<&str> = words.split(' ').collect();
        let run = match target {
            Target::Here => workspace.command(program).args(&list),
            Target::Aarch64 => cross::qemu_aarch64(workspace)?.args(&[program]).args(&list),
            Target::CortexM(_) => {
                cross::cortex_m(workspace, program)?.args(&["-serial", "none", "-append", words])
            }
        };
        run.capture()
    }
}

/// The first line that is not the same, with those before it. `None`: there is none.
pub(crate) fn first_difference(ours: &str, theirs: &str) -> Option<String> {
    let (mut left, mut right, mut before) = (ours.lines(), theirs.lines(), Vec::new());
    loop {
        let (our, their) = (left.next(), right.next());
        if our != their {
            let from = before.len().saturating_sub(CONTEXT);
            let context: String = before[from..].iter().map(|line| format!("      {line}\n")).collect();
            let shown = |line: Option<&str>| line.unwrap_or("(nothing more)").to_owned();
            let number = before.len() + 1;
            return Some(format!("{context}here  {}\nthere {}\n(line {number})", shown(our), shown(their)));
        }
        before.push(our?);
    }
}

#[cfg(test)]
mod tests;
