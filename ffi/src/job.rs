#![allow(unsafe_code, reason = "names of C")]
//! The loop: release, poll, complete.

use crate::action::{red_action, red_outcome};
use crate::boundary::{Out, take};
use crate::handles;
use crate::machine::{AnyMachine, lane_id};
use crate::scheduler::change;
use crate::status::{red_status, status};
use crate::values::{RED_NONE_64, red_scheduler};
use crate::warning::red_warning;
use red_core::{Instant, UnitId};

/// Makes a call of the loop.
#[inline(always)]
pub(crate) fn run(
    scheduler: *const red_scheduler,
    call: impl FnOnce(&AnyMachine) -> red_status,
) -> red_status {
    match take(scheduler).and_then(|scheduler| handles::scheduler(scheduler.bits)) {
        Ok(machine) => call(machine),
        Err(status) => status,
    }
}

/// Releases a job of a task now. A job that finds no place has its index and its event all the same, and time goes on
/// whatever is answered.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_TASK,
/// RED_STATUS_TIME_OVERFLOW, RED_STATUS_JOBS_FULL: the job's index is used up, and an event tells of it.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_release(
    scheduler: *mut red_scheduler,
    task: u32,
    now_ns: u64,
    job: *mut u32,
) -> red_status {
    red_scheduler_release_at(scheduler, task, now_ns, RED_NONE_64, now_ns, job)
}

/// Releases a job whose release was at `release_ns`, for hosts that learn of it later. `capture` is the number of the frame
/// that it reads; RED_NONE_64: by the sensors' periods, and one of its own where a frame has no sensor. Else as
/// red_scheduler_release.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(nodes). Errors: RED_STATUS_UNKNOWN_TASK,
/// RED_STATUS_TIME_OVERFLOW, RED_STATUS_JOBS_FULL: the job's index is used up, and an event tells of it.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_release_at(
    scheduler: *mut red_scheduler,
    task: u32,
    release_ns: u64,
    capture: u64,
    now_ns: u64,
    job: *mut u32,
) -> red_status {
    run(scheduler, |machine| machine.release_at(task, release_ns, capture, now_ns, job))
}

/// The next thing to do; RED_ACTION_KIND_NOTHING until something happens or the time of red_scheduler_poll_at comes. To be
/// called until it says that.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(log jobs) a dispatched node; O(jobs * (nodes + edges)) when
/// a job may be lost, at ticks of the monitor, and under re-assignment; with RED_SHEDDING_HOPELESS up to 67 + jobs runs of the
/// schedule ahead after a release, and in the next call at a later instant where all lanes were busy and nobody polled. Errors:
/// those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_poll(
    scheduler: *mut red_scheduler,
    now_ns: u64,
    action: *mut red_action,
) -> red_status {
    run(scheduler, |machine| machine.poll(now_ns, action))
}

/// red_scheduler_poll for a lane that asks for itself: it is preferred among the free lanes of its pool.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: as red_scheduler_poll. Errors: RED_STATUS_UNKNOWN_LANE.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_poll_on(
    scheduler: *mut red_scheduler,
    lane_number: u32,
    now_ns: u64,
    action: *mut red_action,
) -> red_status {
    run(scheduler, |machine| machine.poll_on(lane_number, now_ns, action))
}

/// A unit ended: all its members complete, and what follows them may start. Time goes on whatever is answered.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(successors + log jobs); with encoders O(jobs * encoders).
/// Errors: RED_STATUS_STALE, RED_STATUS_NOT_RUNNING; RED_STATUS_LATE: its lane is free all the same.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_complete(
    scheduler: *mut red_scheduler,
    unit: u64,
    now_ns: u64,
) -> red_status {
    run(scheduler, |machine| machine.complete(unit, now_ns))
}

/// red_scheduler_complete and the first red_scheduler_poll_on of the unit's lane in one, which costs less than both.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: as both. Errors: as red_scheduler_complete; nothing was
/// polled then.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_complete_and_poll(
    scheduler: *mut red_scheduler,
    unit: u64,
    now_ns: u64,
    action: *mut red_action,
) -> red_status {
    run(scheduler, |machine| machine.complete_and_poll(unit, now_ns, action))
}

/// A unit failed: the jobs of all its members are given up with the reason RED_SHED_FAULT. Time goes on whatever is answered.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: as red_scheduler_complete.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_fail(scheduler: *mut red_scheduler, unit: u64, now_ns: u64) -> red_status {
    change(scheduler, |machine| {
        Ok(status(machine.fail(UnitId::from_bits(unit), Instant::from_nanos(now_ns)), drop))
    })
}

/// Takes the outcome of one job that ended, so that its place can be used again before the next poll. `count` is 1, or 0 where
/// there was none; then the outcome is not written.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_take_outcome(
    scheduler: *mut red_scheduler,
    outcome: *mut red_outcome,
    count: *mut u32,
) -> red_status {
    change(scheduler, |machine| {
        let (out, count) = (Out::of(outcome)?, Out::of(count)?);
        let taken = machine.take_outcome();
        count.put(taken.is_some().into());
        if let Some(taken) = taken {
            out.put(taken.into());
        }
        Ok(red_status::Ok)
    })
}

/// Takes one warning of a deadline that will be missed, as far as is known since the last poll or, where all lanes were busy,
/// since the last event. Take warnings after each of these and before the next release. `count` is 1, or 0 where there was none; then the warning is not written. Only a configuration with
/// RED_SHEDDING_HOPELESS looks ahead and warns.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_take_warning(
    scheduler: *mut red_scheduler,
    warning: *mut red_warning,
    count: *mut u32,
) -> red_status {
    change(scheduler, |machine| {
        let (out, count) = (Out::of(warning)?, Out::of(count)?);
        let taken = machine.take_warning();
        count.put(taken.is_some().into());
        if let Some(taken) = taken {
            out.put(taken);
        }
        Ok(red_status::Ok)
    })
}

/// Takes an idle lane out of its pool, because nothing can run there any more. A pool without lanes starts nothing.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_LANE: there is no such
/// lane, or it runs something.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_retire_lane(scheduler: *mut red_scheduler, lane_number: u32) -> red_status {
    change(scheduler, |machine| {
        let retired = machine.retire_lane(lane_id(lane_number)?);
        Ok(if retired { red_status::Ok } else { red_status::UnknownLane })
    })
}

/// Puts a retired lane back.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_LANE: there is no such
/// lane, or it was not retired.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_restore_lane(scheduler: *mut red_scheduler, lane_number: u32) -> red_status {
    change(scheduler, |machine| {
        let restored = machine.restore_lane(lane_id(lane_number)?);
        Ok(if restored { red_status::Ok } else { red_status::UnknownLane })
    })
}
