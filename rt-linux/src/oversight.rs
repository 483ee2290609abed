//! What the watchdog does for a run at each of its looks: gives up bodies beyond their bounds, makes up for wake-ups
//! that got lost, and notes when nobody got a CPU.
//!
//! No protocol here loses a wake-up. A kernel, a filter of system calls or a debugger may; then a lane stands still
//! for one look instead of for ever.

use crate::bell::Bell;
use crate::shared::Shared;
use crate::standstills;
use crate::watchdog::{Expiry, Overseer};
use core::sync::atomic::Ordering;
use red_core::{Capacity, Scheduler, UnitId};
use red_sync::Exclusive;
use std::sync::Arc;

/// The watchdog's view of a run.
pub(crate) struct Oversight<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    shared: Arc<Shared<C, H, L>>,
    /// What waited in each seat at the last look.
    waiting: Vec<Option<UnitId>>,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Oversight<C, H, L> {
    pub(crate) fn of(shared: Arc<Shared<C, H, L>>) -> Self {
        let waiting = vec![None; shared.waiting.seats.len()];
        Self { shared, waiting }
    }
}

impl<C, H, L> Overseer for Oversight<C, H, L>
where
    C: Capacity,
    H: Send + 'static,
    L: Exclusive<Scheduler<C>> + Send + Sync + 'static,
{
    fn expired(&mut self, lane: usize, _expiry: Expiry) {
        self.shared.hung.fetch_add(1, Ordering::Relaxed);
        self.shared.lose(lane);
    }

    fn woke(&mut self, now_ns: u64) -> u64 {
        let shared = &*self.shared;
        shared.standstills.look(now_ns, || shared.last_turn_ns());
        shared.standstills.total_ns()
    }

    fn looked(&mut self, next_ns: u64) {
        let shared = &*self.shared;
        shared.standstills.expect(next_ns);
        for (seat, before) in shared.waiting.seats.iter().zip(&mut self.waiting) {
            let waits = seat.waiting();
            if waits.is_some() && waits == *before {
                seat.bell.rouse();
            }
            *before = waits;
        }
        for (stream, seat) in shared.waiting.streams.iter().zip(&shared.waiting.seats) {
            if let Some(stream) = stream.as_ref().filter(|stream| stream.is_handed()) {
                [&stream.bell, &seat.bell].into_iter().for_each(Bell::rouse);
            }
        }
        // Some looks late, as the ring for it may be under way.
        shared.waiting.look_after(standstills::SHORTEST_NS);
    }
}
