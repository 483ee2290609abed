//! How lanes wait: one keeps the time, and none sleeps while there is something to do.
//!
//! # Protocol
//!
//! One idle lane at a time keeps the time: it sleeps until the next release, tick or edit. The others sleep on
//! their bells. A lane that leaves for work rings another idle one, so that the time is kept whenever a lane is
//! free; while none is, every completion looks at the clock anyway.
//!
//! A request from outside is a knock and a ring for one of the idle lanes. Busy lanes look when they complete.

use crate::bell::Woken;
use crate::handler::Work;
use crate::primitive::{AtomicBool, AtomicU32, AtomicU64, Ordering, now_ns};
use crate::seat::Seat;
use crate::sleeper::Sleeper;
use crate::stream_seat::{Ahead, StreamSeat};
use std::sync::Arc;

/// Nobody keeps the time.
const NOBODY: u32 = u32::MAX;

/// What a lane does next.
#[derive(Debug)]
pub enum Next {
    /// From this time of the run on.
    Run(Work, u64),
    /// What was handed ahead for the lane's stream.
    Stream,
    /// Wait until there is something.
    Idle,
    /// The run ends.
    Leave,
}

/// What waiting lanes share, and those that wake them.
#[derive(Debug)]
pub struct Waiting {
    /// The lanes' places.
    pub seats: Vec<Seat>,
    /// Of lanes whose handlers have a stream, where units are handed ahead.
    pub streams: Vec<Option<Arc<StreamSeat>>>,
    /// Start of the run, in nanoseconds of `CLOCK_MONOTONIC`.
    origin_ns: AtomicU64,
    spin_ns: u64,
    stopping: AtomicBool,
    /// A request was posted from outside.
    knock: AtomicBool,
    /// Lanes that wait, a bit each.
    idle: AtomicU32,
    /// The idle lane that keeps the time.
    keeper: AtomicU32,
    /// Next instant of the clock, since the start.
    wake_at: AtomicU64,
    jobs: AtomicU32,
}

impl Waiting {
    /// Lanes that spin so long before they sleep; those of `streams`, a bit each, have one. The run starts now, or with [`Self::begin`].
    #[must_use]
    pub fn new(lanes: usize, streams: u32, spin_ns: u64) -> Self {
        let has_stream = |lane: usize| streams.checked_shr(lane as u32).unwrap_or(0) & 1 != 0;
        Self {
            seats: (0..lanes).map(|_| Seat::default()).collect(),
            streams: (0..lanes).map(|lane| has_stream(lane).then(Arc::default)).collect(),
            origin_ns: AtomicU64::new(now_ns()),
            spin_ns,
            stopping: AtomicBool::new(false),
            knock: AtomicBool::new(false),
            idle: AtomicU32::new(0),
            keeper: AtomicU32::new(NOBODY),
            wake_at: AtomicU64::new(u64::MAX),
            jobs: AtomicU32::new(0),
        }
    }

    /// The run starts now. To be called before any lane goes: it tells when.
    pub fn begin(&self) {
        // Relaxed: what tells lanes to go publishes it.
        self.origin_ns.store(now_ns(), Ordering::Relaxed);
    }

    /// Start of the run, in nanoseconds of `CLOCK_MONOTONIC`.
    #[must_use]
    pub fn origin_ns(&self) -> u64 {
        self.origin_ns.load(Ordering::Relaxed)
    }

    /// Nanoseconds since the start of the run.
    pub fn now(&self) -> u64 {
        now_ns().saturating_sub(self.origin_ns())
    }

    /// How long lanes spin before they sleep.
    #[must_use]
    pub const fn spin_ns(&self) -> u64 {
        self.spin_ns
    }

    /// Asks all lanes to leave.
    pub fn stop(&self) {
        // Relaxed: the rings publish it to those who sleep, and the others look again.
        self.stopping.store(true, Ordering::Relaxed);
        self.seats.iter().for_each(|seat| seat.bell.ring());
    }

