//! A lane: completes, decides, runs its own next unit without a context switch, and hands others theirs.
//! Until there is one it waits ([`crate::waiting`]).

use crate::allocations::arm;
use crate::allowance::Allowance;
use crate::handler::{Handler, Work};
use crate::on_stream::{Leaves, Queue};
use crate::panics::{BodyPanic, caught};
use crate::report::LaneFigures;
use crate::setup::best_effort;
use crate::shared::{Shared, take_requests};
use crate::sleeper::Sleeper;
use crate::timeline::{Host, Timeline, tell_warnings};
use crate::usage::Usage;
use crate::waiting::Next;
use crate::watchdog::{Armed, Bound};
use core::sync::atomic::Ordering;
use red_core::{Action, Capacity, Duration, Instant, LaneId, PoolId, Scheduler, UnitId};
use red_record::Recorder;
use red_sync::Exclusive;

/// Bound of a body: this many times its WCET, and a fixed part.
const BOUND_TIMES: u64 = 10;
const BOUND_PLUS_NS: u64 = 100_000_000;
/// Bound of what a handler does when the run starts.
const BOUND_OF_BEGIN_NS: u64 = 1_000_000_000;

pub(crate) struct Lane<'a, C: Capacity, H, L: Exclusive<Scheduler<C>>> {
    pub(crate) shared: &'a Shared<C, H, L>,
    pub(crate) number: usize,
    /// Which thread of this lane it is; a spare is a later one.
    pub(crate) thread: u64,
    /// That thread, by the kernel's number.
    pub(crate) id: u32,
    pub(crate) figures: LaneFigures,
    pub(crate) handler: Box<dyn Handler>,
    /// Of a thread that the kernel may stop for having run too long.
    pub(crate) allowance: Option<Allowance>,
    /// Of a lane whose handler has a stream: what it gave.
    pub(crate) queue: Queue,
}

/// What a lane has to report.
#[derive(Clone, Copy, Default)]
struct Report {
    /// A unit, and whether it succeeded.
    done: Option<(UnitId, bool)>,
    /// Its stream is not to be used any more: the lane runs nothing.
    leaves: Option<(PoolId, Leaves)>,
}

/// What came of a turn with the scheduler.
struct Turn {
    mine: Option<Work>,
    /// The clock's next instant came nearer.
    is_sooner: bool,
    /// An errand was run.
    has_answered: bool,
}

