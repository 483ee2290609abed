//! The nightly toolchain, for what stable has not: the interpreter, sanitizers, fuzzers.

use std::path::PathBuf;
use std::process::ExitStatus;

use crate::process::{Failure, Run};
use crate::workspace::Workspace;

const NIGHTLY: &str = "nightly";

/// The target of what runs here; sanitizers want it named.
pub(crate) const HOST: &str = "x86_64-unknown-linux-gnu";

/// What a program said, its errors in their place, and how it ended.
pub(crate) struct Said {
    pub(crate) status: ExitStatus,
    pub(crate) text: String,
}

impl Said {
    /// # Errors
    /// It failed; what it said is shown.
    pub(crate) fn well(self, what: &str) -> Result<String, Failure> {
        if self.status.success() {
            return Ok(self.text);
        }
        Err(Failure::Wrong(format!("{what}: {}\n{}", self.status, self.last(60))))
    }

    /// That a planted bug was found: the program failed, and said these words.
    ///
    /// # Errors
    /// It did not.
    pub(crate) fn found(&self, what: &str, words: &str) -> Result<(), Failure> {
        let line = self.text.lines().find(|line| line.contains(words));
        match line {
            Some(line) if !self.status.success() => {
                say!("{what}: found, as it should be: {}", line.trim());
                Ok(())
            }
            _ => Err(Failure::Wrong(format!(
                "{what}: the planted bug is not found, so this check finds nothing\n{}",
                self.last(30)
            ))),
        }
    }

    pub(crate) fn last(&self, lines: usize) -> String {
        let all: Vec<_> = self.text.lines().collect();
        all[all.len().saturating_sub(lines)..].join("\n")
    }
}

/// The toolchain with some components.
pub(crate) struct Nightly<'a> {
    workspace: &'a Workspace,
}

impl<'a> Nightly<'a> {
    /// Installs what is missing of it.
    ///
    /// # Errors
    /// rustup is missing, or cannot get it.
    pub(crate) fn with(workspace: &'a Workspace, components: &[&str]) -> Result<Self, Failure> {
        let rustup = |arguments: &[&str]| match workspace.command("rustup").args(arguments).stream() {
            Err(Failure::Start { .. }) => Err(Failure::Missing {
                what: "rustup, which gets the nightly toolchain",
                install: "curl https://sh.rustup.rs -sSf | sh".to_owned(),
            }),
            other => other.map(drop),
        };
        let installed = ["component", "list", "--installed", "--toolchain", NIGHTLY];
        // One that is there stays as it is: a newer one is somebody's decision.
        let there = match workspace.command("rustup").args(&installed).output() {
            Ok(list) => list,
            Err(_) => {
                rustup(&["toolchain", "install", NIGHTLY, "--profile", "minimal", "--no-self-update"])?;
                String::new()
            }
        };
        for component in components.iter().filter(|component| !there.contains(**component)) {
            rustup(&["component", "add", component, "--toolchain", NIGHTLY])?;
        }
        // It moves: what was found was found with this one.
        say!("{}", workspace.command("rustup").args(&["run", NIGHTLY, "rustc", "--version"]).capture()?);
        Ok(Self { workspace })
    }

    /// Its cargo; subcommands are found in the folder of tools too.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Run {
        // Both streams in one, in their order.
        let script = "PATH=\"$1:$PATH\" && shift && exec \"$@\" 2>&1";
        let run = self.workspace.command("sh").args(&["-c", script, "sh"]).args(&[self.target("tools/bin")]);
        run.args(&["rustup", "run", NIGHTLY, "cargo"]).args(arguments)
    }

    /// Where its own libraries are, for this machine.
    ///
    /// # Errors
    /// It cannot be asked.
    pub(crate) fn libraries(&self) -> Result<PathBuf, Failure> {
        let ask = ["run", NIGHTLY, "rustc", "--print", "target-libdir"];
        self.workspace.command("rustup").args(&ask).capture().map(PathBuf::from)
    }

    /// Where what is built with these flags lies: apart, or each set would have the others' built anew.
    pub(crate) fn target(&self, name: &str) -> PathBuf {
        self.workspace.target.join(name)
    }
}

/// Runs it in silence.
///
/// # Errors
/// It cannot be started.
pub(crate) fn hear(run: Run) -> Result<Said, Failure> {
    hear_with(run, |_| {})
}

/// As [`hear`], but who called it is told each line when it comes.
///
/// # Errors
/// As [`hear`].
pub(crate) fn hear_with(run: Run, mut told: impl FnMut(&str)) -> Result<Said, Failure> {
    let mut text = String::new();
    let status = run.observe(|line| {
        told(line);
        text.push_str(line);
        text.push('\n');
    })?;
    Ok(Said { status, text })
}
