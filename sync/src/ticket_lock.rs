#![allow(unsafe_code, reason = "a lock hands out exclusive access to a shared cell")]
//! A ticket lock: fair, with a bounded wait.
//!
//! *Rule.* Take the next ticket, wait until it is served. *Why it holds.* Tickets are served in order, so with n
//! contenders a waiter sees at most n - 1 critical sections, and each of those is bounded by the capacities.

use crate::Exclusive;
use crate::primitive::{AtomicU32, Cell, Ordering, constructor, spin_loop};

/// A value behind a fair spin lock. Contenders must each have a CPU of their own; see the module.
///
/// ```
/// use red_sync::{Exclusive, TicketLock};
/// let counter = TicketLock::new(0);
/// counter.with(|n| *n += 1);
/// assert_eq!(counter.with(|n| *n), 1);
/// ```
#[derive(Debug)]
#[repr(align(128))]
pub struct TicketLock<T> {
    next: AtomicU32,
    serving: AtomicU32,
    value: Cell<T>,
}

// SAFETY: `with` lets one thread at a time reach the value, so sharing the lock only moves the value between
// threads.
unsafe impl<T: Send> Sync for TicketLock<T> {}

impl<T> TicketLock<T> {
    constructor! {
        /// Wraps a value.
        pub fn new(value: T) -> Self {
            Self { next: AtomicU32::new(0), serving: AtomicU32::new(0), value: Cell::new(value) }
        }
    }

    /// Tickets drawn so far, modulo 2^32: who looks at this from inside sees whether others wait.
    pub fn drawn(&self) -> u32 {
        self.next.load(Ordering::Relaxed)
    }
}

/// Serves the next ticket, also when the critical section panics.
struct Turn<'a> {
    serving: &'a AtomicU32,
    ticket: u32,
}

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        // Release: pairs with the Acquire of the next holder's wait.
        self.serving.store(self.ticket.wrapping_add(1), Ordering::Release);
    }
}

impl<T> Exclusive<T> for TicketLock<T> {
    fn new(value: T) -> Self {
        Self::new(value)
    }

    #[inline]
    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        let ticket = self.next.fetch_add(1, Ordering::Relaxed);
        // Acquire: pairs with the Release of the holder before.
        while self.serving.load(Ordering::Acquire) != ticket {
            spin_loop();
        }
        let _turn = Turn { serving: &self.serving, ticket };
        self.value.with_mut(|value| {
            // SAFETY: this ticket is being served until `_turn` drops, and no other ticket equals it: fewer
            // than 2^32 threads wait. So this is the only reference.
            f(unsafe { &mut *value })
        })
    }
}

#[cfg(test)]
mod tests;
