//! What comes by the clock: periodic releases and changes, and what a run keeps of its jobs.

use red_core::{Capacity, Duration, Event, Instant, JobId, Outcome, ReleaseError, TaskId, Warning};
use red_record::Recorder;

/// What the host of a run does under the scheduler's lock. Nothing here may allocate, wait or log.
pub trait Host<C: Capacity>: Send {
    /// When `due` wants to be called even if nothing else happens, in nanoseconds since the start of the run. An
    /// instant that has passed must not be asked for again: the lane that keeps the time would not sleep.
    fn next_at(&self) -> Option<u64> {
        None
    }

    /// Graph edits that are due; called at every turn, before the releases of the same instant and before what ended with
    /// this turn is told: it came while that ran.
    fn due(&mut self, scheduler: &mut Recorder<'_, C>, now: Instant) {
        let _unused = (scheduler, now);
    }

    /// A release came: `taken` is its job, or why there is none. Of a task that was removed there is none.
    fn released(&mut self, task: usize, release: Instant, taken: Result<JobId, ReleaseError>);

    /// A job ended.
    fn ended(&mut self, outcome: &Outcome);

    /// Nothing ran for so long until `now`: what runs did not execute meanwhile.
    fn stood_still(&mut self, time: Duration, now: Instant) {
        let _unused = (time, now);
    }

    /// A job will miss its deadline, as is known at `now`.
    fn warned(&mut self, warning: &Warning, now: Instant) {
        let _unused = (warning, now);
    }

    /// An event of the record.
    fn event(&mut self, event: &Event);
}

/// When a task's jobs come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Releases {
    /// Whose.
    pub task: TaskId,
    /// The first, in nanoseconds since the start.
    pub first_ns: u64,
    /// Distance of the others; `None`: one only. Tasks that are released from outside have no entry at all.
    pub period_ns: Option<u64>,
}

/// Releases of one turn: more than jobs are in flight, so that overload is shed by its rule and not by the order of turns,
/// and few enough that a turn ends whatever the periods are.
const AT_ONCE: usize = 1 << 12;

/// Of these, as many as jobs are in flight come when they were to come. Each may cost a look at the schedule, and the rest
/// comes now.
const IN_TIME: usize = 64;

/// Next releases, until the end of the run.
#[derive(Clone, Debug)]
pub(crate) struct Timeline {
    next: Vec<(Releases, Option<u64>)>,
    until_ns: u64,
}

impl Timeline {
    pub(crate) fn new(releases: &[Releases], until_ns: u64) -> Self {
        Self { next: releases.iter().map(|r| (*r, Some(r.first_ns))).collect(), until_ns }
    }

    fn next_at(&self) -> Option<u64> {
        self.next.iter().filter_map(|(_, at)| *at).min().filter(|at| *at < self.until_ns)
    }

    /// When the clock brings something next: a release, or the end of the run.
    pub(crate) fn wake_at(&self, now_ns: u64) -> Option<u64> {
        self.next_at().or((now_ns < self.until_ns).then_some(self.until_ns))
    }

    /// Whether no release is to come any more, however late the last ones were made.
    pub(crate) fn is_over(&self, now_ns: u64) -> bool {
        self.wake_at(now_ns).is_none()
    }

    /// Releases what is due, in the order of instants and then of tasks, up to [`AT_ONCE`]. Returns the earliest.
    pub(crate) fn release<C: Capacity>(
        &mut self,
        scheduler: &mut Recorder<'_, C>,
        host: &mut impl Host<C>,
        now: Instant,
    ) -> Option<u64> {
        let mut first = None;
        for nth in 0..AT_ONCE {
            let Some(at) = self.next_at().filter(|at| *at <= now.as_nanos()) else { break };
            let due = self.next.iter_mut().find(|(_, next)| *next == Some(at));
            let Some((releases, next)) = due else { break };
            let release = Instant::from_nanos(at);
            let came = if nth < IN_TIME { release } else { now };
            release_one(scheduler, host, (releases.task, release), None, came, now);
            *next = releases.period_ns.and_then(|period| at.checked_add(period));
            first = first.or(Some(at));
        }
        first
    }
}

/// Releases a job, which may take the place of another: how that ended is told before the next one could, and so is
/// whom the schedule before it shows to be late. For the scheduler it comes at `came`, if nothing later was told yet.
pub(crate) fn release_one<C: Capacity>(
    scheduler: &mut Recorder<'_, C>,
    host: &mut impl Host<C>,
    (task, release): (TaskId, Instant),
    capture: Option<u64>,
    came: Instant,
    now: Instant,
) {
    let came = came.clamp(scheduler.now().min(now), now);
    let taken = scheduler.release_at(task, release, capture, came);
    host.released(task.index(), release, taken);
    tell_warnings(scheduler, host, now);
    while let Some(outcome) = scheduler.take_outcome() {
        host.ended(&outcome);
    }
}

/// Tells the host who is going to miss its deadline, as far as it was not told.
pub(crate) fn tell_warnings<C: Capacity>(
    scheduler: &mut Recorder<'_, C>,
    host: &mut impl Host<C>,
    now: Instant,
) {
    while let Some(warning) = scheduler.take_warning() {
        host.warned(&warning, now);
    }
}
