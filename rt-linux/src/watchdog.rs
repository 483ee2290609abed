//! Takes the CPU away from a node body that never returns.
//!
//! A FIFO thread that loops keeps its CPU for good. The watchdog, one priority above the lanes, demotes the
//! thread of such a lane to `SCHED_IDLE` when its bound has passed: the body goes on in the time that nobody
//! else wants, and its [`Overseer`] is told which lane it was. Under best effort it only tells,
//! because ordinary threads share their CPU anyway, and the kernel lets nobody without rights leave `SCHED_IDLE`.

use std::sync::{Arc, mpsc};
use std::thread::{self, JoinHandle};

use nix::errno::Errno;
use nix::unistd::{Pid, gettid};

use crate::bell::{Bell, Woken};
use crate::clock::now_ns;
use crate::setup::{Fifo, SetupError, best_effort};
pub use crate::slot::{Armed, Bound, Slot};
use crate::sys::{self, Policy};

/// Bounds shorter than this do not make the watchdog run more often.
const SHORTEST_SLEEP_NS: u64 = 1_000_000;
/// A bound that was armed while the watchdog slept is seen this much later at most.
const LONGEST_SLEEP_NS: u64 = 10_000_000;

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
    /// Makes the calling thread the one to demote. Once per lane, before it arms.
    pub fn adopt(&self) {
        self.adopt_thread(gettid().as_raw());
    }
}

/// Demotes the thread of a slot that was claimed, if `demotes`.
fn demote(thread: Option<i32>, demotes: bool) -> Expiry {
    let demoted =
        || thread.map_or(Err(Errno::ESRCH), |thread| sys::set_policy(Pid::from_raw(thread), Policy::Idle));
    match demotes.then(demoted) {
        Some(Ok(())) => Expiry::Demoted,
        Some(Err(errno)) => Expiry::Refused(errno),
        None => Expiry::Reported,
    }
}

/// Who is told what the watchdog sees, on the watchdog's thread. Must be short and must not panic.
pub trait Overseer: Send + 'static {
    /// The bound of the slot with this index has passed; once for each.
    fn expired(&mut self, index: usize, expiry: Expiry);

    /// A look begins at this instant of `CLOCK_MONOTONIC`. What it answers, in nanoseconds, is left out of all bounds: the
    /// deadlines of the slots are instants of that clock less this.
    fn woke(&mut self, now_ns: u64) -> u64 {
        let _unused = now_ns;
        0
    }

    /// A look at all slots is over; the next is due at this instant, or sooner.
    fn looked(&mut self, next_ns: u64) {
        let _unused = next_ns;
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
        let thread = thread::Builder::new().name("red-watchdog".into()).spawn(body);
        let thread = thread.map_err(|error| SetupError::no_thread("pthread_create(watchdog)", &error))?;
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
        let left_out = overseer.woke(now);
        wake_at = now + LONGEST_SLEEP_NS;
        for (index, slot) in slots.iter().enumerate() {
            let Some(deadline) = slot.deadline() else { continue };
            let passes_at = deadline.saturating_add(left_out);
            if passes_at > now {
                wake_at = wake_at.min(passes_at);
            } else if slot.claim(deadline) {
                let expiry = slot.expire(|thread| demote(thread, demotes));
                overseer.expired(index, expiry);
            }
        }
        wake_at = wake_at.max(now + SHORTEST_SLEEP_NS);
        overseer.looked(wake_at);
    }
}

#[cfg(test)]
mod tests;