    /// Whether a stop was asked for.
    pub fn is_stopping(&self) -> bool {
        self.stopping.load(Ordering::Relaxed)
    }

    /// When the clock brings something next, and how many jobs are in flight. To be called under the scheduler's
    /// lock, so that an older answer never replaces a newer one. Whether that instant came nearer: then
    /// [`Self::ring_keeper`] has to follow.
    pub fn plan(&self, wake_at: u64, jobs: usize) -> bool {
        self.jobs.store(jobs as u32, Ordering::Relaxed);
        // Relaxed: `ring_keeper` publishes it where it matters.
        wake_at < self.wake_at.swap(wake_at, Ordering::Relaxed)
    }

    /// Sleeps until there is a unit, the clock says so, or the run ends. `turn` is one turn with the scheduler.
    pub fn wait(&self, lane: usize, sleeper: &mut Sleeper, mut turn: impl FnMut() -> Next) -> Next {
        let seat = &self.seats[lane];
        self.goes_idle(lane);
        let next = loop {
            // First, so that what was handed to a lane that had not begun it is left when a stop is asked for.
            if self.is_stopping() {
                break Next::Leave;
            }
            if let Some(work) = seat.take() {
                break Next::Run(work, self.now());
            }
            if self.streams[lane].as_ref().is_some_and(|stream| stream.is_handed()) {
                break Next::Stream;
            }
            if !self.knocked() {
                let keeps = self.keep(lane);
                let wake = self.wake_at.load(Ordering::Relaxed);
                let until = (keeps && wake != u64::MAX).then(|| self.origin_ns().saturating_add(wake));
                // Units come from lanes that run some: without a job in flight, there is nothing to spin for.
                let spin_ns = if self.jobs.load(Ordering::Relaxed) == 0 { 0 } else { self.spin_ns };
                if seat.sleep(sleeper, until, spin_ns) == Woken::Rung {
                    continue;
                }
                // What the turn at `wake` needs has left the caches while others ran. A turn now, in the lead
                // that would be spun anyway, brings it back.
                match turn() {
                    Next::Idle if self.wake_at.load(Ordering::Relaxed) != wake => continue,
                    Next::Idle => {}
                    other => break other,
                }
                if until.is_some_and(|at_ns| seat.spin(at_ns) == Woken::Rung) {
                    continue;
                }
            }
            self.leaves_idle(lane);
            match turn() {
                Next::Idle => self.goes_idle(lane),
                other => break other,
            }
        };
        self.leaves_idle(lane);
        self.pass_on(lane);
        next
    }

    /// The next instant moved: the keeper must look again.
    pub fn ring_keeper(&self, me: usize) {
        // A read-modify-write that changes nothing, because a plain load may be older than the next keeper's claim.
        // Release: partner of the Acquire in `keep`, so that a keeper that comes later has seen the instant.
        let keeper = self.keeper.fetch_or(0, Ordering::Release);
        match self.seats.get(keeper as usize) {
            Some(seat) if keeper as usize != me => seat.bell.ring(),
            Some(_) => {}
            None => self.pass_on(me),
        }
    }

    /// Rings a lane that waits, so that it takes a posted request; busy lanes look when they complete.
    pub fn knock(&self) {
        // Release: partner of the Acquire in `knocked`. A read-modify-write, also when somebody knocked already: it
        // continues the release sequence, so that who takes both knocks sees both requests.
        self.knock.swap(true, Ordering::Release);
        self.ring_idle(u32::MAX);
    }

    /// Hands a unit to a lane that runs nothing. To be called under the scheduler's lock.
    pub fn hand(&self, lane: usize, work: &Work) {
        if self.streams[lane].is_some() {
            // By the way of the units that go ahead, which would overtake it by another one.
            self.hand_ahead(lane, &Ahead::at_once(*work));
        } else {
            self.seats[lane].hand(work);
        }
    }

