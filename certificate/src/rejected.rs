//! Why a certificate proves nothing.

use std::error::Error;
use std::fmt::{self, Display, Formatter};

/// What of a certificate does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rejected {
    /// The set is none that anything is proved of; whoever made it has to mend it.
    Set {
        /// Where.
        place: String,
        /// What is wrong.
        wrong: &'static str,
    },
    /// The certificate states something else than follows from the set: it is of another one, was changed, or was made
    /// wrongly. Make it anew of this set.
    Statement {
        /// Where.
        place: String,
        /// What follows from the set.
        expected: String,
        /// What the certificate says.
        stated: String,
    },
    /// A test is named whose assumptions are not met; whoever made the certificate erred.
    Test {
        /// Of which graph of which task.
        place: String,
        /// Name of the test.
        test: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// An inequality does not hold: the response time that is stated is not proved. Whoever made the certificate erred.
    Inequality {
        /// Of which graph of which task, and which inequality.
        place: String,
        /// Work that the lanes would have done, in nanoseconds; it has to be more than there is.
        done: i128,
        /// Work that there is at most, in nanoseconds.
        there_is: i128,
    },
}

impl Display for Rejected {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::Set { place, wrong } => {
                write!(f, "{place}: the workload has {wrong}; nothing can be proved until it is mended")
            }
            Self::Statement { place, expected, stated } => write!(
                f,
                "{place}: expected {expected}, the certificate says {stated}; it is of another workload or was changed: make it \
                 anew"
            ),
            Self::Test { place, test, needs } => write!(
                f,
                "{place}: {test} needs {needs}; the certificate names a test that does not apply: make it anew"
            ),
            Self::Inequality { place, done, there_is } => write!(
                f,
                "{place}: expected more than {there_is}, the certificate's numbers give {done}; the response time is not \
                 proved: make it anew"
            ),
        }
    }
}

impl Error for Rejected {}
