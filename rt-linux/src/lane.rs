//! A lane: completes, decides, runs its own next unit without a context switch, and hands others theirs.
//!
//! One idle lane at a time keeps the time: it sleeps until the next release, tick or edit. The others sleep on
//! their bells. A lane that leaves for work rings another idle one, so that the time is kept whenever a lane is
//! free; while none is, every completion looks at the clock anyway.

use crate::allocations::arm;
use crate::bell::Woken;
use crate::handler::{Handler, Work};
use crate::report::LaneFigures;
use crate::setup::Fifo;
use crate::shared::Shared;
use crate::sleeper::Sleeper;
use crate::timeline::Host;
use crate::usage::Usage;
use crate::watchdog::Bound;
use core::sync::atomic::Ordering;
use red_core::sync::Exclusive;
use red_core::{Action, Capacity, Instant, LaneId, Scheduler, UnitId};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Bound of a body: this many times its WCET, and a fixed part.
const BOUND_TIMES: u64 = 10;
const BOUND_PLUS_NS: u64 = 100_000_000;
/// Nobody keeps the time.
pub(crate) const NOBODY: u32 = u32::MAX;

pub(crate) struct Lane<'a, C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) shared: &'a Shared<C, H, L>,
    pub(crate) number: usize,
    /// Which thread of this lane it is; a spare is a later one.
    pub(crate) thread: u64,
    pub(crate) fifo: Option<Fifo>,
    pub(crate) figures: LaneFigures,
    pub(crate) sleeper: Sleeper,
    pub(crate) handler: Box<dyn Handler>,
}

