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
//! Why no ring is lost: every access that matters is a read-modify-write of one word, so all of them have one
//! order. A ring before arrow 3 makes that arrow fail. A ring after it finds `ASLEEP` and wakes; should the
//! waiter not yet be inside the kernel, the kernel sees that the word is no longer `ASLEEP` and does not sleep.
//!
//! # A condition instead of a ring
//!
//! A waiter that looks at a word of its own ([`Bell::wait_for`]) needs no ring while it is awake, only
//! [`Bell::wake`] while it sleeps. The writer writes first and wakes then; the waiter takes arrow 3 first and
//! looks then. `wake` is a read-modify-write that changes nothing, so it has its place in the order too. Before
//! arrow 3, it is what that arrow reads, and the waiter sees the write; after it, it finds `ASLEEP` and rings.
//! Thus a hand-over between threads that are awake stores nothing in the bell, and nobody has to clear it.

use crate::primitive::{AtomicU32, Ordering, constructor, futex_wait, futex_wake, now_ns, spin_loop};

/// Looks at the word for one at the clock, while the end of a spin is [`LONG_NS`] away: a fraction of it even where
/// a pause takes 50 ns.
const LOOKS: u32 = 16;
const LONG_NS: u64 = 4_000;

const QUIET: u32 = 0;
const RUNG: u32 = 1;
const ASLEEP: u32 = 2;

/// A bell: many threads, signal handlers and driver callbacks may ring it, one thread waits for it.
///
/// Rings that come before the waiter looks are merged into one. What the ringer wrote before [`Bell::ring`]
/// is visible to the waiter after [`Bell::wait`] returned [`Woken::Rung`].
///
/// Four bytes, so that a bell fits into the cache line of what it announces. Who spins on a bell keeps other
/// threads' data off its line.
#[derive(Debug, Default)]
pub struct Bell {
    state: AtomicU32,
}

/// Why a wait ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Woken {
    /// The bell was rung, or what was waited for is ready.
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

    /// Wakes the waiter if it sleeps, and leaves no ring if it does not: for a thread that has just made true what
    /// the waiter waits for with [`Bell::wait_for`].
    ///
    /// Async-signal-safe and wait-free. One system call if the waiter sleeps, none otherwise.
    pub fn wake(&self) {
        // A read-modify-write, because a plain load may be older than the waiter's step into sleep.
        // Release: partner of the Acquire in `sleep`, so that a waiter that sleeps later has seen the condition.
        if self.state.fetch_or(0, Ordering::Release) == ASLEEP {
            self.ring();
        }
    }

    /// As [`Bell::ring`], and wakes the waiter also where an earlier ring says that it did: for who suspects that a
    /// wake-up was lost on its way through the kernel. What the caller wrote before it is not brought along. Always one
    /// system call.
    pub fn rouse(&self) {
        // Relaxed: it brings no news. A read-modify-write, which hands on those of an earlier ring.
        self.state.swap(RUNG, Ordering::Relaxed);
        futex_wake(&self.state);
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
        self.wait_for(|| false, until, spin_ns)
    }

    /// As [`Bell::wait`], and ends as if rung as soon as `ready` holds. Who makes it hold calls [`Bell::wake`] or
    /// [`Bell::ring`] afterwards.
    ///
    /// `ready` is called often and should read one cache line, best that of the bell.
    pub fn wait_for(&self, ready: impl Fn() -> bool, until: Option<u64>, spin_ns: u64) -> Woken {
        let spins = spin_ns > 0;
        // Before the clock is asked, because what is waited for is often under way.
        if self.look(&ready, if spins { LOOKS } else { 1 }) {
            return Woken::Rung;
        }
        let until_ns = until.unwrap_or(u64::MAX);
        if spins && self.spin(&ready, until_ns.min(now_ns().saturating_add(spin_ns))) == Woken::Rung {
            return Woken::Rung;
        }
        self.sleep(ready, until)
    }

    /// Spins until the bell is rung, `ready` holds or `until_ns` has come.
    pub fn spin(&self, ready: impl Fn() -> bool, until_ns: u64) -> Woken {
        let mut looks = 1;
        loop {
            if self.look(&ready, looks) {
                return Woken::Rung;
            }
            // A look at the clock is blind for as long as a line takes to arrive, so there are many at the word for
            // one. Near the end nothing but the clock keeps it exact.
            looks = match until_ns.saturating_sub(now_ns()) {
                0 => return Woken::TimedOut,
                LONG_NS.. => LOOKS,
                _ => 1,
            };
        }
    }

    /// Whether the bell was rung or `ready` holds, at so many looks.
    fn look(&self, ready: impl Fn() -> bool, looks: u32) -> bool {
        (1..=looks).any(|look| {
            if look > 1 {
                // Keeps the CPU from guessing ahead of the line, which it would have to undo.
                spin_loop();
            }
            ready() || self.take()
        })
    }

    fn sleep(&self, ready: impl Fn() -> bool, until: Option<u64>) -> Woken {
        loop {
            // Acquire: partner of the Release in `wake`. What a ringer published is acquired by `settle`.
            let slept = self.state.compare_exchange(QUIET, ASLEEP, Ordering::Acquire, Ordering::Relaxed);
            let timed_out = slept.is_ok() && !ready() && futex_wait(&self.state, ASLEEP, until);
            if self.settle() || ready() {
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
