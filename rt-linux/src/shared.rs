//! What lanes share: the scheduler, the host, and how they wait for each other.

use crate::control::Letter;
use crate::errands::Errands;
use crate::handler::Work;
use crate::on_stream::Leaves;
use crate::spares::Spares;
use crate::standstills::Standstills;
use crate::stop::Stopper;
use crate::stream_seat::Ahead;
use crate::timeline::{Host, Timeline, release_one};
use crate::waiting::Waiting;
use crate::watchdog::{Armed, Slot};
use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use red_core::{Capacity, Dispatch, Instant, LaneId, PoolId, Scheduler, UnitId};
use red_record::{Recorder, Tape};
use red_sync::{Exclusive, Requests, SharedScheduler, TicketLock};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration;

/// Producers outside of the lanes, and requests that each may have under way.
pub(crate) const PRODUCERS: usize = 8;
pub(crate) const DEPTH: usize = 64;
/// Looks for a request that is being posted when the run ends; a thread that was killed meanwhile never ends that.
const POST_LOOKS: u32 = 100;
const POST_LOOK: Duration = Duration::from_millis(1);

/// What goes with the scheduler.
pub(crate) struct Held<H> {
    pub(crate) timeline: Timeline,
    /// Leaves at the end of the run.
    pub(crate) host: Option<H>,
    /// Of a run that is recorded; leaves at its end.
    pub(crate) tape: Option<Tape>,
    /// Standstills that the scheduler was told of, in nanoseconds.
    pub(crate) stood_ns: u64,
}

/// What lanes share.
pub(crate) struct Shared<C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) scheduler: SharedScheduler<C, L, PRODUCERS, DEPTH>,
    /// Only taken by who holds the scheduler's lock, so it never waits.
    pub(crate) host: TicketLock<Held<H>>,
    pub(crate) waiting: Waiting,
    /// What other threads want done under the lock.
    pub(crate) errands: Errands<Letter<C>>,
    /// One of them asks at a time. No lane takes this.
    pub(crate) askers: Mutex<()>,
    pub(crate) stopper: Arc<Stopper>,
    pub(crate) spares: Spares,
    pub(crate) slots: Arc<[Slot]>,
    /// The duration is over, all its releases were made and all jobs ended.
    pub(crate) drained: AtomicBool,
    /// No release from then on, since the start.
    pub(crate) until_ns: u64,
    pub(crate) hung: AtomicU64,
    /// Lanes that left their streams, a bit each.
    pub(crate) left: AtomicU32,
    /// Pools that are lost, a bit each.
    pub(crate) pools_lost: AtomicU32,
    /// Units that were dispatched ahead.
    pub(crate) ahead: AtomicU64,
    pub(crate) standstills: Standstills,
}

impl<C: Capacity, H, L: Exclusive<Scheduler<C>>> Shared<C, H, L> {
    /// What lanes share that spin for so long before they sleep.
    #[expect(clippy::boxed_local, reason = "it is large, and moved once")]
    pub(crate) fn new(
        scheduler: Box<Scheduler<C>>,
        held: Held<H>,
        streams: u32,
        until_ns: u64,
        spin_ns: u64,
        stopper: Arc<Stopper>,
    ) -> Arc<Self> {
        let lanes = scheduler.lanes();
        Arc::new(Self {
            scheduler: SharedScheduler::new(*scheduler),
            host: TicketLock::new(held),
            waiting: Waiting::new(lanes, streams, spin_ns),
            errands: Errands::default(),
            askers: Mutex::new(()),
            stopper,
            spares: Spares::default(),
            slots: (0..lanes).map(|_| Slot::new()).collect(),
            drained: AtomicBool::new(false),
            until_ns,
            hung: AtomicU64::new(0),
            left: AtomicU32::new(0),
            pools_lost: AtomicU32::new(0),
            ahead: AtomicU64::new(0),
            standstills: Standstills::default(),
        })
    }

    /// Shows the watchdog until when what a lane begins at `start` has to be over.
    pub(crate) fn watched(&self, lane: usize, start: u64, bound_ns: u64) -> Armed {
        let begin = self.waiting.origin_ns().saturating_add(start);
        self.slots[lane].arm(begin.saturating_sub(self.standstills.total_ns()).saturating_add(bound_ns))
    }

    /// When a lane last took a turn, on `CLOCK_MONOTONIC`.
    pub(crate) fn last_turn_ns(&self) -> u64 {
        self.slots.iter().map(Slot::turned_ns).max().unwrap_or(0)
    }

