//! What runs in real time change of the process as a whole: all its memory is locked, and its allocator keeps what it has.
//!
//! *Rule.* The first of them that begins changes it, and the last that ends, or is refused, changes it back. A process that
//! had locked memory of its own before keeps both: what would be undone could be its own.

use crate::per_process::PerProcess;
use crate::setup::{self, SetupError};
use std::fs;

#[derive(Default)]
struct Runs {
    /// That have it so.
    count: usize,
    /// Nothing was locked before them.
    is_ours: bool,
}

// A child of `fork` has nothing locked.
static RUNS: PerProcess<Runs> = PerProcess::new();

/// Keeps the process so until it is dropped.
#[derive(Debug)]
pub(crate) struct HeldMemory(());

impl HeldMemory {
    /// # Errors
    /// As [`setup::lock_memory`] and [`setup::malloc_for_real_time`]; then nothing is changed.
    pub(crate) fn hold() -> Result<Self, SetupError> {
        let mut runs = RUNS.lock();
        if runs.count == 0 {
            runs.is_ours = has_none_locked();
            setup::lock_memory()?;
            if let Err(reason) = setup::malloc_for_real_time() {
                runs.undo();
                return Err(reason);
            }
        }
        runs.count += 1;
        Ok(Self(()))
    }
}

impl Drop for HeldMemory {
    fn drop(&mut self) {
        let mut runs = RUNS.lock();
        runs.count -= 1;
        if runs.count == 0 {
            runs.undo();
        }
    }
}

impl Runs {
    fn undo(&self) {
        if self.is_ours {
            setup::memory_by_default();
        }
    }
}

/// Whether the process has locked no memory, as far as it is told.
fn has_none_locked() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let locked = status.lines().find_map(|line| line.strip_prefix("VmLck:"));
    locked.is_some_and(|rest| rest.split_whitespace().next() == Some("0"))
}
