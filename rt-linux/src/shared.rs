//! What lanes share: the scheduler, the host, their seats, and who keeps the time.

use crate::clock::now_ns;
use crate::lane::NOBODY;
use crate::seat::Seat;
use crate::timeline::Timeline;
use crate::watchdog::Slot;
use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use red_core::sync::{Exclusive, TicketLock};
use red_core::{Capacity, Instant, LaneId, Scheduler, SharedScheduler};
use std::sync::Arc;

/// Producers outside of the lanes, and requests that each may have under way.
const PRODUCERS: usize = 8;
const DEPTH: usize = 64;

/// What lanes share.
pub(crate) struct Shared<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) scheduler: SharedScheduler<C, L, PRODUCERS, DEPTH>,
    /// Only taken by who holds the scheduler's lock, so it never waits. The host leaves at the end of the run.
    pub(crate) host: TicketLock<(Timeline, Option<H>)>,
    pub(crate) seats: Vec<Seat>,
    pub(crate) slots: Arc<[Slot]>,
    pub(crate) stopping: AtomicBool,
    /// A request was posted from outside.
    pub(crate) knock: AtomicBool,
    /// Lanes that wait, a bit each.
    pub(crate) idle: AtomicU32,
    /// The idle lane that keeps the time.
    pub(crate) keeper: AtomicU32,
    /// Next instant of the clock, since the start.
    pub(crate) wake_at: AtomicU64,
    pub(crate) jobs: AtomicU32,
    pub(crate) origin_ns: u64,
    pub(crate) spin_ns: u64,
    pub(crate) hung: AtomicU64,
    /// Lanes whose threads are lost, a bit each, for the control thread.
    pub(crate) lost: AtomicU32,
    /// Lanes that got a spare, a bit each, for the next lane that has the lock.
    pub(crate) spared: AtomicU32,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Shared<C, H, L> {
    /// Nanoseconds since the start of the run.
    pub(crate) fn now(&self) -> u64 {
        now_ns().saturating_sub(self.origin_ns)
    }

    /// Fails the units of lanes whose bodies passed their bounds; their lanes start nothing until a spare comes.
    pub(crate) fn fail_overdue(&self, scheduler: &mut Scheduler<C>, now: Instant) {
        for (i, seat) in self.seats.iter().enumerate() {
            // Relaxed first: the flag is hardly ever set.
            if seat.overdue.load(Ordering::Relaxed) && seat.overdue.swap(false, Ordering::AcqRel) {
                // Its body may have come back at this very moment; then there is nothing to fail.
                let _failed = scheduler.fail(seat.running(), now);
                scheduler.retire_lane(LaneId::new(i as u8));
            }
        }
    }

    /// A spare thread takes its lane over.
    pub(crate) fn take_over(&self, scheduler: &mut Scheduler<C>, lane: usize) {
        let bit = 1 << lane;
        if self.spared.load(Ordering::Relaxed) & bit != 0 {
            self.spared.fetch_and(!bit, Ordering::AcqRel);
            scheduler.restore_lane(LaneId::new(lane as u8));
        }
    }

    /// Whether this lane keeps the time; it becomes the keeper if nobody is.
    pub(crate) fn keep(&self, lane: usize) -> bool {
        let lane = lane as u32;
        match self.keeper.compare_exchange(NOBODY, lane, Ordering::AcqRel, Ordering::Acquire) {
            Ok(_) => true,
            Err(keeper) => keeper == lane,
        }
    }

    /// The next instant moved: the keeper must look again.
    pub(crate) fn ring_keeper(&self, me: usize) {
        let keeper = self.keeper.load(Ordering::Acquire);
        match self.seats.get(keeper as usize) {
            Some(seat) if keeper as usize != me => seat.bell.ring(),
            Some(_) => {}
            None => self.pass_on(me),
        }
    }

    /// Gives up keeping the time; another idle lane is rung to take it.
    pub(crate) fn pass_on(&self, me: usize) {
        let mine = self.keeper.compare_exchange(me as u32, NOBODY, Ordering::AcqRel, Ordering::Acquire);
        if mine.is_ok() || mine == Err(NOBODY) {
            let others = self.idle.load(Ordering::Acquire) & !(1 << me);
            if others != 0
                && let Some(seat) = self.seats.get(others.trailing_zeros() as usize)
            {
                seat.bell.ring();
            }
        }
    }

    /// Rings a lane that waits, so that it takes a posted request; busy lanes look when they complete.
    pub(crate) fn knock(&self) {
        self.knock.store(true, Ordering::Release);
        let idle = self.idle.load(Ordering::Acquire);
        if let Some(seat) = self.seats.get(idle.trailing_zeros() as usize) {
            seat.bell.ring();
        }
    }
}
