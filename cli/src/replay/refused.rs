//! Logs that cannot be replayed.

use super::Compared;
use crate::outcome::Failure;
use crate::output;
use red_record::{Broken, LogError};
use red_workload::shown_path;
use serde::Serialize;
use std::fmt::Display;
use std::path::Path;

/// Why a log cannot be replayed, or not to its end.
#[derive(Serialize)]
pub(crate) struct Refused {
    /// The word that programs read.
    reason: &'static str,
    /// The sentence for people.
    message: String,
}

impl Refused {
    pub(crate) fn new(path: &Path, reason: &'static str, message: impl Display) -> Self {
        Self { reason, message: format!("`{}`: {message}", shown_path(path)) }
    }

    pub(crate) fn by(path: &Path, error: &LogError) -> Self {
        Self::new(path, error.name(), error)
    }

    /// After what comes before was fed.
    pub(crate) fn after(path: &Path, broken: &Broken) -> Self {
        Self::new(path, broken.error.name(), broken)
    }

    /// Says so: as JSON, if that was asked for, and to people.
    pub(crate) fn tell(self, json: bool, policy: Option<String>, broken: Option<&Broken>) -> Failure {
        let message = self.message.clone();
        let (inputs, actions) = broken.map_or((0, 0), |broken| (broken.inputs, broken.actions));
        let report = Compared {
            policy,
            inputs,
            actions,
            equal: None,
            difference: None,
            refused: Some(self),
            tasks: None,
        };
        if json && let Err(failure) = output::json(&report) {
            return failure;
        }
        Failure::Input(message)
    }
}
