//! The numbers that stand for calls and answers: they are the format.

use red_core::{AddTaskError, CommitError, CompleteError, PoolError, ReleaseError, SensorError, ShedReason};

/// An answer that this version has no code for.
pub(super) const UNKNOWN: u64 = 15;

pub(super) const RELEASE: [ReleaseError; 3] =
    [ReleaseError::UnknownTask, ReleaseError::Full, ReleaseError::Overflow];
pub(super) const REPORT: [CompleteError; 3] =
    [CompleteError::Stale, CompleteError::NotRunning, CompleteError::Late];
pub(super) const COMMIT: [CommitError; 8] = [
    CommitError::UnknownTask,
    CommitError::Conflict,
    CommitError::Busy,
    CommitError::Empty,
    CommitError::UnknownPool,
    CommitError::Memory,
    CommitError::Unschedulable,
    CommitError::UnknownSensor,
];
pub(super) const POOL: [PoolError; 2] = [PoolError::NoLane, PoolError::Full];
pub(super) const SENSOR: [SensorError; 2] = [SensorError::ZeroPeriod, SensorError::Full];
pub(super) const ADMIT: [AddTaskError; 7] = [
    AddTaskError::Full,
    AddTaskError::Empty,
    AddTaskError::Deadline,
    AddTaskError::UnknownPool,
    AddTaskError::Memory,
    AddTaskError::Unschedulable,
    AddTaskError::UnknownSensor,
];
pub(super) const SHED: [ShedReason; 7] = [
    ShedReason::Hopeless,
    ShedReason::Overload,
    ShedReason::Urgency,
    ShedReason::Full,
    ShedReason::Late,
    ShedReason::Fault,
    ShedReason::Removed,
];

/// The first four bits of a head.
pub(super) mod tag {
    pub(in crate::words) const TIME: u64 = 0;
    pub(in crate::words) const RELEASE: u64 = 1;
    pub(in crate::words) const COMPLETE: u64 = 2;
    pub(in crate::words) const FAIL: u64 = 3;
    pub(in crate::words) const POLL: u64 = 4;
    pub(in crate::words) const TAKE_OUTCOME: u64 = 5;
    pub(in crate::words) const EDIT: u64 = 6;
    pub(in crate::words) const RETIRE: u64 = 7;
    pub(in crate::words) const RESTORE: u64 = 8;
    pub(in crate::words) const REMOVE: u64 = 9;
    pub(in crate::words) const END: u64 = 10;
    pub(in crate::words) const TURN: u64 = 11;
    /// Which one is in the place of the other lane.
    pub(in crate::words) const SET_UP: u64 = 12;
    pub(in crate::words) const STOOD_STILL: u64 = 13;
}

/// Kinds of set-up calls, and of the parts of their graphs.
pub(super) mod kind {
    pub(in crate::words) const POOL: u64 = 0;
    pub(in crate::words) const SENSOR: u64 = 1;
    pub(in crate::words) const NODE: u64 = 2;
    pub(in crate::words) const EDGES: u64 = 3;
    pub(in crate::words) const TASK: u64 = 4;
    pub(in crate::words) const COMMIT: u64 = 5;
    pub(in crate::words) const AHEAD: u64 = 6;
    pub(in crate::words) const LOST: u64 = 7;
    pub(in crate::words) const USE: u64 = 8;
}

/// Codes of what a poll answers.
pub(super) mod action {
    pub(in crate::words) const NOTHING: u64 = 0;
    /// The expected unit, for the lane that asked; in the place of the other lane stands that of its job.
    pub(in crate::words) const OWN: u64 = 1;
    pub(in crate::words) const PREEMPTED: u64 = 2;
    pub(in crate::words) const ENDED: u64 = 3;
    /// The expected unit, for the other lane; the place of its job follows.
    pub(in crate::words) const HANDED: u64 = 4;
    /// Any other unit: it follows, and its job, and the jobs and nodes of its members.
    pub(in crate::words) const SPELLED: u64 = 5;
    /// A unit that starts later: it follows, and its job.
    pub(in crate::words) const AHEAD: u64 = 6;
}

pub(super) fn code<T, E: PartialEq>(result: Result<T, E>, errors: &[E]) -> u64 {
    match result {
        Ok(_) => 0,
        Err(error) => errors.iter().position(|e| *e == error).map_or(UNKNOWN, |at| at as u64 + 1),
    }
}

pub(super) fn result<E: Copy>(code: u64, errors: &[E]) -> Option<Result<(), E>> {
    match code.checked_sub(1) {
        None => Some(Ok(())),
        Some(at) => errors.get(usize::try_from(at).ok()?).copied().map(Err),
    }
}
