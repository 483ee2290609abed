#![allow(unsafe_code, reason = "names of C")]
//! A runtime that runs: started, released to, asked, stopped.

use super::open::{on, with_room};
use super::values::red_runtime;
use crate::action::red_outcome;
use crate::boundary::{OutGrowing, Room};
use crate::event::{red_event, red_figures};
use crate::machine::figures;
use crate::status::red_status;
use crate::values::RED_NONE_64;
use crate::warning::red_warning;
use core::time::Duration;
use red_core::TaskId;
use red_rt::control::Refused;

/// Starts the lanes. In real time each lane is pinned, and as long as one is running all memory of the process is locked,
/// what comes later too, and the C library's allocator gives back none; if a right is missing nothing runs,
/// red_runtime_message says which and how to get it, and what was changed is changed back, but for a process that had memory
/// locked before: all of it is locked then. No signal handler is installed; lanes inherit the caller's mask of signals.
///
/// Threads: any but a body's. Real time: no. Time: until all lanes are ready. Errors: RED_STATUS_NOT_PERMITTED,
/// RED_STATUS_CPUS, RED_STATUS_SYSTEM: after these the runtime can only be closed, and calls that set it up or look at its
/// tasks answer the same; RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY; RED_STATUS_BUSY: from a body.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_start(runtime: *mut red_runtime) -> red_status {
    on(runtime, |engine| {
        engine.start()?;
        Ok(red_status::Ok)
    })
}

/// Releases a job of a task. `capture` is the number of the frame that it reads; RED_NONE_64: by the sensors' periods, and one
/// of its own where a frame has no sensor. A task that is not there is found out by a lane, and its release is dropped.
///
/// Threads: any, at once, also a body. Real time: yes, with one system call if a lane has to be woken. Time: wait-free.
/// Errors: RED_STATUS_IDLE: not started; RED_STATUS_MAILBOX_FULL, RED_STATUS_OVER, RED_STATUS_FORKED; RED_STATUS_BUSY: as
/// many threads as can are releasing at this moment, try again.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_release(runtime: *const red_runtime, task: u32, capture: u64) -> red_status {
    on(runtime, |engine| {
        let capture = (capture != RED_NONE_64).then_some(capture);
        let released = engine.control()?.release(TaskId::from_bits(task), capture);
        released.map_err(|refused| match refused {
            Refused::Full => red_status::MailboxFull,
            Refused::Over => red_status::Over,
            _ => red_status::Busy,
        })?;
        Ok(red_status::Ok)
    })
}

/// Asks the lanes to end: nothing is released any more, no lane takes another unit, bodies that run are waited for by
/// red_runtime_wait. Where red_runtime_start is on its way, its lanes end before they begin anything. Again, or after the
/// end, it changes nothing.
///
/// Threads: any, at once, also a body or a signal handler. Real time: yes, with one system call. Time: wait-free. Errors:
/// RED_STATUS_IDLE: red_runtime_start was not called, or was refused; RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_stop(runtime: *const red_runtime) -> red_status {
    on(runtime, |engine| {
        engine.stop()?;
        Ok(red_status::Ok)
    })
}

/// Waits until the runtime has ended, at most `timeout_ns`; RED_NONE_64: as long as it takes.
///
/// Threads: any but a body's, at once. Real time: no. Time: the timeout. Errors: RED_STATUS_TIMEOUT: it goes on;
/// RED_STATUS_IDLE: not started; RED_STATUS_BUSY: from a body; RED_STATUS_FORKED; RED_STATUS_SYSTEM: a lane did not come up,
/// red_runtime_message says why.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_wait(runtime: *const red_runtime, timeout_ns: u64) -> red_status {
    on(runtime, |engine| {
        engine.wait((timeout_ns != RED_NONE_64).then(|| Duration::from_nanos(timeout_ns)))?;
        Ok(red_status::Ok)
    })
}

/// Counters and figures of the scheduler while lanes run, or before.
///
/// Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_BUSY: from a body;
/// RED_STATUS_OVER: red_runtime_report has what is known at the end; RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_figures(runtime: *mut red_runtime, now: *mut red_figures) -> red_status {
    with_room(runtime, |engine| {
        let out = OutGrowing::of(now)?;
        out.put(engine.look(figures)?);
        Ok(red_status::Ok)
    })
}

/// Takes the oldest outcomes of jobs that ended: up to `room` into `outcomes`, and how many into `count`. 1,024 are kept; what
/// finds no room is counted in red_report: outcomes_dropped. A release for which 64 jobs in flight left no room became no job
/// and has no outcome; red_report counts it as released, missed and shed. Times are of CLOCK_MONOTONIC.
///
/// Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_take_outcomes(
    runtime: *mut red_runtime,
    outcomes: *mut red_outcome,
    room: usize,
    count: *mut usize,
) -> red_status {
    on(runtime, |engine| {
        Room::of(outcomes, room, count)?.take(|| engine.notes.take_outcome());
        Ok(red_status::Ok)
    })
}

/// Takes the oldest warnings of deadlines that will be missed: up to `room` into `warnings`, and how many into `count`. 1,024
/// are kept; what finds no room is counted in red_report: events_dropped. Times are of CLOCK_MONOTONIC.
///
/// Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_take_warnings(
    runtime: *mut red_runtime,
    warnings: *mut red_warning,
    room: usize,
    count: *mut usize,
) -> red_status {
    on(runtime, |engine| {
        Room::of(warnings, room, count)?.take(|| engine.notes.take_warning());
        Ok(red_status::Ok)
    })
}

/// Takes the oldest events: up to `room` into `events`, and how many into `count`. 8,192 are kept; what finds no room is counted
/// in red_report: events_dropped. Times are of CLOCK_MONOTONIC.
///
/// Threads: one at a time. Real time: yes. Time: O(room). Errors: those of the handle, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_take_events(
    runtime: *mut red_runtime,
    events: *mut red_event,
    room: usize,
    count: *mut usize,
) -> red_status {
    on(runtime, |engine| {
        Room::of(events, room, count)?.take(|| engine.notes.take_event());
        Ok(red_status::Ok)
    })
}
