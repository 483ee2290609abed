//! Why a machine does not do what a run in real time needs, in words.

use crate::session::PRIORITY;
use red_rt::preflight::{Finding, group_without_budget};
use red_rt::setup::SetupError;
use std::fmt;
use std::path::Path;

/// A step that did not succeed, and what the kernel does not say of it.
#[derive(Debug)]
pub(crate) struct Denied {
    error: SetupError,
    /// The control group that forbids what the right would allow.
    group: Option<Box<Finding>>,
}

impl Denied {
    /// On the machine whose files are below `root`.
    fn on(root: &Path, error: SetupError) -> Self {
        let group = group_without_budget(root, &error, PRIORITY).map(Box::new);
        Self { error, group }
    }
}

impl From<SetupError> for Denied {
    fn from(error: SetupError) -> Self {
        Self::on(Path::new("/"), error)
    }
}

impl fmt::Display for Denied {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { error, group } = self;
        let (SetupError::NotPermitted { call, errno, .. }, Some(group)) = (error, group) else {
            return error.fmt(f);
        };
        write!(
            f,
            "{call}: {} ({errno:?}), although the right to it is there: the control group has no real-time budget ({}); fix: {}",
            errno.desc(),
            group.value,
            group.fix
        )
    }
}

#[cfg(test)]
mod tests;
