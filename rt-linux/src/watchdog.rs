//! Takes the CPU away from a node body that never returns.
//!
//! A FIFO thread that loops keeps its CPU for good. The watchdog, one priority above the lanes, demotes the
//! thread of such a lane to `SCHED_IDLE` when its bound has passed: the body goes on in the time that nobody
//! else wants, and its [`Overseer`] is told which lane it was. Under best effort it only tells,
//! because ordinary threads share their CPU anyway, and the kernel lets nobody without rights leave `SCHED_IDLE`.
//!
//! # Life of a slot
//!
//! ```text
//!            1 arm: one store              3 bound passed
//!     FREE ───────────────────▶ deadline ─────────────────▶ CLAIMED
//!      ▲                         │                             │ 4 thread demoted
//!      ├─────────────────────────┘ 2 disarm in time            ▼
//!      └──────────────────────────────────────────────────── PASSED
//!                              5 disarm: the lane learns of it
//! ```
//!
//! CLAIMED exists so that a body that returns just then waits for the demotion to be over: otherwise it could
//! take its priority back first and lose it after.

use core::sync::atomic::{AtomicI32, AtomicU64, Ordering};
use std::io;
use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

use nix::errno::Errno;
use nix::unistd::{Pid, gettid};

use crate::bell::{Bell, Woken};
use crate::clock::now_ns;
use crate::setup::{Fifo, SetupError, best_effort};
use crate::sys::{self, Policy};

/// Bounds shorter than this do not make the watchdog run more often.
const SHORTEST_SLEEP_NS: u64 = 1_000_000;
/// A bound that was armed while the watchdog slept is seen this much later at most.
const LONGEST_SLEEP_NS: u64 = 10_000_000;

const FREE: u64 = 0;
const CLAIMED: u64 = u64::MAX;
const PASSED: u64 = u64::MAX - 1;
/// The latest deadline that can be told from the states.
const LATEST: u64 = u64::MAX - 2;

/// What one lane shows the watchdog: until when its body must have returned. No system calls.
#[derive(Debug, Default)]
#[repr(align(128))]
pub struct Slot {
    deadline_ns: AtomicU64,
    thread: AtomicI32,
}

/// Whether a body returned within its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Bound {
    /// It did; nothing happened.
    Kept,
    /// It did not. A thread that was demoted takes its priority back with [`Fifo::apply`], which needs
    /// `CAP_SYS_NICE` or a nice limit of 20: where that fails, let it end, and start another from a thread that
    /// was not demoted.
    Passed,
}

/// What the watchdog did about a body whose bound has passed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expiry {
    /// Its thread is `SCHED_IDLE` now.
    Demoted,
    /// Nothing: the run is best effort, and its thread shares the CPU.
    Reported,
    /// The kernel refused the demotion: the thread keeps its CPU.
    Refused(Errno),
}

impl Slot {
    /// A slot of no lane yet.
    #[must_use]
    pub const fn new() -> Self {
        Self { deadline_ns: AtomicU64::new(FREE), thread: AtomicI32::new(0) }
    }

    /// Makes the calling thread the one to demote. Once per lane, before it arms.
    pub fn adopt(&self) {
        self.thread.store(gettid().as_raw(), Ordering::Relaxed);
    }

    /// The thread that adopted the slot last, if it was not forgotten since.
    pub(crate) fn thread(&self) -> Option<Pid> {
        Some(self.thread.load(Ordering::Relaxed)).filter(|thread| *thread != 0).map(Pid::from_raw)
    }

    /// Until another thread adopts the slot it has none.
    pub(crate) fn forget(&self) {
        self.thread.store(0, Ordering::Relaxed);
    }

    /// The body that starts now must return before `deadline_ns` of `CLOCK_MONOTONIC`. One store.
    pub fn arm(&self, deadline_ns: u64) {
        // Release: partner of the Acquire in `claim`, so that the watchdog sees the thread of `adopt`.
        self.deadline_ns.store(deadline_ns.clamp(1, LATEST), Ordering::Release);
    }

    /// The body returned. To be called on the adopted thread, also before that thread ends.
    pub fn disarm(&self) -> Bound {
        loop {
            // Acquire: partner of the Release in `expire`, after which the policy is no longer touched.
            match self.deadline_ns.fetch_update(Ordering::Relaxed, Ordering::Acquire, |deadline| {
                (deadline != CLAIMED).then_some(FREE)
            }) {
                Ok(PASSED) => return Bound::Passed,
                Ok(_) => return Bound::Kept,
                // For the length of one system call, of a thread of higher priority.
                Err(_) => thread::yield_now(),
            }
        }
    }

