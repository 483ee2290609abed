//! Errands: how a thread that is no lane has something done by one, under the scheduler's lock.
//!
//! # Protocol
//!
//! ```text
//!         1 asker: in the box          2 lane, locked
//!    FREE ───────────────────▶ ASKED ─────────────────▶ TAKEN, by which thread
//!     ▲ ▲ 4 asker, if it is over │                        │ 3 lane, locked: back in the box,
//!     │ └────────────────────────┘                        ▼   and a ring after the lock
//!     └────────────────────────────────────────────── ANSWERED
//!                          5 asker: out of the box
//! ```
//!
//! Arrows 2 and 4 are exchanges of one word, so that one of them wins: an errand that its asker took back is never run,
//! and none runs after its asker has gone on. The asker alone goes to sleep, and it looks again after a while whatever
//! happens to wake-ups. It leaves from TAKEN only if the thread that took the errand has ended, and with it the errand.

use crate::bell::Bell;
use crate::primitive::{AtomicBool, AtomicU32, Mailbox, Ordering, now_ns};

const FREE: u32 = 0;
const ASKED: u32 = 1;
const ANSWERED: u32 = 2;
/// With the kernel's number of the thread above it, which is below 2^22.
const TAKEN: u32 = 3;
const STATE_BITS: u32 = 2;

/// Between two looks of who waits for an answer.
const LOOK_NS: u64 = 50_000_000;

/// One errand at a time, to a lane and back. Neither side allocates.
#[derive(Debug)]
#[repr(align(128))]
pub struct Errands<T> {
    state: AtomicU32,
    /// The asker's.
    bell: Bell,
    /// No lane takes any more.
    is_over: AtomicBool,
    errand: Mailbox<T, 1>,
}

/// Why an errand was not run to its end.
#[derive(Debug)]
pub enum Undone<T> {
    /// No lane took it, and none will: here it is.
    Over(T),
    /// The thread that took it has ended, and with it the errand.
    Lost,
}

impl<T> Default for Errands<T> {
    fn default() -> Self {
        let (state, is_over) = (AtomicU32::new(FREE), AtomicBool::new(false));
        Self { state, bell: Bell::new(), is_over, errand: Mailbox::new() }
    }
}

impl<T> Errands<T> {
    /// Waits for a lane that takes the errand and brings it back. `knock` tells the lanes of it, and `has_ended` whether
    /// the thread of this number is there no more. One thread at a time asks, and it is none of the lanes'.
    ///
    /// # Errors
    /// [`Undone`]. Whatever comes back, the errand does not run any more.
    pub fn ask(
        &self,
        errand: T,
        knock: impl FnOnce(),
        has_ended: impl Fn(u32) -> bool,
    ) -> Result<T, Undone<T>> {
        // It stays taken where a thread ended with it in hand. Relaxed: the one who asked before was this one's.
        if self.state.load(Ordering::Relaxed) != FREE {
            return Err(Undone::Over(errand));
        }
        if let Err(errand) = self.put(errand) {
            return Err(Undone::Over(errand));
        }
        // Release: partner of the Acquire in `take`, so that the errand is there.
        self.state.store(ASKED, Ordering::Release);
        knock();
        loop {
            // Acquire: partner of the Release in `answer`.
            match self.state.load(Ordering::Acquire) {
                ANSWERED => {
                    self.state.store(FREE, Ordering::Relaxed);
                    return self.errand.pop().ok_or(Undone::Lost);
                }
                // Relaxed: the ring that follows brings it along.
                ASKED if self.is_over.load(Ordering::Relaxed) => {
                    // Relaxed: what is in the box is this thread's own.
                    if self.change(ASKED, FREE, Ordering::Relaxed) {
                        return Err(self.errand.pop().map_or(Undone::Lost, Undone::Over));
                    }
                    continue;
                }
                ASKED => {}
                // It may have answered before it ended.
                taken if has_ended(taken >> STATE_BITS) && self.state.load(Ordering::Relaxed) == taken => {
                    return Err(Undone::Lost);
                }
                _ => {}
            }
            let _looks_anyway = self.bell.wait(Some(now_ns().saturating_add(LOOK_NS)), 0);
        }
    }

    /// The errand, if there is one. To be called under the scheduler's lock by the thread of this number, which answers
    /// before it leaves the lock.
    pub fn take(&self, thread: u32) -> Option<T> {
        // Relaxed: hardly ever is there one, and a turn follows every knock.
        if self.state.load(Ordering::Relaxed) != ASKED {
            return None;
        }
        // Acquire: partner of the Release in `ask`.
        let won = self.change(ASKED, thread << STATE_BITS | TAKEN, Ordering::Acquire);
        won.then(|| self.errand.pop()).flatten()
    }

    /// Brings an errand back. [`Self::ring`] has to follow, best after the lock.
    pub fn answer(&self, errand: T) {
        // There is room, for it was there before.
        let _back = self.put(errand);
        // Release: partner of the Acquire in `ask`.
        self.state.store(ANSWERED, Ordering::Release);
    }

    /// Wakes the asker. One system call if it sleeps, none otherwise.
    pub fn ring(&self) {
        self.bell.ring();
    }

    /// No lane takes an errand from now on: who waits for that takes its own back. Async-signal-safe and wait-free.
    pub fn close(&self) {
        // Relaxed: the ring publishes it to who sleeps, and others look before they do.
        self.is_over.store(true, Ordering::Relaxed);
        self.bell.ring();
    }

    fn put(&self, errand: T) -> Result<(), T> {
        match self.errand.claim() {
            Some(post) => post.push(errand),
            None => Err(errand),
        }
    }

    fn change(&self, from: u32, to: u32, order: Ordering) -> bool {
        self.state.compare_exchange(from, to, order, Ordering::Relaxed).is_ok()
    }
}

#[cfg(test)]
mod tests;
