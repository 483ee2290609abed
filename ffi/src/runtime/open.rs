#![allow(unsafe_code, reason = "names of C")]
//! A runtime is opened, closed, and asked where it is.

use super::bodies::is_in_body;
use super::called::engine;
use super::engine::{Engine, State};
use super::report::red_report;
use super::values::{red_mode, red_runtime, red_runtime_config, red_runtime_state};
use crate::boundary::{Out, OutGrowing, Room, take, take_growing};
use crate::config::red_config;
use crate::room::{OF_A_CALL, room};
use crate::status::{flat, red_status};
use core::ffi::c_char;
use core::panic::AssertUnwindSafe;
use core::sync::atomic::Ordering;
use red_core::{Config, Scheduler};
use red_record::class::Large;
use std::panic::catch_unwind;

/// What a runtime takes, and once more what its lanes share.
pub(super) const OF_A_RUNTIME: usize = 2 << 20;

/// Makes a call on a runtime. A panic of ours ends here.
pub(super) fn on(
    runtime: *const red_runtime,
    call: impl FnOnce(&Engine) -> Result<red_status, red_status>,
) -> red_status {
    guarded(|| call(&*engine(take(runtime)?.bits)?))
}

/// The same of a call that takes memory of the system.
pub(super) fn with_room(
    runtime: *const red_runtime,
    call: impl FnOnce(&Engine) -> Result<red_status, red_status>,
) -> red_status {
    on(runtime, |engine| {
        room(OF_A_CALL)?;
        call(engine)
    })
}

fn guarded(call: impl FnOnce() -> Result<red_status, red_status>) -> red_status {
    catch_unwind(AssertUnwindSafe(|| flat(call()))).unwrap_or(red_status::Internal)
}

/// In an allocation of its own from the start: it is larger than many stacks.
fn scheduler(config: Config) -> Box<Scheduler<Large>> {
    let mut scheduler = Box::write(Box::new_uninit(), <Scheduler<Large> as red_core::Empty>::EMPTY);
    scheduler.configure(config);
    scheduler
}

/// Opens a runtime: a scheduler of 16 tasks of 256 nodes and 64 jobs in flight, and lanes for it once it is started. Takes about
/// 2 MiB of memory, and as much again when it is started.
///
/// Threads: any but a body's, at once. Real time: no. Time: O(memory). Errors: RED_STATUS_OUT_OF_RANGE: a field of a
/// configuration, each of which says its range; RED_STATUS_BUSY: from a body, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL: more than 32 lanes, RED_STATUS_PREEMPTS, RED_STATUS_TOO_MANY_OPEN,
/// RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_open(
    policy: *const red_config,
    config: *const red_runtime_config,
    runtime: *mut red_runtime,
) -> red_status {
    guarded(|| {
        let out = Out::of(runtime)?;
        let (policy, config) = (take_growing(policy)?.read()?, take_growing(config)?);
        let is_mode = config.mode <= red_mode::BestEffort as u32;
        if !is_mode || !(1..=98).contains(&config.priority) {
            return Err(red_status::OutOfRange);
        }
        if policy.preempt {
            return Err(red_status::Preempts);
        }
        match policy.lanes {
            0 => return Err(red_status::NoLane),
            1..=32 => {}
            _ => return Err(red_status::PoolsFull),
        }
        if is_in_body() {
            return Err(red_status::Busy);
        }
        room(OF_A_RUNTIME)?;
        out.put(red_runtime { bits: Engine::open(config, scheduler(policy))? });
        Ok(red_status::Ok)
    })
}

/// Stops a runtime, waits for its end and for other calls on it that go on, and frees it. Calls that come later, by copies of
/// the handle, are RED_STATUS_CLOSED. A body that hung, as red_report counts them, may still run afterwards, and has to find
/// what it uses.
///
/// Threads: any but a body's, at once: of several, one closes it. Real time: no. Time: until the bodies that run have returned,
/// as long as the watchdog gives them. Errors: RED_STATUS_CLOSED; RED_STATUS_BUSY: from a body; RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_close(runtime: *mut red_runtime) -> red_status {
    guarded(|| {
        let out = Out::of(runtime)?;
        Engine::close(take(runtime)?.bits)?;
        out.put(red_runtime::default());
        Ok(red_status::Ok)
    })
}

/// Where a runtime is: one of red_runtime_state.
///
/// Threads: any, at once. Real time: no. Time: O(1), but until a start that goes on is over. Errors: those of the
/// handle, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_state_of(runtime: *const red_runtime, state: *mut u32) -> red_status {
    on(runtime, |engine| {
        let out = Out::of(state)?;
        out.put(state_of(&engine.state()) as u32);
        Ok(red_status::Ok)
    })
}

fn state_of(state: &State) -> red_runtime_state {
    match state {
        State::SetUp(_) => red_runtime_state::SetUp,
        State::Running => red_runtime_state::Running,
        State::Ended(_) => red_runtime_state::Ended,
        State::Failed(_) => red_runtime_state::Failed,
    }
}

/// Why red_runtime_start or red_runtime_record was refused, or a log that was begun is not whole at the end, in words, with what
/// to do about it; empty where nothing of that is so. Up to `room` bytes into
/// `text`, with the byte that ends it, and how many it takes into `count`; if they are more than `room`, only that.
///
/// Threads: any, at once. Real time: no. Time: O(length), but until a start that goes on is over. Errors:
/// RED_STATUS_TOO_SHORT, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_message(
    runtime: *const red_runtime,
    text: *mut c_char,
    room: usize,
    count: *mut usize,
) -> red_status {
    on(runtime, |engine| {
        let out = Room::of(text.cast::<u8>(), room, count)?;
        // Not between a refusal and its words.
        let (_state, said) = (engine.state(), engine.said());
        Ok(out.fill(said.bytes().filter(|byte| *byte != 0).chain([0])))
    })
}

/// What the runtime did so far, or did.
///
/// Threads: any, at once. Real time: no. Time: O(1), but until a start that goes on is over. Errors: those of the
/// handle, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_report(runtime: *const red_runtime, report: *mut red_report) -> red_status {
    on(runtime, |engine| {
        let out = OutGrowing::of(report)?;
        let state = engine.state();
        let known = if let State::Ended(report) = &*state { **report } else { red_report::BEFORE_THE_END };
        let (notes, count) = (&engine.notes, |of: &core::sync::atomic::AtomicU64| of.load(Ordering::Relaxed));
        out.put(red_report {
            state: state_of(&state) as u32,
            released: count(&notes.released),
            on_time: count(&notes.on_time),
            missed: count(&notes.missed),
            shed: count(&notes.shed),
            threw: count(&engine.bodies.threw),
            outcomes_dropped: count(&notes.outcomes_dropped),
            events_dropped: count(&notes.events_dropped),
            ..known
        });
        Ok(red_status::Ok)
    })
}