    /// Hands a unit to a lane with a stream. To be called under the scheduler's lock.
    pub fn hand_ahead(&self, lane: usize, ahead: &Ahead) {
        if let Some(stream) = &self.streams[lane] {
            stream.hand(ahead);
            self.seats[lane].bell.ring();
        }
    }

    /// Whether somebody knocked since the last call.
    fn knocked(&self) -> bool {
        // Acquire: partner of the Release in `knock`.
        self.knock.load(Ordering::Relaxed) && self.knock.swap(false, Ordering::Acquire)
    }

    /// The lane waits: who has something for any lane may ring it.
    fn goes_idle(&self, lane: usize) {
        // Acquire: partner of the Release in `ring_idle`.
        self.idle.fetch_or(1 << lane, Ordering::Acquire);
    }

    /// The lane has something to do.
    fn leaves_idle(&self, lane: usize) {
        // Acquire: partner of the Release in `ring_idle`, for `pass_on`.
        self.idle.fetch_and(!(1 << lane), Ordering::Acquire);
    }

    /// Whether this lane keeps the time; it becomes the keeper if nobody is.
    fn keep(&self, lane: usize) -> bool {
        // Looked at first, because an exchange that fails takes the line from the others too.
        let keeper = match self.keeper.load(Ordering::Relaxed) {
            NOBODY => {
                let place = &self.keeper;
                // Acquire: partner of the Release in `ring_keeper`.
                match place.compare_exchange(NOBODY, lane as u32, Ordering::Acquire, Ordering::Relaxed) {
                    Ok(_) => lane as u32,
                    Err(other) => other,
                }
            }
            keeper => keeper,
        };
        keeper == lane as u32
    }

    /// The lane does not wait any more: another idle one is rung for what this one does not do now.
    fn pass_on(&self, me: usize) {
        // Only the keeper itself gives its place up.
        let keeper = self.keeper.load(Ordering::Relaxed);
        if keeper == me as u32 {
            // A read-modify-write, which continues the release sequence of `ring_keeper`.
            self.keeper.swap(NOBODY, Ordering::Relaxed);
        }
        // Who knocked may have rung this lane, which took a unit instead.
        if keeper == me as u32 || keeper == NOBODY || self.knock.load(Ordering::Relaxed) {
            self.ring_idle(!(1 << me));
        }
    }

    /// The lane's thread has ended without leaving: what it was to keep falls to the others.
    pub fn bury(&self, lane: usize) {
        self.leaves_idle(lane);
        self.pass_on(lane);
        self.rouse_idle();
    }

    /// A look from outside, for wake-ups that got lost on their way: wakes every lane that waits where something is
    /// due for longer than `patience_ns`, or somebody knocked.
    pub fn look_after(&self, patience_ns: u64) {
        // Relaxed: what is missed now is seen at the next look.
        let is_due = self.wake_at.load(Ordering::Relaxed) < self.now().saturating_sub(patience_ns);
        if is_due || self.knock.load(Ordering::Relaxed) {
            self.rouse_idle();
        }
    }

    /// Wakes every lane that waits, also one whose wake-up was lost.
    fn rouse_idle(&self) {
        // Relaxed: a guess, and a lane that is not meant only looks once more.
        let idle = self.idle.load(Ordering::Relaxed);
        let waits = |lane: &usize| idle >> lane & 1 == 1;
        (0..self.seats.len()).filter(waits).for_each(|lane| self.seats[lane].bell.rouse());
    }

    /// Rings one of the lanes that wait.
    fn ring_idle(&self, among: u32) {
        // A read-modify-write that changes nothing, so that it has its place in the one order of this word. A lane
        // that goes idle afterwards sees what this thread wrote before, and looks for it; the bit of one that went
        // idle before is seen here. Release: partner of the Acquire in `goes_idle` and `leaves_idle`.
        let idle = self.idle.fetch_or(0, Ordering::Release) & among;
        if let Some(seat) = self.seats.get(idle.trailing_zeros() as usize) {
            seat.bell.ring();
        }
    }
}
