//! A lane: completes, decides, runs its own next unit without a context switch, and hands others theirs.
//!
//! One idle lane at a time keeps the time: it sleeps until the next release, tick or edit. The others sleep on
//! their bells. A lane that leaves for work rings another idle one, so that the time is kept whenever a lane is
//! free; while none is, every completion looks at the clock anyway.

use crate::allocations::arm;
use crate::bell::Woken;
use crate::handler::{Handler, Work};
use crate::panics::{BodyPanic, caught};
use crate::report::LaneFigures;
use crate::setup::{Fifo, best_effort};
use crate::shared::{DEPTH, Shared};
use crate::sleeper::Sleeper;
use crate::timeline::{Host, Timeline};
use crate::usage::Usage;
use crate::watchdog::Bound;
use core::sync::atomic::Ordering;
use red_core::{Action, Capacity, Instant, LaneId, ReleaseError, Scheduler, UnitId};
use red_record::Recorded;
use red_sync::{Exclusive, Requests};

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
    /// From this time of the run on.
    Run(UnitId, Work, u64),
    Idle,
    Leave,
}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>>> Lane<'_, C, H, L> {
    /// Until the run stops, or this thread was replaced.
    pub(crate) fn run(&mut self) {
        self.handler.begin(self.shared.origin_ns);
        self.figures.baseline = Usage::of_thread();
        arm(true);
        let mut next = self.session(None, self.shared.now());
        loop {
            next = match next {
                Next::Run(unit, work, start) => match self.execute(&work, start) {
                    Some((ok, end)) => self.session(Some((unit, ok)), end),
                    None => {
                        // Out of the idle class, if that is allowed: a thread that starves while the kernel takes
                        // its stack apart would keep the lock of the whole address space.
                        let _unchanged = best_effort();
                        break;
                    }
                },
                Next::Idle => self.wait(),
                Next::Leave => break,
            };
        }
        arm(false);
        let used = Usage::of_thread().since(self.figures.baseline);
        self.figures.faults += used.minor_faults + used.major_faults;
    }

    /// Runs a body under the watchdog. Whether it succeeded, and when it ended; `None` if the lane has got another
    /// thread meanwhile.
    fn execute(&mut self, work: &Work, start: u64) -> Option<(bool, u64)> {
        let shared = self.shared;
        self.figures.dispatched(start.saturating_sub(work.since_ns));
        self.figures.units += 1;
        let bound = work.wcet_ns.saturating_mul(BOUND_TIMES).saturating_add(BOUND_PLUS_NS);
        shared.slots[self.number].arm(shared.origin_ns.saturating_add(start).saturating_add(bound));
        arm(false);
        let result = caught(|| self.handler.run(work));
        arm(true);
        let end = shared.now();
        let took = end.saturating_sub(start);
        self.figures.nodes_missed += u64::from(end > work.sub_deadline_ns);
        self.figures.busy_ns += took;
        self.figures.overruns += u64::from(took > work.wcet_ns);
        let ok = matches!(result, Ok(Ok(())));
        self.figures.failed += u64::from(!ok);
        if let Err(message) = result {
            self.figures.panicked(BodyPanic { task: work.task, node: work.node, job: work.job, message });
        }
        // Asked before and after, because the slot of a thread that was replaced is the spare's. Such a thread was
        // demoted and must not take the lock: the spare would spin for it on the CPU that it needs.
        let is_replaced = || shared.seats[self.number].threads.load(Ordering::Acquire) != self.thread;
        if is_replaced() {
            return None;
        }
        let bound = shared.slots[self.number].disarm();
        // The job was given up. The thread goes on, at its own priority again, until a spare has come.
        let has_to_leave = bound == Bound::Passed && self.fifo.is_some_and(|fifo| fifo.apply().is_err());
        if has_to_leave || is_replaced() {
            return None;
        }
        Some((ok, end))
    }

    /// One turn with the scheduler, from `begin` on: report, apply what is due, decide, hand out. Once a stop was asked
    /// for, only the report.
    fn session(&mut self, done: Option<(UnitId, bool)>, begin: u64) -> Next {
        let shared = self.shared;
        let turn = shared.scheduler.with(|scheduler, requests| {
            shared.host.with(|held| {
                // A body that came back after the end of the run finds nobody any more.
                let host = held.host.as_mut()?;
                let scheduler = &mut Recorded::new(scheduler, held.tape.as_mut());
                // Read under the lock, so that time goes the way of the lock.
                let now = Instant::from_nanos(shared.now());
                self.report(scheduler, host, done, now);
                let goes_on = !shared.stopping.load(Ordering::Acquire);
                let turn = goes_on
                    .then(|| self.decide(scheduler, requests, &mut held.timeline, host, done.is_some(), now));
                while let Some(event) = scheduler.take_event() {
                    host.event(event);
                }
                turn
            })
        });
        if turn.is_some_and(|(_, is_sooner)| is_sooner) {
            shared.ring_keeper(self.number);
        }
        let end = shared.now();
        self.figures.deciding_ns += end.saturating_sub(begin);
        match turn {
            Some((Some((unit, work)), _)) => Next::Run(unit, work, end),
            Some((None, _)) => Next::Idle,
            None => Next::Leave,
        }
    }

    /// What ended, and which lanes were lost or got a spare.
    fn report(
        &self,
        scheduler: &mut Recorded<'_, C>,
        host: &mut H,
        done: Option<(UnitId, bool)>,
        now: Instant,
    ) {
        self.shared.fail_overdue(scheduler, now);
        if done.is_none() {
            self.shared.take_over(scheduler, self.number, self.thread);
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
    }

    /// Releases what is due and fills the lanes. This lane's unit, and whether the clock's next instant came nearer.
    fn decide(
        &self,
        scheduler: &mut Recorded<'_, C>,
        requests: &mut Requests<'_, DEPTH>,
        timeline: &mut Timeline,
        host: &mut H,
        was_busy: bool,
        now: Instant,
    ) -> (Option<(UnitId, Work)>, bool) {
        let (shared, me) = (self.shared, LaneId::new(self.number as u8));
        let mut since = now.as_nanos();
        host.due(scheduler, now);
        while let Some(request) = requests.next() {
            let taken = scheduler.release_at(request.task, request.at, request.capture, now);
            host.released(request.task.index(), request.at, taken != Err(ReleaseError::Full));
            since = since.min(request.at.as_nanos());
        }
        since = since.min(timeline.release(scheduler, host, now).unwrap_or(u64::MAX));
        let mut mine = None;
        while let Some(action) = scheduler.poll_on(me, now) {
            match action {
                Action::Dispatch(d) => {
                    let Some(unit) = scheduler.unit(d.unit) else { continue };
                    // A lane that was busy until now could not have started anything earlier.
                    let busy = d.lane == me && was_busy;
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
        let jobs = scheduler.jobs_in_flight();
        shared.jobs.store(jobs as u32, Ordering::Relaxed);
        // Requests are refused from the end on, and those from before it are out of the mailbox.
        shared.drained.store(jobs == 0 && timeline.is_over(now.as_nanos()), Ordering::Relaxed);
        let wake =
            [timeline.wake_at(now.as_nanos()), host.next_at(), scheduler.poll_at().map(Instant::as_nanos)];
        let wake = wake.into_iter().flatten().min().unwrap_or(u64::MAX);
        // Written under the lock, so that an older answer never replaces a newer one.
        let before = shared.wake_at.swap(wake, Ordering::AcqRel);
        (mine, wake < before)
    }

    /// Sleeps until there is a unit, the clock says so, or the run ends.
    fn wait(&mut self) -> Next {
        let shared = self.shared;
        let seat = &shared.seats[self.number];
        shared.goes_idle(self.number);
        let next = loop {
            // First, so that what was handed to a lane that had not begun it is left when a stop is asked for.
            if shared.stopping.load(Ordering::Acquire) {
                break Next::Leave;
            }
            if let Some((unit, work)) = seat.take() {
                break Next::Run(unit, work, shared.now());
            }
            if seat.threads.load(Ordering::Acquire) != self.thread {
                break Next::Leave;
            }
            if !shared.knocked() {
                let keeps = shared.keep(self.number);
                let wake = shared.wake_at.load(Ordering::Acquire);
                let until = (keeps && wake != u64::MAX).then(|| shared.origin_ns.saturating_add(wake));
                // Units come from lanes that run some: without a job in flight, there is nothing to spin for.
                let spin_ns = if shared.jobs.load(Ordering::Relaxed) == 0 { 0 } else { shared.spin_ns };
                if seat.sleep(&mut self.sleeper, until, spin_ns) == Woken::Rung {
                    continue;
                }
                // What the turn at `wake` needs has left the caches while others ran. A turn now, in the lead
                // that would be spun anyway, brings it back.
                match self.session(None, shared.now()) {
                    Next::Idle if shared.wake_at.load(Ordering::Relaxed) != wake => continue,
                    Next::Idle => {}
                    other => break other,
                }
                if until.is_some_and(|at_ns| seat.spin(at_ns) == Woken::Rung) {
                    continue;
                }
            }
            shared.leaves_idle(self.number);
            match self.session(None, shared.now()) {
                Next::Idle => shared.goes_idle(self.number),
                other => break other,
            }
        };
        shared.leaves_idle(self.number);
        shared.pass_on(self.number);
        next
    }
}
