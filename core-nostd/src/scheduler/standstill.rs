//! Standstills: time in which no lane ran is nobody's execution.

use super::Scheduler;
use crate::capacity::Capacity;
use crate::time::{Duration, Instant};

impl<C: Capacity> Scheduler<C> {
    /// Nothing ran for `time` up to `now`, on no lane: the machine was halted, throttled, or out of its quota. Units that
    /// run did not execute meanwhile, so that neither their estimates nor their overruns count it. Deadlines do not wait.
    /// Time bound: O(lanes).
    pub fn stood_still(&mut self, time: Duration, now: Instant) {
        self.advance(now);
        for lane in 0..self.lanes() {
            let l = &mut self.lanes[lane];
            if !l.is_busy() {
                continue;
            }
            let stood = time.min(self.now.since(l.started));
            l.started = l.started.saturating_add(stood);
            // The lane was not free.
            let busy = &mut self.pools[usize::from(l.pool)].busy;
            *busy = busy.wrapping_add(stood.as_nanos());
        }
        self.delayed();
    }
}
