//! Why a row has no figures, and what would give it some.

use std::fmt;

/// A contestant that could not be measured.
#[derive(Debug, Clone)]
pub(crate) enum NotRun {
    /// A tool or library of the distribution is missing; names its package. Fails the bench.
    Missing(&'static str),
    /// Something that the distribution does not package; says how to provide it. Does not fail the bench.
    Unpackaged(&'static str),
    /// It started and broke off. Fails the bench.
    Failed(String),
}

impl NotRun {
    /// The thread of the other lane stopped answering.
    pub(crate) fn lane_gone() -> Self {
        Self::Failed("the other lane did not answer".to_owned())
    }

    /// Whether the bench as a whole has failed by this.
    pub(crate) fn fails(&self) -> bool {
        !matches!(self, Self::Unpackaged(_))
    }
}

impl fmt::Display for NotRun {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(package) => write!(out, "not run: install with apt-get install {package}"),
            Self::Unpackaged(cure) => write!(out, "not run: {cure}"),
            Self::Failed(reason) => write!(out, "not run: {reason}"),
        }
    }
}
