//! How a subcommand ends: with an answer, or with a failure that names its cure.

use crate::executable;
use crate::output;
use red_sim::SimError;
use red_workload::LoadError;
use red_workload::build::BuildError;
use std::fmt::Display;
use std::process::ExitCode;

/// A question that was answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// Done, or yes.
    Yes,
    /// No: it does not fit, a check failed, a deadline was missed under `--strict`.
    No,
}

impl Answer {
    /// Yes if `holds`.
    pub(crate) const fn of(holds: bool) -> Self {
        if holds { Self::Yes } else { Self::No }
    }

    pub(crate) fn exit_code(self) -> ExitCode {
        ExitCode::from(match self {
            Self::Yes => 0,
            Self::No => 1,
        })
    }
}

/// Nothing was answered.
#[derive(Debug)]
pub(crate) enum Failure {
    /// What the user gave cannot be used.
    Input(String),
    /// This machine cannot do it.
    Machine(String),
}

impl Failure {
    pub(crate) fn input(error: impl Display) -> Self {
        Self::Input(error.to_string())
    }

    /// Tells the user, on standard error.
    pub(crate) fn report(self) -> ExitCode {
        let (message, code) = match self {
            Self::Input(message) => (message, 2),
            Self::Machine(message) => (executable::named_in(&message), 3),
        };
        output::note(&format!("error: {message}"));
        ExitCode::from(code)
    }
}

impl From<LoadError> for Failure {
    fn from(error: LoadError) -> Self {
        Self::input(error)
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        Self::input(error)
    }
}

impl From<SimError> for Failure {
    fn from(error: SimError) -> Self {
        Self::input(error)
    }
}
