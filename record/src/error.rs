//! Why a log cannot be read.

use crate::header::FORMAT;
use crate::totals::{Cut, LARGEST};
use core::fmt;
use std::io;

/// A log is refused.
#[derive(Debug)]
#[non_exhaustive]
pub enum LogError {
    /// The file cannot be read.
    Read(io::Error),
    /// The file does not begin like a log.
    NotALog,
    /// A format from before this one.
    Older(u16),
    /// A format from after this one.
    Newer(u16),
    /// The file ends too early.
    Truncated {
        /// Where something was missing.
        at: u64,
    },
    /// What is written there is not what was recorded.
    Damaged {
        /// Where the damaged part begins.
        at: u64,
        /// Which part.
        what: &'static str,
    },
    /// Who recorded it did not come to close it.
    NotClosed,
    /// Inputs are missing at its end, and it says so.
    Incomplete {
        /// How many.
        dropped: u64,
        /// Why.
        cut: Cut,
    },
    /// It was closed, and its last entry is not the end of the run.
    Unended,
    /// The scheduler has other capacities.
    Capacities {
        /// Those of the log.
        found: [usize; 5],
        /// Those of this program.
        expected: [usize; 5],
    },
    /// What was set up is in a workload file, and not in the entries.
    NotByCalls,
}

/// A log cannot be begun.
#[derive(Debug)]
#[non_exhaustive]
pub enum StartError {
    /// The file cannot be created or written.
    File(io::Error),
    /// The system starts no thread for its writer.
    Thread(io::Error),
}

impl fmt::Display for StartError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(e) => e.fmt(f),
            Self::Thread(e) => write!(
                f,
                "no thread can be started that writes the log: {e}; raise the limit of processes (ulimit -u) or free memory"
            ),
        }
    }
}

impl std::error::Error for StartError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        let (Self::File(e) | Self::Thread(e)) = self;
        Some(e)
    }
}

impl From<StartError> for io::Error {
    fn from(error: StartError) -> Self {
        let (StartError::File(why) | StartError::Thread(why)) = error;
        why
    }
}

impl From<io::Error> for StartError {
    fn from(error: io::Error) -> Self {
        Self::File(error)
    }
}

impl LogError {
    /// The word that programs read.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Read(_) => "unreadable",
            Self::NotALog => "not-a-log",
            Self::Older(_) => "older",
            Self::Newer(_) => "newer",
            Self::Truncated { .. } => "truncated",
            Self::Damaged { .. } => "damaged",
            Self::NotClosed => "not-closed",
            Self::Incomplete { .. } => "incomplete",
            Self::Unended => "unended",
            Self::Capacities { .. } => "capacities",
            Self::NotByCalls => "not-by-calls",
        }
    }
}

impl Cut {
    /// What helps against it.
    #[must_use]
    pub const fn cure(self) -> &'static str {
        match self {
            Self::Slow => "record to a faster disk, or leave a CPU free",
            Self::Failed => "record to a disk that takes it and has room",
            Self::TooLarge => "record a shorter run",
            Self::Panicked => "report this defect with what was printed before, and record again",
        }
    }
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slow => f.write_str("the disk did not keep up"),
            Self::Failed => f.write_str("the file could not be written"),
            Self::Panicked => f.write_str("the thread that writes it panicked"),
            Self::TooLarge => {
                write!(f, "the file reached the size that it may have, {} GiB at most", LARGEST >> 30)
            }
        }
    }
}

impl fmt::Display for LogError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(e) if e.kind() == io::ErrorKind::NotFound => {
                write!(f, "there is no such file; check the path, or make a log with `redrt run --record`")
            }
            Self::Read(e) => write!(f, "cannot read it: {e}; expected a log that you may read, on a disk that works"),
            Self::NotALog => {
                f.write_str("it is no replay log; expected a file that `redrt run --record` wrote")
            }
            Self::Older(found) => write!(
                f,
                "it has format {found}, this program reads {FORMAT}; replay it with the version that recorded it"
            ),
            Self::Newer(found) => {
                write!(f, "it has format {found}, this program reads {FORMAT}; update the program")
            }
            Self::Truncated { at } => {
                write!(f, "it is truncated: something is missing at byte {at}; copy the whole file")
            }
            Self::Damaged { at, what } => {
                write!(f, "it is damaged: {what} at byte {at} is not as recorded; take another copy")
            }
            Self::NotClosed => f.write_str(
                "it was not closed: the recording program was killed, or still runs; record again, or wait for its end",
            ),
            Self::Incomplete { dropped: 0, cut } => {
                write!(f, "it cannot be replayed to the end: {cut}, so it may not be as recorded; {}", cut.cure())
            }
            Self::Incomplete { dropped, cut } => {
                write!(f, "it cannot be replayed to the end: {cut}, and the last {dropped} inputs are missing; ")?;
                f.write_str(cut.cure())
            }
            Self::Unended => f.write_str(
                "it does not have the end of the run: the recording program failed before; record again",
            ),
            Self::Capacities { found, expected } => write!(
                f,
                "it was recorded with other capacities (tasks, nodes, jobs, lanes, pools): {found:?}, this program has \
                 {expected:?}; replay it with the program that recorded it"
            ),
            Self::NotByCalls => f.write_str(
                "its scheduler was set up from a workload file, not by calls; replay it with `redrt replay`",
            ),
        }
    }
}

impl std::error::Error for LogError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Read(e) => Some(e),
            _ => None,
        }
    }
}
