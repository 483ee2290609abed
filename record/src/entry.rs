//! One input of the scheduler and what it answered.

use core::fmt;
use red_core::{
    Action, CommitError, CompleteError, Counters, Instant, JobId, LaneId, Outcome, ReleaseError, TaskId,
    UnitId,
};

/// A call on the scheduler. Its time is that of the [`Entry`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Call {
    /// `release_at`.
    Release {
        /// Whose job.
        task: TaskId,
        /// When it was released.
        at: Instant,
        /// The frame that it reads.
        capture: Option<u64>,
    },
    /// `complete`.
    Complete(UnitId),
    /// `fail`.
    Fail(UnitId),
    /// `poll_on` for this lane, or `poll`.
    Poll(Option<LaneId>),
    /// `take_outcome`, where there was one.
    TakeOutcome,
    /// `edit` and `commit` of the host's change of this number.
    Edit(u32),
    /// `retire_lane`.
    Retire(LaneId),
    /// `restore_lane`.
    Restore(LaneId),
    /// `remove_task`.
    Remove(TaskId),
    /// No call: the counters at the end of the run.
    End,
}

/// What a call answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Of a release.
    Released(Result<JobId, ReleaseError>),
    /// Of a completion or failure.
    Reported(Result<(), CompleteError>),
    /// Of a poll.
    Polled(Option<Action>),
    /// Of `take_outcome`.
    Outcome(Option<Outcome>),
    /// Of an edit.
    Edited(Result<(), CommitError>),
    /// Of the calls that answer yes or no.
    Done(bool),
    /// At the end.
    Counters(Counters),
}

/// An input with its time and its answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Entry {
    /// The time that the call was given; calls without one have that of the call before.
    pub now: Instant,
    /// The call.
    pub call: Call,
    /// What it answered.
    pub answer: Answer,
}

impl Call {
    /// The unit that it reports.
    #[must_use]
    pub const fn unit(&self) -> Option<UnitId> {
        match self {
            Self::Complete(unit) | Self::Fail(unit) => Some(*unit),
            _ => None,
        }
    }
}

impl Answer {
    /// The unit that it starts or stops.
    #[must_use]
    pub const fn unit(&self) -> Option<UnitId> {
        match self {
            Self::Polled(Some(Action::Dispatch(dispatch) | Action::Preempt(dispatch))) => Some(dispatch.unit),
            _ => None,
        }
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Release { task, at, capture } => {
                write!(f, "release task {} at {}", task.index(), Time(*at))?;
                capture.map_or(Ok(()), |capture| write!(f, " capture {capture}"))
            }
            Self::Complete(unit) => write!(f, "complete {}", Named(*unit)),
            Self::Fail(unit) => write!(f, "fail {}", Named(*unit)),
            Self::Poll(Some(lane)) => write!(f, "poll for lane {}", lane.index()),
            Self::Poll(None) => f.write_str("poll"),
            Self::TakeOutcome => f.write_str("take outcome"),
            Self::Edit(number) => write!(f, "edit {number}"),
            Self::Retire(lane) => write!(f, "retire lane {}", lane.index()),
            Self::Restore(lane) => write!(f, "restore lane {}", lane.index()),
            Self::Remove(task) => write!(f, "remove task {}", task.index()),
            Self::End => f.write_str("end"),
        }
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Released(Ok(job)) => write!(f, "job {:#x}", job.to_bits()),
            Self::Released(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Reported(Ok(())) | Self::Edited(Ok(())) => f.write_str("done"),
            Self::Reported(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Edited(Err(e)) => write!(f, "refused: {e:?}"),
            Self::Polled(None) | Self::Outcome(None) => f.write_str("nothing"),
            Self::Polled(Some(Action::Dispatch(d))) => write!(f, "start {}", Named(d.unit)),
            Self::Polled(Some(Action::Preempt(d))) => write!(f, "preempt {}", Named(d.unit)),
            Self::Polled(Some(Action::Ended(outcome))) | Self::Outcome(Some(outcome)) => ended(f, outcome),
            Self::Polled(Some(other)) => write!(f, "{other:?}"),
            Self::Done(yes) => f.write_str(if *yes { "yes" } else { "no" }),
            Self::Counters(counters) => write!(f, "{counters:?}"),
        }
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}  {} -> {}", Time(self.now), self.call, self.answer)
    }
}

fn ended(f: &mut fmt::Formatter<'_>, outcome: &Outcome) -> fmt::Result {
    write!(f, "job {} of task {} ended at {}", outcome.index, outcome.task.index(), Time(outcome.at))?;
    outcome.shed.map_or(Ok(()), |reason| write!(f, ", given up: {}", reason.name()))
}

struct Time(Instant);

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ns", self.0.as_nanos())
    }
}

struct Named(UnitId);

impl fmt::Display for Named {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(unit) = self;
        write!(
            f,
            "unit {} (node {}, lane {})",
            unit.to_bits() >> 16,
            unit.node().index(),
            unit.lane().index()
        )
    }
}

/// Time between two instants with its sign, in 64 bits whatever they are.
pub(crate) const fn back(now: Instant, then: Instant) -> u64 {
    let apart = now.as_nanos().wrapping_sub(then.as_nanos());
    // Small for both signs.
    apart << 1 ^ (if apart >> 63 == 1 { u64::MAX } else { 0 })
}

/// The reverse of [`back`].
pub(crate) const fn then(now: Instant, back: u64) -> Instant {
    let apart = back >> 1 ^ (if back & 1 == 1 { u64::MAX } else { 0 });
    Instant::from_nanos(now.as_nanos().wrapping_sub(apart))
}
