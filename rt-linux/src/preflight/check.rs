//! The constant part of a check, and the checks that are one setting in one file.

use super::tree::{Tree, Unreadable};
use super::{Finding, Severity};

/// What is known of a check before it is made.
pub(super) struct Check {
    pub(super) id: &'static str,
    pub(super) why: &'static str,
    pub(super) fix: &'static str,
}

impl Check {
    pub(super) fn finding(&self, severity: Severity, value: impl Into<String>) -> Finding {
        Finding { id: self.id, severity, value: value.into(), why: self.why, fix: self.fix.into() }
    }

    pub(super) fn pass(&self, value: impl Into<String>) -> Finding {
        self.finding(Severity::Pass, value)
    }

    pub(super) fn warn(&self, value: impl Into<String>) -> Finding {
        self.finding(Severity::Warn, value)
    }

    pub(super) fn fail(&self, value: impl Into<String>) -> Finding {
        self.finding(Severity::Fail, value)
    }

    pub(super) fn pass_if(&self, good: bool, value: impl Into<String>) -> Finding {
        self.finding(if good { Severity::Pass } else { Severity::Warn }, value)
    }

    /// The finding of `judge`, or that there was nothing to judge.
    pub(super) fn on<T>(&self, read: Result<T, Unreadable>, judge: impl FnOnce(T) -> Finding) -> Finding {
        read.map_or_else(|unreadable| self.warn(unreadable.to_string()), judge)
    }
}

/// A check of one file against one condition.
pub(super) struct Setting {
    pub(super) check: Check,
    pub(super) path: &'static str,
    pub(super) good: fn(&str) -> bool,
    /// What it means that the file does not exist, where that is as good as the right value.
    pub(super) absent: Option<&'static str>,
}

impl Setting {
    pub(super) fn examine(&self, tree: &Tree<'_>) -> Finding {
        match (tree.read(self.path), self.absent) {
            (Err(Unreadable { absent: true, .. }), Some(meaning)) => self.check.pass(meaning),
            (read, _) => self.check.on(read, |text| {
                let good = (self.good)(&text);
                self.check.pass_if(good, if text.is_empty() { "none".into() } else { text })
            }),
        }
    }
}
