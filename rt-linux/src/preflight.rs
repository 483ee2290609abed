//! The findings of `redrt doctor`: what this machine does to real time, why it matters, and the cure.
//!
//! [`examine`] reads settings and changes nothing; [`measure`] runs a real-time thread for a moment; `device` (feature
//! `cuda`) opens the first CUDA device. Every check gives a finding on every machine: what does not apply passes and
//! says so, what cannot be read warns and says so.

mod check;
mod cpu;
#[cfg(feature = "cuda")]
mod device;
mod gpu;
mod interrupts;
mod kernel;
mod measure;
mod memory;
mod network;
mod rights;
mod tree;

use core::fmt;
use std::path::Path;

#[cfg(feature = "cuda")]
pub use device::device;
pub use measure::measure;

use crate::setup::SetupError;
use tree::Tree;

/// How bad a finding is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// As it should be, or not applicable here.
    Pass,
    /// The runtime works, with later or less predictable wake-ups; or the check could not be made.
    Warn,
    /// The runtime refuses to run in real time.
    Fail,
}

/// The outcome of one check.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Which check, as `area.name`. The same in every version.
    pub id: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// What was found.
    pub value: String,
    /// Why it matters to a pipeline with deadlines.
    pub why: &'static str,
    /// What to do if it is not as it should be, as a command where there is one.
    pub fix: String,
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { id, severity, value, why, fix } = self;
        match severity {
            Severity::Pass => write!(f, "PASS {id}: {value}"),
            Severity::Warn => write!(f, "WARN {id}: {value}; {why}; fix: {fix}"),
            Severity::Fail => write!(f, "FAIL {id}: {value}; {why}; fix: {fix}"),
        }
    }
}

/// All checks that only read. `root` is the root of the file system, `/` but for tests.
#[must_use]
pub fn examine(root: &Path) -> Vec<Finding> {
    let tree = Tree::new(root);
    let areas: [fn(&Tree<'_>) -> Vec<Finding>; 7] = [
        kernel::examine,
        cpu::examine,
        interrupts::examine,
        rights::examine,
        memory::examine,
        gpu::examine,
        network::examine,
    ];
    areas.iter().flat_map(|area| area(&tree)).collect()
}

/// Whether the kernel is PREEMPT_RT; on another, no latency has a bound. `root` as for [`examine`].
#[must_use]
pub fn is_preempt_rt(root: &Path) -> bool {
    kernel::is_preempt_rt(&Tree::new(root))
}

/// The finding on the control group, where that is why a thread was refused `priority`: the right to it is there, and the group
/// has no real-time budget. The kernel says the same as for a missing right. `None`: the error has another cause. `root` as
/// for [`examine`].
#[must_use]
pub fn group_without_budget(root: &Path, error: &SetupError, priority: u8) -> Option<Finding> {
    let asked = matches!(error, SetupError::NotPermitted { call: "sched_setscheduler(SCHED_FIFO)", .. });
    if asked { rights::group_without_budget(&Tree::new(root), priority) } else { None }
}

/// How long the real-time threads of this process may run on a CPU in each period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct RealTimeBudget {
    /// Who has run so long stands still until the period is over.
    pub(crate) runtime_ns: u64,
    /// The period.
    pub(crate) period_ns: u64,
}

impl RealTimeBudget {
    /// The kernel's, or that of the control group where it is less; `None` where the kernel does not limit them. `root` as
    /// for [`examine`].
    pub(crate) fn of_process(root: &Path) -> Option<Self> {
        rights::real_time_budget(&Tree::new(root))
    }
}

#[cfg(test)]
mod tests;
