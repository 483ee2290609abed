#![allow(unsafe_code, reason = "what is leaked lives for ever")]
//! What each process has of its own. A child of `fork` begins with a new one: the parent's is of the parent's runs, and may
//! be locked by a thread that the child has not.

use std::process;
use std::ptr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A value for each process, the default one at first.
pub(crate) struct PerProcess<T: 'static>(AtomicPtr<Own<T>>);

struct Own<T> {
    pid: u32,
    value: Mutex<T>,
}

impl<T: Default> PerProcess<T> {
    pub(crate) const fn new() -> Self {
        Self(AtomicPtr::new(ptr::null_mut()))
    }

    /// That of this process. Allocates at the first call in each; waits for others that have it.
    pub(crate) fn lock(&'static self) -> MutexGuard<'static, T> {
        let pid = process::id();
        // Acquire: pairs with the Release below.
        let mut found = self.0.load(Ordering::Acquire);
        loop {
            // SAFETY: null, or leaked below.
            if let Some(own) = unsafe { found.as_ref() }.filter(|own| own.pid == pid) {
                return own.value.lock().unwrap_or_else(PoisonError::into_inner);
            }
            let new = Box::into_raw(Box::new(Own { pid, value: Mutex::default() }));
            match self.0.compare_exchange(found, new, Ordering::AcqRel, Ordering::Acquire) {
                Ok(_) => found = new,
                Err(other) => {
                    found = other;
                    // SAFETY: nobody else knows of it.
                    drop(unsafe { Box::from_raw(new) });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
