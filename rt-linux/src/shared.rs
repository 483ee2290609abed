//! What lanes share: the scheduler, the host, their seats, and who keeps the time.

use crate::clock::now_ns;
use crate::lane::NOBODY;
use crate::seat::Seat;
use crate::timeline::Timeline;
use crate::watchdog::Slot;
use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use red_core::{Capacity, Instant, LaneId, Scheduler};
use red_record::{Recorded, Tape};
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
    /// The duration is over, all its releases were made and all jobs ended.
    pub(crate) drained: AtomicBool,
    /// No release from then on, since the start.
    pub(crate) until_ns: u64,
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
    pub(crate) fn fail_overdue(&self, scheduler: &mut Recorded<'_, C>, now: Instant) {
        for (i, seat) in self.seats.iter().enumerate() {
            // Relaxed first: the flag is hardly ever set.
            if seat.overdue.load(Ordering::Relaxed) && seat.overdue.swap(false, Ordering::AcqRel) {
                // Its body may have come back at this very moment; then there is nothing to fail.
                let _failed = scheduler.fail(seat.running(), now);
                scheduler.retire_lane(LaneId::new(i as u8));
            }
        }
    }

    /// A spare takes its lane over. To be called under the lock, after [`Self::fail_overdue`].
    pub(crate) fn take_over(&self, scheduler: &mut Recorded<'_, C>, lane: usize, thread: u64) {
        let (bit, seat) = (1 << lane, &self.seats[lane]);
        // Acquire: the bit is set after the thread was. The thread that hung may come here too; it would take over
        // before the lane was retired.
        if self.spared.load(Ordering::Acquire) & bit != 0 && seat.threads.load(Ordering::Relaxed) == thread {
            self.spared.fetch_and(!bit, Ordering::AcqRel);
            // The lane was retired, so this is the unit that was failed then, or one before it.
            seat.discard();
            scheduler.restore_lane(LaneId::new(lane as u8));
        }
    }

    /// The lane waits: who has something for any lane may ring it.
    pub(crate) fn goes_idle(&self, lane: usize) {
        // SeqCst, as all that follows it in `wait`: see `pass_on` and `knock`.
        self.idle.fetch_or(1 << lane, Ordering::SeqCst);
    }

    /// The lane has something to do.
    pub(crate) fn leaves_idle(&self, lane: usize) {
        self.idle.fetch_and(!(1 << lane), Ordering::AcqRel);
    }

    /// Whether this lane keeps the time; it becomes the keeper if nobody is.
    pub(crate) fn keep(&self, lane: usize) -> bool {
        // Looked at first, because an exchange that fails takes the line from the others too.
        let keeper = match self.keeper.load(Ordering::SeqCst) {
            NOBODY => {
                let place = &self.keeper;
                match place.compare_exchange(NOBODY, lane as u32, Ordering::SeqCst, Ordering::SeqCst) {
                    Ok(_) => lane as u32,
                    Err(other) => other,
                }
            }
            keeper => keeper,
        };
        keeper == lane as u32
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
        // Only the keeper itself gives its place up.
        let keeper = self.keeper.load(Ordering::Acquire);
        if keeper == me as u32 {
            // SeqCst, here and in `ring_idle`: a lane that goes idle sets its bit and then looks for a keeper, this
            // lane gives the place up and then looks at the bits. In the one order of all four, either that lane
            // finds the place free or this one finds its bit.
            self.keeper.store(NOBODY, Ordering::SeqCst);
        }
        if keeper == me as u32 || keeper == NOBODY {
            self.ring_idle(!(1 << me));
        }
    }

    /// Rings a lane that waits, so that it takes a posted request; busy lanes look when they complete.
    pub(crate) fn knock(&self) {
        // SeqCst: either a lane that goes idle sees this, or its bit is seen below; as in `pass_on`.
        self.knock.store(true, Ordering::SeqCst);
        self.ring_idle(u32::MAX);
    }

    /// Whether somebody knocked since the last call.
    pub(crate) fn knocked(&self) -> bool {
        self.knock.load(Ordering::SeqCst) && self.knock.swap(false, Ordering::AcqRel)
    }

    /// Rings one of the lanes that wait.
    fn ring_idle(&self, among: u32) {
        let idle = self.idle.load(Ordering::SeqCst) & among;
        if let Some(seat) = self.seats.get(idle.trailing_zeros() as usize) {
            seat.bell.ring();
        }
    }
}
