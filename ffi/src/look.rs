#![allow(unsafe_code, reason = "names of C")]
//! What a host may ask a scheduler.

use crate::action::{red_member, red_unit};
use crate::boundary::{Out, OutGrowing, Room};
use crate::dag::node_id;
use crate::event::{red_event, red_executions, red_figures};
use crate::job::run;
use crate::scheduler::look;
use crate::status::red_status;
use crate::values::{RED_NONE_64, red_scheduler};
use red_core::{Duration, Empty, Instant, TaskId, UnitId};

/// When red_scheduler_poll is to be called even if nothing happens; RED_NONE_64: not before something does. Any call may
/// change it.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_poll_at(scheduler: *const red_scheduler, at_ns: *mut u64) -> red_status {
    look(scheduler, |machine| {
        Out::of(at_ns)?.put(machine.poll_at().map_or(RED_NONE_64, Instant::as_nanos));
        Ok(red_status::Ok)
    })
}

/// What a unit is, while it runs and one of its jobs is in flight.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_NOT_RUNNING.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_unit(
    scheduler: *const red_scheduler,
    unit: u64,
    data: *mut red_unit,
) -> red_status {
    look(scheduler, |machine| {
        let out = OutGrowing::of(data)?;
        out.put(machine.unit(UnitId::from_bits(unit)).ok_or(red_status::NotRunning)?.into());
        Ok(red_status::Ok)
    })
}

/// The members of a unit that runs: one, or the encoders that share one execution. Up to `room` into `members`, and how many
/// there are into `count`. If they are more than `room`, only `count` is written.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs * nodes). Errors:
/// RED_STATUS_NOT_RUNNING, RED_STATUS_TOO_SHORT.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_members(
    scheduler: *const red_scheduler,
    unit: u64,
    members: *mut red_member,
    room: usize,
    count: *mut usize,
) -> red_status {
    look(scheduler, |machine| {
        let out = Room::of(members, room, count)?;
        let (unit, mut count) = (UnitId::from_bits(unit), 0);
        machine.members(unit, &mut |_| count += 1);
        if count == 0 {
            return Err(red_status::NotRunning);
        }
        let mut filling = out.begin(count)?;
        machine.members(unit, &mut |member| filling.put(member.into()));
        Ok(red_status::Ok)
    })
}

/// The units of other lanes after which a unit that was dispatched ahead has to start: what its lane waits for besides what it
/// was given before. Up to `room` into `units`, and how many there are into `count`; none of a unit that counts as started. If
/// they are more than `room`, only `count` is written.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(lanes). Errors: RED_STATUS_NOT_RUNNING,
/// RED_STATUS_TOO_SHORT.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_waits_for(
    scheduler: *const red_scheduler,
    unit: u64,
    units: *mut u64,
    room: usize,
    count: *mut usize,
) -> red_status {
    look(scheduler, |machine| {
        let out = Room::of(units, room, count)?;
        let unit = UnitId::from_bits(unit);
        let _there = machine.unit(unit).ok_or(red_status::NotRunning)?;
        let mut count = 0;
        machine.waits_for(unit, &mut |_| count += 1);
        let mut filling = out.begin(count)?;
        machine.waits_for(unit, &mut |before| filling.put(before.to_bits()));
        Ok(red_status::Ok)
    })
}

/// The job in flight that was the `index`-th of its task, from 0.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs). Errors: RED_STATUS_UNKNOWN_JOB.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_job(
    scheduler: *const red_scheduler,
    task: u32,
    index: u64,
    job: *mut u32,
) -> red_status {
    look(scheduler, |machine| {
        let out = Out::of(job)?;
        out.put(machine.job_id(TaskId::from_bits(task), index).ok_or(red_status::UnknownJob)?.to_bits());
        Ok(red_status::Ok)
    })
}

/// What the last 8 executions of a node took, where the configuration takes samples.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_NODE: no such
/// node in the task's graph, or no such task.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_executions(
    scheduler: *const red_scheduler,
    task: u32,
    node: u32,
    executions: *mut red_executions,
) -> red_status {
    look(scheduler, |machine| {
        let out = OutGrowing::of(executions)?;
        let seen = machine.executions(TaskId::from_bits(task), node_id(node)?);
        let seen = seen.ok_or(red_status::UnknownNode)?;
        let ns = |time: Option<Duration>| time.map_or(RED_NONE_64, Duration::as_nanos);
        out.put(red_executions {
            mean_ns: seen.mean().map_or(RED_NONE_64, red_core::CostEstimate::as_nanos),
            minimum_ns: ns(seen.minimum()),
            maximum_ns: ns(seen.maximum()),
            ..red_executions::EMPTY
        });
        Ok(red_status::Ok)
    })
}

/// Counters and figures.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(jobs * nodes). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_figures(
    scheduler: *const red_scheduler,
    figures: *mut red_figures,
) -> red_status {
    look(scheduler, |machine| {
        OutGrowing::of(figures)?.put(machine.figures());
        Ok(red_status::Ok)
    })
}

/// Takes the oldest events of the record: up to `room` into `events`, and how many into `count`. What found no room in the
/// record is counted in red_figures: events_dropped.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(room). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_take_events(
    scheduler: *mut red_scheduler,
    events: *mut red_event,
    room: usize,
    count: *mut usize,
) -> red_status {
    run(scheduler, |machine| machine.take_events(events, room, count))
}

// A graph of the largest class takes the interpreter minutes.
#[cfg(all(test, not(miri)))]
mod tests;
