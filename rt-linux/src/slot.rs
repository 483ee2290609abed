//! What a lane shows the watchdog: until when its body must have returned.
//!
//! # Life of a slot
//!
//! ```text
//!            1 arm: one store              3 bound passed
//!     FREE ───────────────────▶ deadline ─────────────────▶ CLAIMED
//!      ▲                         │   ▲                         │ 4 thread demoted
//!      ├─────────────────────────┘   │ 1                       ▼
//!      │ 2 disarm in time            └───────────────────── PASSED
//!      └────────────────────────────────────────────────────┘ 5 reset, for another thread
//! ```
//!
//! A lane that disarms names the deadline that it armed, and takes no other away: a body that returns late finds what
//! the watchdog left, or what the lane's next thread has armed since, and learns in both cases that its bound has
//! passed. What is armed after a deadline has passed is a later deadline, so the two are told apart.
//!
//! CLAIMED exists so that a body that returns just then waits for the demotion to be over: otherwise it could
//! take its priority back first and lose it after.

use crate::primitive::{AtomicI32, AtomicU64, Ordering, constructor, yield_now};

const FREE: u64 = 0;
const CLAIMED: u64 = u64::MAX;
const PASSED: u64 = u64::MAX - 1;
/// The latest deadline that can be told from the states.
pub const LATEST: u64 = u64::MAX - 2;

/// What one lane shows the watchdog. No system calls.
#[derive(Debug, Default)]
#[repr(align(128))]
pub struct Slot {
    deadline_ns: AtomicU64,
    thread: AtomicI32,
    /// When the lane last took a turn, on `CLOCK_MONOTONIC`.
    turned_ns: AtomicU64,
}

/// A deadline that was armed, for [`Slot::disarm`].
#[derive(Debug)]
#[must_use = "a body whose deadline is not disarmed is found beyond its bound"]
pub struct Armed(u64);

/// Whether a body returned within its bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Bound {
    /// It did; nothing happened.
    Kept,
    /// It did not. A thread that was demoted takes its priority back with [`Fifo::apply`], which needs
    /// `CAP_SYS_NICE` or a nice limit of 20: where that fails, let it end, and start another from a thread that
    /// was not demoted.
    ///
    /// [`Fifo::apply`]: crate::setup::Fifo::apply
    Passed,
}

impl Slot {
    constructor! {
        /// A slot of no lane yet.
        #[must_use]
        pub fn new() -> Self {
            let (deadline_ns, turned_ns) = (AtomicU64::new(FREE), AtomicU64::new(0));
            Self { deadline_ns, thread: AtomicI32::new(0), turned_ns }
        }
    }

    /// The lane takes a turn with the scheduler.
    pub fn turn(&self, now_ns: u64) {
        self.turned_ns.store(now_ns, Ordering::Relaxed);
    }

    /// When it last did.
    pub fn turned_ns(&self) -> u64 {
        self.turned_ns.load(Ordering::Relaxed)
    }

    /// Makes the thread of this number the one to demote. Once per lane, before it arms.
    pub fn adopt_thread(&self, thread: i32) {
        self.thread.store(thread, Ordering::Relaxed);
    }

    /// The thread that adopted the slot last, if it was not forgotten since.
    pub fn thread(&self) -> Option<i32> {
        Some(self.thread.load(Ordering::Relaxed)).filter(|thread| *thread != 0)
    }

    /// Until another thread adopts the slot it has none.
    pub fn forget(&self) {
        self.thread.store(0, Ordering::Relaxed);
    }

    /// The body that starts now must return before `deadline_ns` of `CLOCK_MONOTONIC`. One store.
    pub fn arm(&self, deadline_ns: u64) -> Armed {
        let deadline = deadline_ns.clamp(1, LATEST);
        // Release: partner of the Acquire in `claim`, so that the watchdog sees the thread of `adopt`.
        self.deadline_ns.store(deadline, Ordering::Release);
        Armed(deadline)
    }

    /// The body returned. To be called on the adopted thread, also before that thread ends.
    #[expect(clippy::needless_pass_by_value, reason = "what was armed is disarmed once")]
    pub fn disarm(&self, armed: Armed) -> Bound {
        let own = armed.0;
        loop {
            // Acquire: partner of the Release in `expire`, after which the policy is no longer touched.
            match self.deadline_ns.compare_exchange(own, FREE, Ordering::Relaxed, Ordering::Acquire) {
                Ok(_) => return Bound::Kept,
                // For the length of one system call, of a thread of higher priority.
                Err(CLAIMED) => yield_now(),
                Err(_) => return Bound::Passed,
            }
        }
    }

    /// Frees the slot of a lane that has no thread any more: what its body came to, if one was running. To be called
    /// by who gives it another thread, or by that thread before it arms.
    pub fn reset(&self) -> Bound {
        loop {
            // Relaxed: who is told that a lane is lost has acquired that. A read-modify-write, so that a late body that
            // reads the result is after `expire` all the same.
            match self.deadline_ns.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |deadline| {
                (deadline != CLAIMED).then_some(FREE)
            }) {
                Ok(PASSED) => return Bound::Passed,
                Ok(_) => return Bound::Kept,
                Err(_) => yield_now(),
            }
        }
    }

    /// Whether the body that was armed last was found beyond its bound.
    pub fn has_passed(&self) -> bool {
        matches!(self.deadline_ns.load(Ordering::Relaxed), CLAIMED | PASSED)
    }

    /// The deadline, if a body is running and has not passed it yet.
    pub fn deadline(&self) -> Option<u64> {
        Some(self.deadline_ns.load(Ordering::Relaxed)).filter(|deadline| (1..=LATEST).contains(deadline))
    }

    /// Takes the slot of a body whose `deadline` has passed, unless it returned meanwhile.
    pub fn claim(&self, deadline: u64) -> bool {
        // Acquire: partner of the Release in `arm`.
        self.deadline_ns.compare_exchange(deadline, CLAIMED, Ordering::Acquire, Ordering::Relaxed).is_ok()
    }

    /// Ends a claim, after `act` on the thread. It has not ended, for it would have waited in `disarm`; unless it was
    /// killed, and then it may not be there.
    pub fn expire<R>(&self, act: impl FnOnce(Option<i32>) -> R) -> R {
        let result = act(self.thread());
        // Release: partner of the Acquire in `disarm`.
        self.deadline_ns.store(PASSED, Ordering::Release);
        result
    }
}
