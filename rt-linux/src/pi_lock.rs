//! The lock for threads that share a CPU: it lends the priority of the waiter to the holder.
//!
//! Lanes with a CPU each use the core's ticket lock. Under best effort lanes share CPUs, and a spinner on the
//! CPU of a preempted holder would never see the lock released; a sleeping waiter that does not lend its
//! priority would wait for everybody in between.

use core::fmt;
use core::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use crate::setup::SetupError;
use crate::sys::PiMutex;

/// A value behind a priority-inheriting lock.
///
/// Uncontended it makes no system call; contended one on each side.
pub struct PiLock<T> {
    turn: PiMutex,
    // Never contended, because `turn` is held around it: it is the safe way to hand out `&mut T`.
    value: Mutex<T>,
}

impl<T> PiLock<T> {
    /// A free lock.
    ///
    /// # Errors
    ///
    /// [`SetupError::System`] where the kernel has no priority inheritance.
    pub fn new(value: T) -> Result<Self, SetupError> {
        let turn = PiMutex::new().map_err(|errno| SetupError::System {
            call: "pthread_mutex_init(PTHREAD_PRIO_INHERIT)",
            errno,
            fix: "use a kernel built with CONFIG_FUTEX_PI=y",
        })?;
        Ok(Self { turn, value: Mutex::new(value) })
    }

    /// Waits for the lock.
    ///
    /// A holder that panicked leaves the value as it was then; the next one gets it.
    ///
    /// # Panics
    ///
    /// If the calling thread holds it already, which would otherwise be a deadlock.
    pub fn lock(&self) -> PiGuard<'_, T> {
        if let Err(errno) = self.turn.lock() {
            panic!("PiLock::lock: {errno}: this thread holds the lock already");
        }
        let value = match self.value.try_lock() {
            Ok(value) => value,
            Err(TryLockError::Poisoned(poisoned)) => PoisonError::into_inner(poisoned),
            Err(TryLockError::WouldBlock) => unreachable!("only the holder of `turn` locks `value`"),
        };
        PiGuard { value, _turn: Turn(&self.turn) }
    }
}

impl<T> red_sync::Exclusive<T> for PiLock<T> {
    /// # Panics
    /// Without priority-inheriting futexes in the kernel; hosts ask for one with [`PiLock::new`] first.
    fn new(value: T) -> Self {
        match Self::new(value) {
            Ok(lock) => lock,
            Err(e) => panic!("{e}"),
        }
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        f(&mut self.lock())
    }
}

impl<T> fmt::Debug for PiLock<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PiLock").finish_non_exhaustive()
    }
}

/// Access to the value; dropping it releases the lock. It stays on the thread that locked.
#[must_use]
pub struct PiGuard<'a, T> {
    // First, because fields are dropped in this order and the value must be free before the turn is.
    value: MutexGuard<'a, T>,
    _turn: Turn<'a>,
}

impl<T> Deref for PiGuard<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for PiGuard<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}

impl<T: fmt::Debug> fmt::Debug for PiGuard<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.value.fmt(f)
    }
}

struct Turn<'a>(&'a PiMutex);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        let unlocked = self.0.unlock();
        debug_assert!(unlocked.is_ok(), "the guard does not leave the thread that locked");
    }
}

#[cfg(test)]
mod tests;
