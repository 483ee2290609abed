//! What runs in real time change of the process as a whole: all its memory is locked, and its allocator keeps what it has.
//!
//! *Rule.* The first of them that begins changes it, and the last that ends, or is refused, changes it back. A process that
//! had locked memory of its own before keeps both: what would be undone could be its own.

use crate::setup::{self, SetupError};
use std::fs;
use std::sync::{Mutex, PoisonError};

/// Runs that have it so, and whether they found it otherwise.
static RUNS: Mutex<(usize, bool)> = Mutex::new((0, false));

/// Keeps the process so until it is dropped.
#[derive(Debug)]
pub(crate) struct HeldMemory(());

impl HeldMemory {
    /// # Errors
    /// As [`setup::malloc_for_real_time`] and [`setup::lock_memory`]; then nothing is changed.
    pub(crate) fn hold() -> Result<Self, SetupError> {
        let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, is_ours) = &mut *runs;
        if *count == 0 {
            *is_ours = has_none_locked();
            setup::malloc_for_real_time()?;
            if let Err(reason) = setup::lock_memory() {
                if *is_ours {
                    setup::memory_by_default();
                }
                return Err(reason);
            }
        }
        *count += 1;
        Ok(Self(()))
    }
}

impl Drop for HeldMemory {
    fn drop(&mut self) {
        let mut runs = RUNS.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, is_ours) = &mut *runs;
        *count -= 1;
        if *count == 0 && *is_ours {
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
