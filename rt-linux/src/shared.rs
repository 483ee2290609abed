//! What lanes share: the scheduler, the host, and how they wait for each other.

use crate::spares::Spares;
use crate::timeline::Timeline;
use crate::waiting::Waiting;
use crate::watchdog::Slot;
use core::sync::atomic::{AtomicBool, AtomicU64};
use red_core::{Capacity, Instant, LaneId, Scheduler};
use red_sync::{Exclusive, SharedScheduler, TicketLock};
use std::sync::Arc;

/// Producers outside of the lanes, and requests that each may have under way.
const PRODUCERS: usize = 8;
pub(crate) const DEPTH: usize = 64;

/// What lanes share.
pub(crate) struct Shared<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) scheduler: SharedScheduler<C, L, PRODUCERS, DEPTH>,
    /// Only taken by who holds the scheduler's lock, so it never waits. The host leaves at the end of the run.
    pub(crate) host: TicketLock<(Timeline, Option<H>)>,
    pub(crate) waiting: Waiting,
    pub(crate) spares: Spares,
    pub(crate) slots: Arc<[Slot]>,
    /// The duration is over, all its releases were made and all jobs ended.
    pub(crate) drained: AtomicBool,
    /// No release from then on, since the start.
    pub(crate) until_ns: u64,
    pub(crate) hung: AtomicU64,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Shared<C, H, L> {
    /// Fails the units of lanes whose bodies passed their bounds; their lanes start nothing until a spare comes.
    pub(crate) fn fail_overdue(&self, scheduler: &mut Scheduler<C>, now: Instant) {
        for (i, seat) in self.waiting.seats.iter().enumerate() {
            if self.spares.finds_overdue(seat) {
                // Its body may have come back at this very moment; then there is nothing to fail.
                let _failed = scheduler.fail(seat.running(), now);
                scheduler.retire_lane(LaneId::new(i as u8));
            }
        }
    }

    /// A spare takes its lane over. To be called under the lock, after [`Self::fail_overdue`].
    pub(crate) fn take_over(&self, scheduler: &mut Scheduler<C>, lane: usize, thread: u64) {
        if self.spares.takes_over(lane, &self.waiting.seats[lane], thread) {
            scheduler.restore_lane(LaneId::new(lane as u8));
        }
    }
}
