//! A body that uses up CPU time.
//!
//! *Background.* A loop calibrated at start is wrong whenever the clock frequency or the load during calibration
//! was; polling a wall clock counts time in which the thread was preempted as time burnt.
//!
//! *Rule.* The thread's own CPU clock decides, which is what "burns CPU for this long" says. That clock is a system
//! call which takes the run queue's lock, so the loop polls the monotonic clock, which is a plain read, for as long
//! as is still missing, and asks the CPU clock again only then: twice for a thread that nobody preempts.

use std::hint;

use crate::clock::Clock;
use crate::{Body, BodyError, Call};

/// Burns CPU for a fixed time.
#[derive(Clone, Copy, Debug)]
pub struct Spin {
    duration_ns: u64,
}

impl Spin {
    /// Burns `duration_ns` nanoseconds of CPU time in each call, and at most two clock reads more.
    #[must_use]
    pub const fn new(duration_ns: u64) -> Self {
        Self { duration_ns }
    }
}

impl Body for Spin {
    fn run(&mut self, _call: &Call) -> Result<(), BodyError> {
        let end = Clock::Thread.now_ns().saturating_add(self.duration_ns);
        let mut missing = self.duration_ns;
        while missing > 0 {
            let until = Clock::Monotonic.now_ns().saturating_add(missing);
            while Clock::Monotonic.now_ns() < until {
                hint::spin_loop();
            }
            missing = end.saturating_sub(Clock::Thread.now_ns());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
