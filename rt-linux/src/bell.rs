//! A wake-up for one thread that makes no system call while nobody sleeps.
//!
//! # Protocol
//!
//! ```text
//!            1 ring (no system call)
//!     QUIET ────────────────────────▶ RUNG ◀─┐ 2 ring again: merged
//!      ▲  │                           │  ▲ └─┘
//!      │  │ 3 waiter goes to sleep    │  │
//!      │  ▼                           │  │ 4 ring, and wake the sleeper
//!      │ ASLEEP ──────────────────────┼──┘
//!      │  │ 5 time-out, signal        │
//!      └──┴───────────────────────────┘ 6 the waiter takes the ring
//! ```
//!
//! Why no ring is lost: every transition is a read-modify-write of one word, so all of them have one order.
//! A ring before arrow 3 makes that arrow fail. A ring after it finds `ASLEEP` and wakes; should the waiter
//! not yet be inside the kernel, the kernel sees that the word is no longer `ASLEEP` and does not sleep.

use crate::primitive::{AtomicU32, Ordering, constructor, futex_wait, futex_wake, now_ns};

const QUIET: u32 = 0;
const RUNG: u32 = 1;
const ASLEEP: u32 = 2;

/// A bell: many threads, signal handlers and driver callbacks may ring it, one thread waits for it.
///
/// Rings that come before the waiter looks are merged into one. What the ringer wrote before [`Bell::ring`]
/// is visible to the waiter after [`Bell::wait`] returned [`Woken::Rung`].
///
/// 128 bytes, the unit in which present CPUs fetch, so that no neighbour's stores disturb a spinning waiter.
#[derive(Debug, Default)]
#[repr(align(128))]
pub struct Bell {
    state: AtomicU32,
}

/// Why a wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Woken {
    /// The bell was rung.
    Rung,
    /// The time came first.
    TimedOut,
}

impl Bell {
    constructor! {
        /// A quiet bell.
        #[must_use]
        pub fn new() -> Self {
            Self { state: AtomicU32::new(QUIET) }
        }
    }

    /// Wakes the waiter now, or lets its next wait return at once.
    ///
    /// Async-signal-safe and wait-free. One system call if the waiter sleeps, none otherwise.
    pub fn ring(&self) {
        // Always a read-modify-write, also when the bell is already RUNG: it continues the release sequence
        // of the earlier ring, so that the one `take` that ends both sees what both ringers wrote.
        // Release: partner of the Acquire in `take`.
        if self.state.swap(RUNG, Ordering::Release) == ASLEEP {
            futex_wake(&self.state);
        }
    }

    /// Takes the ring, if there was one. To be called by the waiter only.
    pub fn take(&self) -> bool {
        // The plain load keeps the line shared while the waiter polls.
        self.state.load(Ordering::Relaxed) == RUNG && self.settle()
    }

    /// Waits until the bell is rung or `until` (nanoseconds of `CLOCK_MONOTONIC`) has come: the first
    /// `spin_ns` nanoseconds spinning, then asleep.
    ///
    /// One waiter at a time. A spin shorter than the cost of a wake-up seldom helps; a thread that shares its
    /// CPU with a ringer passes 0.
    pub fn wait(&self, until: Option<u64>, spin_ns: u64) -> Woken {
        if self.take() {
            return Woken::Rung;
        }
        let until_ns = until.unwrap_or(u64::MAX);
        if spin_ns > 0 && self.spin(until_ns.min(now_ns().saturating_add(spin_ns))) == Woken::Rung {
            return Woken::Rung;
        }
        self.sleep(until)
    }

    /// Spins until the bell is rung or `until_ns` has come.
    pub fn spin(&self, until_ns: u64) -> Woken {
        loop {
            if self.take() {
                return Woken::Rung;
            }
            // No pause instruction: a look at the clock takes as long, and a pause would make the end inexact.
            if now_ns() >= until_ns {
                return Woken::TimedOut;
            }
        }
    }

    fn sleep(&self, until: Option<u64>) -> Woken {
        loop {
            // Relaxed: going to sleep publishes nothing, and what a ringer published is acquired by `settle`.
            let slept = self.state.compare_exchange(QUIET, ASLEEP, Ordering::Relaxed, Ordering::Relaxed);
            let timed_out = slept.is_ok() && futex_wait(&self.state, ASLEEP, until);
            if self.settle() {
                return Woken::Rung;
            }
            if timed_out {
                return Woken::TimedOut;
            }
            // A signal, or a wake-up meant for an earlier sleep: sleep on, to the same absolute time.
        }
    }

    /// Back to QUIET; whether the bell had been rung.
    fn settle(&self) -> bool {
        // Acquire: partner of the Release in `ring`.
        self.state.swap(QUIET, Ordering::Acquire) == RUNG
    }
}

#[cfg(test)]
mod tests;