impl<C: Capacity, H: Host<C>, L: Exclusive<Scheduler<C>>> Lane<'_, C, H, L> {
    /// Until the run stops, or this thread was replaced.
    pub(crate) fn run(&mut self, mut sleeper: Sleeper) {
        let waiting = &self.shared.waiting;
        let armed = self.shared.watched(self.number, waiting.now(), BOUND_OF_BEGIN_NS);
        self.handler.begin(waiting.origin_ns());
        if !self.is_kept(armed) {
            return;
        }
        self.figures.baseline = Usage::of_thread();
        arm(true);
        let has_stream = self.handler.stream().is_some();
        let mut next = self.session(Report::default(), waiting.now());
        loop {
            next = match next {
                Next::Run(work, _) if has_stream => match self.stream_turn(Some(&work)) {
                    Some(next) => next,
                    None => break,
                },
                Next::Stream => match self.stream_turn(None) {
                    Some(next) => next,
                    None => break,
                },
                Next::Run(work, start) => match self.execute(&work, start) {
                    Some((ok, end)) => {
                        self.session(Report { done: Some((work.unit, ok)), leaves: None }, end)
                    }
                    None => break,
                },
                Next::Idle => {
                    waiting.wait(self.number, &mut sleeper, || self.session(Report::default(), waiting.now()))
                }
                Next::Leave => break,
            };
        }
        arm(false);
        let used = Usage::of_thread().since(self.figures.baseline);
        self.figures.faults += used.minor_faults + used.major_faults;
        self.figures.ordinary_ns = self.allowance.as_ref().map_or(0, |allowance| allowance.ordinary_ns);
    }

    /// Waits for the next unit of the stream and reports it; `None`: another thread has the lane.
    fn stream_turn(&mut self, dispatched: Option<&Work>) -> Option<Next> {
        let Some(ended) = self.execute_on_stream(dispatched) else { return Some(Next::Idle) };
        if !ended.is_kept {
            let _unchanged = best_effort();
            return None;
        }
        let next = self.session(
            Report { done: Some((ended.unit, ended.ok)), leaves: ended.leaves.map(|why| (ended.pool, why)) },
            ended.end,
        );
        let has_more = !self.queue.is_empty() && ended.leaves.is_none();
        Some(if has_more && matches!(next, Next::Idle) { Next::Stream } else { next })
    }

    /// Runs a body under the watchdog. Whether it succeeded, and when it ended; `None` if its bound has passed:
    /// the lane gets another thread.
    fn execute(&mut self, work: &Work, start: u64) -> Option<(bool, u64)> {
        let shared = self.shared;
        self.figures.dispatched(start.saturating_sub(work.since_ns));
        self.figures.units += 1;
        let bound = work.wcet_ns.saturating_mul(BOUND_TIMES).saturating_add(BOUND_PLUS_NS);
        let since_boot = |time: u64| shared.waiting.origin_ns().saturating_add(time);
        self.allowance.iter_mut().for_each(|allowance| allowance.before_body(since_boot(start)));
        let (armed, stood) = (shared.watched(self.number, start, bound), shared.standstills.total_ns());
        arm(false);
        let result = caught(|| self.handler.run(work));
        let end = shared.waiting.now();
        self.saw_standstill(end);
        let stood = shared.standstills.total_ns() - stood;
        let took = end.saturating_sub(start).saturating_sub(stood);
        self.figures.busy_ns += took;
        self.figures.overruns += u64::from(took > work.wcet_ns);
        let ok = matches!(result, Ok(Ok(())));
        self.figures.failed += u64::from(!ok);
        if let Err(message) = result {
            self.figures.panicked(BodyPanic {
                task: work.task.index(),
                node: work.node,
                job: work.job,
                message,
            });
        }
        // The message was the body's.
        arm(true);
        let is_kept = self.is_kept(armed);
        if is_kept {
            // Before it takes the lock.
            self.allowance.iter_mut().for_each(|allowance| allowance.after_body(since_boot(end)));
        }
        self.figures.nodes_missed += u64::from(end > work.sub_deadline_ns);
        is_kept.then_some((ok, end))
    }

    /// Counts a standstill that ends now, unless the watchdog did.
    fn saw_standstill(&self, now: u64) {
        let shared = self.shared;
        shared.standstills.look(shared.waiting.origin_ns().saturating_add(now), || shared.last_turn_ns());
    }

    /// Whether what the watchdog was shown is over in time. A thread whose bound has passed leaves, even if it could go
    /// on: its lane is retired, and gets a spare on the same seat. It was demoted and must not take the lock: the spare
    /// would spin for it on the CPU that it needs.
    fn is_kept(&self, armed: Armed) -> bool {
        let is_kept = self.shared.slots[self.number].disarm(armed) == Bound::Kept;
        if !is_kept {
            // Out of the idle class, if that is allowed: a thread that starves while the kernel takes its stack apart
            // would keep the lock of the whole address space.
            let _unchanged = best_effort();
        }
        is_kept
    }

    /// One turn with the scheduler, from `begin` on: apply what is due, report, decide, hand out. Once a stop was asked
    /// for, only the report.
    fn session(&mut self, report: Report, begin: u64) -> Next {
        let shared = self.shared;
        let turn = shared.scheduler.with(|scheduler, requests| {
            shared.host.with(|held| {
                // A body that came back after the end of the run finds nobody any more.
                let host = held.host.as_mut()?;
                let scheduler = &mut Recorder::new(scheduler, held.tape.as_mut());
                // Read under the lock, so that time goes the way of the lock.
                let now = Instant::from_nanos(shared.waiting.now());
                // Before it is told that this lane took a turn.
                self.saw_standstill(now.as_nanos());
                shared.slots[self.number].turn(shared.waiting.origin_ns().saturating_add(now.as_nanos()));
                let stood = shared.standstills.total_ns() - held.stood_ns;
                if stood > 0 {
                    held.stood_ns += stood;
                    let stood = Duration::from_nanos(stood);
                    scheduler.stood_still(stood, now);
                    host.stood_still(stood, now);
                }
                let (goes_on, was_busy) = (!shared.waiting.is_stopping(), report.done.is_some());
                // What came while all lanes were busy came before what ends now.
                let since = if goes_on {
                    host.due(scheduler, now);
                    let asked = take_requests(scheduler, requests, host, now);
                    held.timeline.release(scheduler, host, now).unwrap_or(u64::MAX).min(asked)
                } else {
                    u64::MAX
                };
                self.report(scheduler, host, report, now);
                let turn =
                    goes_on.then(|| self.decide(scheduler, &held.timeline, host, since, was_busy, now));
                tell_warnings(scheduler, host, now);
                while let Some(event) = scheduler.take_event() {
                    host.event(event);
                }
                turn
            })
        });
        if turn.as_ref().is_some_and(|turn| turn.is_sooner) {
            shared.waiting.ring_keeper(self.number);
        }
        if turn.as_ref().is_some_and(|turn| turn.has_answered) {
            shared.errands.ring();
        }
        let end = shared.waiting.now();
        self.figures.deciding_ns += end.saturating_sub(begin);
        match turn {
            Some(Turn { mine: Some(work), .. }) => Next::Run(work, end),
            Some(Turn { mine: None, .. }) => Next::Idle,
            None => Next::Leave,
        }
    }

    /// What ended, and which lanes were lost or got a spare.
    fn report(
        &self,
        scheduler: &mut Recorder<'_, C>,
        host: &mut H,
        Report { done, leaves }: Report,
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
        if let Some(why) = leaves {
            self.shared.leave_stream(scheduler, self.number, self.queue.units(), why, now);
        }
        while let Some(outcome) = scheduler.take_outcome() {
            host.ended(&outcome);
        }
    }

    /// Fills the lanes, after releases of which the first was at `since`.
    fn decide(
        &self,
        scheduler: &mut Recorder<'_, C>,
        timeline: &Timeline,
        host: &mut H,
        since: u64,
        was_busy: bool,
        now: Instant,
    ) -> Turn {
        let (shared, me) = (self.shared, LaneId::new(self.number as u8));
        let since = since.min(now.as_nanos());
        let has_answered = self.run_errand(scheduler, now);
        let is_closed = shared.is_closed(now);
        let mut mine = None;
        while let Some(action) = scheduler.poll_on(me, now) {
            match action {
                Action::Dispatch(d) => {
                    let Some(unit) = scheduler.unit(d.unit) else { continue };
                    // A lane that was busy until now could not have started anything earlier.
                    let busy = d.lane == me && was_busy;
                    let work = Work::of(d.unit, &unit, if busy { now.as_nanos() } else { since });
                    if d.lane == me {
                        shared.waiting.seats[self.number].keep(d.unit);
                        mine = Some(work);
                    } else {
                        shared.waiting.hand(d.lane.index(), &work);
                    }
                }
                Action::Ahead(d) => shared.hand_ahead(scheduler, d),
                Action::Ended(outcome) => host.ended(&outcome),
                _ => {}
            }
        }
        let jobs = scheduler.jobs_in_flight();
        let is_drained = is_closed && jobs == 0 && timeline.is_over(now.as_nanos());
        // Written under the lock alone, and hardly ever.
        if is_drained != shared.drained.load(Ordering::Relaxed) {
            shared.drained.store(is_drained, Ordering::Relaxed);
            // The control thread looks whether the run is over.
            shared.stopper.bell().ring();
        }
        let wake =
            [timeline.wake_at(now.as_nanos()), host.next_at(), scheduler.poll_at().map(Instant::as_nanos)];
        let wake = wake.into_iter().flatten().min().unwrap_or(u64::MAX);
        Turn { mine, is_sooner: shared.waiting.plan(wake, jobs), has_answered }
    }

    /// Runs an errand, if another thread has one. Whether it did.
    fn run_errand(&self, scheduler: &mut Recorder<'_, C>, now: Instant) -> bool {
        let errands = &self.shared.errands;
        let Some(mut letter) = errands.take(self.id) else { return false };
        // Its panic is the asker's: it leaves the lock and the lane as they are.
        letter.panic = caught(|| (letter.errand)(scheduler, now)).err();
        errands.answer(letter);
        true
    }
}
