//! Spares: how a lane whose body hung gets another thread.
//!
//! # Protocol
//!
//! ```text
//! watchdog          lose: the seat is overdue, the lane is lost, and a knock
//! a lane, locked    finds_overdue: fails the unit, retires the lane
//! control thread    lost: starts a spare; once that is set up, numbers it, assigns the lane to it and lets it go
//! the spare, locked finds_overdue, then takes_over: what was handed is discarded, the lane is restored
//! ```
//!
//! The thread that hung leaves when its body returns, also where nobody has replaced it yet: two threads never wait on
//! one seat.

use crate::primitive::{AtomicU32, Ordering};
use crate::seat::Seat;

/// Lanes between their threads, a bit each.
#[derive(Debug, Default)]
pub struct Spares {
    /// Their threads are lost: for the control thread.
    lost: AtomicU32,
    /// They got a spare: for its first turn.
    spared: AtomicU32,
}

impl Spares {
    /// The lane's body ran past its bound. A knock has to follow: some lane fails the job; where none is left, the
    /// spare does it.
    pub fn lose(&self, lane: usize, seat: &Seat) {
        seat.overdue.store(true, Ordering::Relaxed);
        // Release: partner of the Acquire in `take_lost`, so that the spare sees that the seat is overdue.
        self.lost.fetch_or(1 << lane, Ordering::Release);
    }

    /// Whether the seat's body ran past its bound, once. To be called under the scheduler's lock.
    pub fn finds_overdue(&self, seat: &Seat) -> bool {
        // Relaxed first: the flag is hardly ever set.
        seat.overdue.load(Ordering::Relaxed) && seat.overdue.swap(false, Ordering::Relaxed)
    }

    /// The lanes that lost their threads since the last call.
    pub fn take_lost(&self) -> u32 {
        // Acquire: partner of the Release in `lose`.
        self.lost.swap(0, Ordering::Acquire)
    }

    /// The lane belongs to a thread of this number from now on, which is let go next.
    pub fn assign(&self, lane: usize, seat: &Seat, thread: u64) {
        // Relaxed, as all about `spared`: only the spare looks for its bit, and letting it go publishes both.
        seat.threads.store(thread, Ordering::Relaxed);
        // Before its first turn, which retires the lane for the hung body and then takes it over.
        self.spared.fetch_or(1 << lane, Ordering::Relaxed);
    }

    /// Whether this thread takes its lane over now, so that the lane has to be restored. To be called under the
    /// scheduler's lock, after the lanes that are overdue were retired.
    pub fn takes_over(&self, lane: usize, seat: &Seat, thread: u64) -> bool {
        let bit = 1 << lane;
        let takes = self.spared.load(Ordering::Relaxed) & bit != 0 && seat.is_of(thread);
        if takes {
            self.spared.fetch_and(!bit, Ordering::Relaxed);
            // The lane was retired, so this is the unit that was failed then, or one before it.
            seat.discard();
        }
        takes
    }
}