/// What a lane does next.
enum Next {
    Run(UnitId, Work),
    Idle,
    Leave,
}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>>> Lane<'_, C, H, L> {
    /// Until the run stops, or this thread was replaced.
    pub(crate) fn run(&mut self) {
        self.figures.baseline = Usage::of_thread();
        arm(true);
        let mut next = self.session(None);
        loop {
            next = match next {
                Next::Run(unit, work) => {
                    let (ok, alive) = self.execute(&work);
                    if !alive {
                        break;
                    }
                    self.session(Some((unit, ok)))
                }
                Next::Idle => self.wait(),
                Next::Leave => break,
            };
        }
        arm(false);
        let used = Usage::of_thread().since(self.figures.baseline);
        self.figures.faults += used.minor_faults + used.major_faults;
    }

    /// Runs a body under the watchdog. Whether it succeeded, and whether this thread is still the lane's.
    fn execute(&mut self, work: &Work) -> (bool, bool) {
        let shared = self.shared;
        let start = shared.now();
        self.figures.dispatched(start.saturating_sub(work.since_ns));
        self.figures.units += 1;
        let bound = work.wcet_ns.saturating_mul(BOUND_TIMES).saturating_add(BOUND_PLUS_NS);
        shared.slots[self.number].arm(shared.origin_ns.saturating_add(start).saturating_add(bound));
        arm(false);
        // A panic is the body's own: the handler of another node does not see what it left behind.
        let result = catch_unwind(AssertUnwindSafe(|| self.handler.run(work)));
        arm(true);
        let end = shared.now();
        let took = end.saturating_sub(start);
        self.figures.nodes_missed += u64::from(end > work.sub_deadline_ns);
        self.figures.busy_ns += took;
        self.figures.overruns += u64::from(took > work.wcet_ns);
        let ok = matches!(result, Ok(Ok(())));
        self.figures.failed += u64::from(!ok);
        if shared.slots[self.number].disarm() == Bound::Passed {
            // The job was given up and a spare may have taken the lane; it goes on only if that failed.
            let replaced = shared.seats[self.number].threads.load(Ordering::Acquire) != self.thread;
            let back = !replaced && self.fifo.is_none_or(|fifo| fifo.apply().is_ok());
            return (ok, back);
        }
        (ok, true)
    }

    /// One turn with the scheduler: report, apply what is due, decide, hand out.
    fn session(&mut self, done: Option<(UnitId, bool)>) -> Next {
        let shared = self.shared;
        let begin = shared.now();
        let me = LaneId::new(self.number as u8);
        let (mine, wake) = shared.scheduler.with(|scheduler, requests| {
            shared.host.with(|(timeline, host)| {
                // A body that came back after the end of the run finds nobody any more.
                let Some(host) = host.as_mut() else { return (None, u64::MAX) };
                // Read under the lock, so that time goes the way of the lock.
                let now = Instant::from_nanos(shared.now());
                let mut since = now.as_nanos();
                shared.fail_overdue(scheduler, now);
                if done.is_none() {
                    shared.take_over(scheduler, self.number);
                }
                match done {
                    // `Late` and `Stale` are the end of a unit whose job was given up meanwhile.
                    Some((unit, true)) => drop(scheduler.complete(unit, now)),
                    Some((unit, false)) => drop(scheduler.fail(unit, now)),
                    None => {}
                }
                while let Some(outcome) = scheduler.take_outcome() {
                    host.ended(&outcome);
                }
                host.due(scheduler, now);
                while let Some(request) = requests.next() {
                    let taken = scheduler.release_at(request.task, request.at, request.capture, now);
                    host.released(
                        request.task.index(),
                        request.at,
                        taken != Err(red_core::ReleaseError::Full),
                    );
                    since = since.min(request.at.as_nanos());
                }
                since = since.min(timeline.release(scheduler, host, now).unwrap_or(u64::MAX));
                let mut mine = None;
                while let Some(action) = scheduler.poll_on(me, now) {
                    match action {
                        Action::Dispatch(d) => {
                            let Some(unit) = scheduler.unit(d.unit) else { continue };
                            // A lane that was busy until now could not have started anything earlier.
                            let busy = d.lane == me && done.is_some();
                            let work = Work::of(&unit, if busy { now.as_nanos() } else { since });
                            if d.lane == me {
                                shared.seats[self.number].keep(d.unit);
                                mine = Some((d.unit, work));
                            } else {
                                shared.seats[d.lane.index()].hand(d.unit, &work);
                            }
                        }
                        Action::Ended(outcome) => host.ended(&outcome),
                        _ => {}
                    }
                }
                while let Some(event) = scheduler.take_event() {
                    host.event(&event);
                }
                shared.jobs.store(scheduler.jobs_in_flight() as u32, Ordering::Relaxed);
                let wake = [timeline.next_at(), host.next_at(), scheduler.poll_at().map(Instant::as_nanos)];
                (mine, wake.into_iter().flatten().min().unwrap_or(u64::MAX))
            })
        });
        let before = shared.wake_at.swap(wake, Ordering::AcqRel);
        if wake < before {
            shared.ring_keeper(self.number);
        }
        self.figures.deciding_ns += shared.now().saturating_sub(begin);
        match mine {
            Some((unit, work)) => Next::Run(unit, work),
            None => Next::Idle,
        }
    }

    /// Sleeps until there is a unit, the clock says so, or the run ends.
    fn wait(&mut self) -> Next {
        let shared = self.shared;
        let seat = &shared.seats[self.number];
        let bit = 1 << self.number;
        shared.idle.fetch_or(bit, Ordering::AcqRel);
        let next = loop {
            if let Some((unit, work)) = seat.take() {
                break Next::Run(unit, work);
            }
            if shared.stopping.load(Ordering::Acquire) || seat.threads.load(Ordering::Acquire) != self.thread
            {
                break Next::Leave;
            }
            let keeps = shared.keep(self.number);
            let wake = shared.wake_at.load(Ordering::Acquire);
            let until = (keeps && wake != u64::MAX).then(|| shared.origin_ns.saturating_add(wake));
            match self.sleeper.wait(&seat.bell, until, shared.spin_ns) {
                Woken::Rung => {}
                Woken::TimedOut => {
                    if let Some((unit, work)) = seat.take() {
                        break Next::Run(unit, work);
                    }
                    shared.idle.fetch_and(!bit, Ordering::AcqRel);
                    match self.session(None) {
                        Next::Idle => shared.idle.fetch_or(bit, Ordering::AcqRel),
                        other => break other,
                    };
                }
            }
            if shared.knock.swap(false, Ordering::AcqRel) {
                // Somebody outside posted a request.
                shared.idle.fetch_and(!bit, Ordering::AcqRel);
                match self.session(None) {
                    Next::Idle => shared.idle.fetch_or(bit, Ordering::AcqRel),
                    other => break other,
                };
            }
        };
        shared.idle.fetch_and(!bit, Ordering::AcqRel);
        shared.pass_on(self.number);
        next
    }
}
