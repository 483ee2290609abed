//! CPUs that runs in real time of this process have to themselves.

use crate::per_process::PerProcess;
use crate::placement::{choose_cpus, usable_cpus};
use crate::setup::SetupError;
use std::collections::BTreeSet;
use std::sync::MutexGuard;

static HELD: PerProcess<BTreeSet<usize>> = PerProcess::new();
static CHOOSING: PerProcess<()> = PerProcess::new();

/// While it lives nobody else chooses: from before [`choose_free_cpus`] until a run has what was chosen.
#[derive(Debug)]
pub struct Choosing {
    _alone: MutexGuard<'static, ()>,
}

impl Choosing {
    /// Waits for others that choose.
    #[must_use]
    pub fn begin() -> Self {
        Self { _alone: CHOOSING.lock() }
    }
}

/// A CPU for each of `lanes` lanes, as [`choose_cpus`] chooses, of those that no other run of this process has.
///
/// # Errors
/// As [`choose_cpus`]; [`SetupError::CpusHeld`]: there would be enough if other runs did not have theirs.
pub fn choose_free_cpus(lanes: usize) -> Result<Vec<usize>, SetupError> {
    choose_free(lanes, &usable_cpus()?)
}

fn choose_free(lanes: usize, usable: &[usize]) -> Result<Vec<usize>, SetupError> {
    let (others, free): (Vec<usize>, Vec<usize>) = usable.iter().partition(|cpu| HELD.lock().contains(cpu));
    if (free.len() + 1..=usable.len()).contains(&lanes) {
        return Err(SetupError::CpusHeld { cpus: others });
    }
    choose_cpus(lanes, if lanes > usable.len() { usable } else { &free })
}

/// Keeps CPUs from other runs of this process until it is dropped.
#[derive(Debug)]
pub(crate) struct HeldCpus(Vec<usize>);

impl HeldCpus {
    /// # Errors
    /// [`SetupError::CpusHeld`]: another run has some of them, and keeps them.
    pub(crate) fn hold(cpus: &[usize]) -> Result<Self, SetupError> {
        let mut held = HELD.lock();
        let others: Vec<usize> = cpus.iter().filter(|cpu| held.contains(cpu)).copied().collect();
        if !others.is_empty() {
            return Err(SetupError::CpusHeld { cpus: others });
        }
        held.extend(cpus);
        Ok(Self(cpus.to_vec()))
    }
}

impl Drop for HeldCpus {
    fn drop(&mut self) {
        let mut held = HELD.lock();
        for cpu in &self.0 {
            held.remove(cpu);
        }
    }
}

#[cfg(test)]
mod tests;
