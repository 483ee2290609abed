//! Runs of one test file, one after the other.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// One run at a time: where real-time rights are there, the lanes of two would keep the CPU from each other.
pub(crate) fn alone() -> MutexGuard<'static, ()> {
    static RUN: Mutex<()> = Mutex::new(());
    RUN.lock().unwrap_or_else(PoisonError::into_inner)
}