    /// Lanes leave, and who waits for one is told. Async-signal-safe and wait-free.
    pub(crate) fn end(&self) {
        self.waiting.stop();
        self.errands.close();
    }

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
                for unit in self.waiting.streams[i].iter().flat_map(|stream| stream.units()) {
                    let _failed = scheduler.fail(unit, now);
                }
                scheduler.retire_lane(LaneId::new(i as u8));
            }
        }
    }

    /// Whether no request comes any more: none is accepted from `now` on, and nobody is about to post one that was. To
    /// be called before what there is is taken.
    pub(crate) fn is_closed(&self, now: Instant) -> bool {
        now.as_nanos() >= self.until_ns
            && (0..PRODUCERS).all(|producer| self.scheduler.producer(producer).is_some())
    }

    /// To be called once no request is accepted any more: waits for those that were when they were about to be posted.
    pub(crate) fn wait_for_posts(&self) {
        for producer in 0..PRODUCERS {
            for _ in 0..POST_LOOKS {
                if self.scheduler.producer(producer).is_some() {
                    break;
                }
                thread::sleep(POST_LOOK);
            }
        }
    }

    /// A spare takes its lane over. To be called under the lock, after [`Self::fail_overdue`].
    pub(crate) fn take_over(&self, scheduler: &mut Recorder<'_, C>, lane: usize, thread: u64) {
        if self.spares.takes_over(lane, &self.waiting.seats[lane], thread) {
            self.waiting.streams[lane].iter().for_each(|stream| stream.discard());
            scheduler.restore_lane(LaneId::new(lane as u8));
        }
    }

    /// Hands a unit to a lane for its stream, with what it waits for.
    pub(crate) fn hand_ahead(&self, scheduler: &Recorder<'_, C>, given: Dispatch) {
        let lane = given.lane.index();
        let Some(unit) = scheduler.unit(given.unit) else { return };
        let now = scheduler.now().as_nanos();
        let wcet_of = |unit| scheduler.unit(unit).map_or(0, |unit| unit.wcet.as_nanos());
        let after = scheduler.waits_for(given.unit).map(|unit| (unit, wcet_of(unit)));
        self.waiting.hand_ahead(lane, &Ahead::new(Work::of(given.unit, &unit, now), after));
        self.ahead.fetch_add(1, Ordering::Relaxed);
    }

    /// The stream of a lane is left: what it was given fails, and the lane is given nothing any more.
    pub(crate) fn leave_stream(
        &self,
        scheduler: &mut Recorder<'_, C>,
        lane: usize,
        given: impl Iterator<Item = UnitId>,
        (pool, why): (PoolId, Leaves),
        now: Instant,
    ) {
        let handed = self.waiting.streams[lane].iter().flat_map(|stream| stream.units());
        for unit in given.chain(handed) {
            let _stale = scheduler.fail(unit, now);
        }
        self.waiting.streams[lane].iter().for_each(|stream| stream.discard());
        scheduler.retire_lane(LaneId::new(lane as u8));
        let left = self.left.fetch_or(1 << lane, Ordering::Relaxed) | 1 << lane;
        let is_of_pool = |other: &usize| scheduler.pool_of(LaneId::new(*other as u8)) == Some(pool);
        let of_pool = (0..self.slots.len()).filter(is_of_pool).fold(0_u32, |set, other| set | 1 << other);
        if (why == Leaves::Lost || of_pool & !left == 0) && scheduler.lose_pool(pool, now) {
            self.pools_lost.fetch_or(1 << pool.index(), Ordering::Relaxed);
            // They are given nothing from now on.
            self.left.fetch_or(of_pool, Ordering::Relaxed);
        }
        self.hung.fetch_add((why == Leaves::Hangs).into(), Ordering::Relaxed);
    }
}

/// Releases what was asked for from outside. When the first of it was, in nanoseconds; at the end of time for nothing.
pub(crate) fn take_requests<C: Capacity>(
    scheduler: &mut Recorder<'_, C>,
    requests: &mut Requests<'_, DEPTH>,
    host: &mut impl Host<C>,
    now: Instant,
) -> u64 {
    let mut first = u64::MAX;
    while let Some(request) = requests.next() {
        release_one(scheduler, host, (request.task, request.at), request.capture, request.at, now);
        first = first.min(request.at.as_nanos());
    }
    first
}
