//! What lanes share: the scheduler, the host, and how they wait for each other.

use crate::oversight::Standstills;
use crate::spares::Spares;
use crate::timeline::Timeline;
use crate::waiting::Waiting;
use crate::watchdog::Slot;
use core::sync::atomic::{AtomicBool, AtomicU64};
use red_core::{Capacity, Instant, LaneId, Scheduler};
use red_record::{Recorder, Tape};
use red_sync::{Exclusive, SharedScheduler, TicketLock};
use std::sync::Arc;

/// Producers outside of the lanes, and requests that each may have under way.
const PRODUCERS: usize = 8;
pub(crate) const DEPTH: usize = 64;

/// What goes with the scheduler.
pub(crate) struct Held<H> {
    pub(crate) timeline: Timeline,
    /// Leaves at the end of the run.
    pub(crate) host: Option<H>,
    /// Of a run that is recorded; leaves at its end.
    pub(crate) tape: Option<Tape>,
}

/// What lanes share.
pub(crate) struct Shared<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) scheduler: SharedScheduler<C, L, PRODUCERS, DEPTH>,
    /// Only taken by who holds the scheduler's lock, so it never waits.
    pub(crate) host: TicketLock<Held<H>>,
    pub(crate) waiting: Waiting,
    pub(crate) spares: Spares,
    pub(crate) slots: Arc<[Slot]>,
    /// The duration is over, all its releases were made and all jobs ended.
    pub(crate) drained: AtomicBool,
    /// No release from then on, since the start.
    pub(crate) until_ns: u64,
    pub(crate) hung: AtomicU64,
    pub(crate) standstills: Standstills,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Shared<C, H, L> {
    /// The lane's thread does not come back. To be called by others than lanes: some lane fails what it ran; where none
    /// is left, its spare does it.
    pub(crate) fn lose(&self, lane: usize) {
        self.spares.lose(lane, &self.waiting.seats[lane]);
        self.waiting.knock();
    }

    /// Fails the units of lanes whose bodies passed their bounds; their lanes start nothing until a spare comes.
    pub(crate) fn fail_overdue(&self, scheduler: &mut Recorder<'_, C>, now: Instant) {
        for (i, seat) in self.waiting.seats.iter().enumerate() {
            if self.spares.finds_overdue(seat) {
                // Its body may have come back at this very moment; then there is nothing to fail.
                let _failed = scheduler.fail(seat.running(), now);
                scheduler.retire_lane(LaneId::new(i as u8));
            }
        }
    }

    /// A spare takes its lane over. To be called under the lock, after [`Self::fail_overdue`].
    pub(crate) fn take_over(&self, scheduler: &mut Recorder<'_, C>, lane: usize, thread: u64) {
        if self.spares.takes_over(lane, &self.waiting.seats[lane], thread) {
            scheduler.restore_lane(LaneId::new(lane as u8));
        }
    }
}