    /// Whether a body is running that was found beyond its bound.
    pub(crate) fn has_passed(&self) -> bool {
        matches!(self.deadline_ns.load(Ordering::Relaxed), CLAIMED | PASSED)
    }

    /// The deadline, if a body is running and has not passed it yet.
    pub(crate) fn deadline(&self) -> Option<u64> {
        Some(self.deadline_ns.load(Ordering::Relaxed)).filter(|deadline| (1..=LATEST).contains(deadline))
    }

    /// Takes the slot of a body whose `deadline` has passed, unless it returned meanwhile.
    fn claim(&self, deadline: u64) -> bool {
        // Acquire: partner of the Release in `arm`.
        self.deadline_ns.compare_exchange(deadline, CLAIMED, Ordering::Acquire, Ordering::Relaxed).is_ok()
    }

    /// Ends a claim, after demoting the thread if `demotes`.
    fn expire(&self, demotes: bool) -> Expiry {
        // The thread has not ended, for it would have waited in `disarm`; unless it was killed, and then it is not there.
        let demoted =
            || self.thread().map_or(Err(Errno::ESRCH), |thread| sys::set_policy(thread, Policy::Idle));
        let expiry = match demotes.then(demoted) {
            Some(Ok(())) => Expiry::Demoted,
            Some(Err(errno)) => Expiry::Refused(errno),
            None => Expiry::Reported,
        };
        // Release: partner of the Acquire in `disarm`.
        self.deadline_ns.store(PASSED, Ordering::Release);
        expiry
    }
}

/// Who is told what the watchdog sees, on the watchdog's thread. Must be short and must not panic.
pub trait Overseer: Send + 'static {
    /// The bound of the slot with this index has passed; once for each.
    fn expired(&mut self, index: usize, expiry: Expiry);

    /// A look at all slots is over. It began `late_ns` nanoseconds after it was due.
    fn looked(&mut self, late_ns: u64) {
        let _unused = late_ns;
    }
}

impl<F: FnMut(usize, Expiry) + Send + 'static> Overseer for F {
    fn expired(&mut self, index: usize, expiry: Expiry) {
        self(index, expiry);
    }
}

/// The thread that watches a table of slots. Dropping it ends the thread.
#[derive(Debug)]
pub struct Watchdog {
    stop: Arc<Bell>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdog {
    /// Starts watching `slots`, at `fifo` or, for a best-effort run, as an ordinary thread that only reports.
    ///
    /// # Errors
    ///
    /// Those of [`Fifo::apply`], or [`SetupError::System`] if no thread can be started.
    pub fn start(
        slots: Arc<[Slot]>,
        fifo: Option<Fifo>,
        overseer: impl Overseer,
    ) -> Result<Self, SetupError> {
        let stop = Arc::new(Bell::new());
        let (ready, is_ready) = mpsc::sync_channel(1);
        let bell = stop.clone();
        let body = move || {
            let prepared = fifo.map_or_else(best_effort, Fifo::apply);
            let failed = prepared.is_err();
            if ready.send(prepared).is_ok() && !failed {
                watch(&slots, fifo.is_some(), &bell, overseer);
            }
        };
        let no_thread = |error: io::Error| SetupError::System {
            call: "pthread_create(watchdog)",
            errno: Errno::from_raw(error.raw_os_error().unwrap_or_default()),
            fix: "raise the limit of processes (ulimit -u) or free memory",
        };
        let thread = thread::Builder::new().name("red-watchdog".into()).spawn(body).map_err(no_thread)?;
        let watchdog = Self { stop, thread: Some(thread) };
        is_ready.recv().expect("the thread reports before anything else")?;
        Ok(watchdog)
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.stop.ring();
        if let Some(thread) = self.thread.take() {
            // A panic of the overseer has been printed by its thread already.
            let _ = thread.join();
        }
    }
}

fn watch(slots: &[Slot], demotes: bool, stop: &Bell, mut overseer: impl Overseer) {
    let mut wake_at = now_ns();
    while stop.wait(Some(wake_at), 0) == Woken::TimedOut {
        let now = now_ns();
        let late_ns = now.saturating_sub(wake_at);
        wake_at = now + LONGEST_SLEEP_NS;
        for (index, slot) in slots.iter().enumerate() {
            let Some(deadline) = slot.deadline() else { continue };
            if deadline > now {
                wake_at = wake_at.min(deadline);
            } else if slot.claim(deadline) {
                overseer.expired(index, slot.expire(demotes));
            }
        }
        overseer.looked(late_ns);
        wake_at = wake_at.max(now + SHORTEST_SLEEP_NS);
    }
}

#[cfg(test)]
mod tests;
