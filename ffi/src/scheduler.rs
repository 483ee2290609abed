#![allow(unsafe_code, reason = "names of C")]
//! The scheduler: opened in memory of C's, with its pools and sensors.

use crate::boundary::{Memory, Out, OutGrowing, take, take_growing};
use crate::capacity::{Large, Medium, Small};
use crate::config::{self, red_config};
use crate::handles::{self, Object};
use crate::machine::{Rest, Shared};
use crate::status::{flat, red_status, status};
use crate::values::{RED_ABI_VERSION, red_scheduler};
use core::ffi::{c_char, c_void};
use red_core::{Capacity, Duration, Instant, PoolId};

/// The version of the ABI that this library has: RED_ABI_VERSION of its header.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_abi_version() -> u32 {
    RED_ABI_VERSION
}

/// The version of this library, as "0.1.0". The text is constant.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}

fn open<C: Capacity>(
    memory: *mut c_void,
    bytes: usize,
    config: *const red_config,
    scheduler: *mut red_scheduler,
) -> red_status {
    flat(Out::of(scheduler).and_then(|out| {
        let config = take_growing(config)?.read()?;
        if config.lanes == 0 {
            return Err(red_status::NoLane);
        }
        if usize::from(config.lanes) > C::LANES {
            return Err(red_status::PoolsFull);
        }
        let place = Memory::of(memory, bytes).room_for::<Shared<C>>()?;
        place.apart_from(&out)?;
        let make = || {
            place.make(Shared::<C>::NEW);
            place.set_up(|host| host.get_mut().configure(config));
            Object::Scheduler(place.pointer())
        };
        out.put(red_scheduler { bits: handles::open(&place.range(), make)? });
        Ok(red_status::Ok)
    }))
}

/// Makes a call on a scheduler that changes it.
#[inline(always)]
pub(crate) fn change(
    scheduler: *const red_scheduler,
    call: impl FnOnce(&mut Rest) -> Result<red_status, red_status>,
) -> red_status {
    flat(
        take(scheduler).and_then(|scheduler| call(&mut *handles::scheduler(scheduler.bits)?.rest().enter()?)),
    )
}

/// Makes a call on a scheduler that only looks.
pub(crate) fn look(
    scheduler: *const red_scheduler,
    call: impl FnOnce(&Rest) -> Result<red_status, red_status>,
) -> red_status {
    flat(take(scheduler).and_then(|scheduler| call(handles::scheduler(scheduler.bits)?.rest().look()?)))
}

/// Opens a scheduler of 4 tasks of 16 nodes and 16 jobs in flight; 4 lanes in 2 pools, 64 events. `memory`, of
/// RED_SCHEDULER_4X16X16_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
///
/// Threads: any, at once. Real time: no. Time: O(memory). Errors: RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED,
/// RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL: more lanes than the class has,
/// RED_STATUS_OUT_OF_RANGE: another field of the configuration.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_open_4x16x16(
    memory: *mut c_void,
    bytes: usize,
    config: *const red_config,
    scheduler: *mut red_scheduler,
) -> red_status {
    open::<Small>(memory, bytes, config, scheduler)
}

/// Opens a scheduler of 8 tasks of 64 nodes and 32 jobs in flight; 8 lanes in 4 pools, 256 events. `memory`, of
/// RED_SCHEDULER_8X64X32_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
///
/// Threads: any, at once. Real time: no. Time: O(memory). Errors: as red_scheduler_open_4x16x16.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_open_8x64x32(
    memory: *mut c_void,
    bytes: usize,
    config: *const red_config,
    scheduler: *mut red_scheduler,
) -> red_status {
    open::<Medium>(memory, bytes, config, scheduler)
}

/// Opens a scheduler of 16 tasks of 256 nodes and 64 jobs in flight; 32 lanes in 32 pools, 1,024 events. `memory`, of
/// RED_SCHEDULER_16X256X64_BYTES and aligned to RED_ALIGN, is the library's until red_scheduler_close.
///
/// Threads: any, at once. Real time: no. Time: O(memory). Errors: as red_scheduler_open_4x16x16.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_open_16x256x64(
    memory: *mut c_void,
    bytes: usize,
    config: *const red_config,
    scheduler: *mut red_scheduler,
) -> red_status {
    open::<Large>(memory, bytes, config, scheduler)
}

/// Closes a scheduler; its memory is the caller's again. A log that red_record_end did not end is let go, and is not whole.
///
/// Threads: one at a time on a scheduler. Real time: yes, without a log. Time: O(1). Errors: RED_STATUS_CLOSED.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_close(scheduler: *mut red_scheduler) -> red_status {
    flat(Out::of(scheduler).and_then(|out| {
        let bits = take(scheduler)?.bits;
        let mut alone = handles::scheduler(bits)?.rest().enter()?;
        handles::close(bits)?;
        alone.drop_log();
        out.put(red_scheduler::default());
        Ok(red_status::Ok)
    }))
}

/// Adds a pool of `lanes` lanes after the others; the first, 0, is that of the configuration. `memory_bytes` is its budget,
/// RED_NONE_64: unlimited.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(lanes). Errors: RED_STATUS_NO_LANE,
/// RED_STATUS_POOLS_FULL.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_add_pool(
    scheduler: *mut red_scheduler,
    lanes: u32,
    memory_bytes: u64,
    pool: *mut u32,
) -> red_status {
    change(scheduler, |machine| {
        let out = Out::of(pool)?;
        let lanes = u8::try_from(lanes).map_err(|_| red_status::PoolsFull)?;
        let added = machine.add_pool(lanes, config::bytes(memory_bytes));
        Ok(status(added, |id: PoolId| out.put(id.index() as u32)))
    })
}

/// Has a pool dispatch ahead: its lanes run by themselves what they are given, in its order, as streams of a GPU do. Polls then
/// answer RED_ACTION_KIND_AHEAD, too: a unit that its lane is given while what comes before it runs. Certificates take it
/// into account.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_POOL,
/// RED_STATUS_NOT_AHEAD.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_dispatch_ahead(scheduler: *mut red_scheduler, pool: u32) -> red_status {
    change(scheduler, |machine| {
        let pool = pool_id(machine, pool)?;
        Ok(if machine.dispatch_ahead(pool) { red_status::Ok } else { red_status::NotAhead })
    })
}

/// Gives a pool up, because what its lanes ran on is gone: jobs that still need it end with RED_SHED_FAULT, and so does each
/// that is released from now on. Units that run there have to be reported all the same.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: RED_STATUS_UNKNOWN_POOL.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_lose_pool(
    scheduler: *mut red_scheduler,
    pool: u32,
    now_ns: u64,
) -> red_status {
    change(scheduler, |machine| {
        let pool = pool_id(machine, pool)?;
        machine.lose_pool(pool, Instant::from_nanos(now_ns));
        Ok(red_status::Ok)
    })
}

/// A pool of this number.
fn pool_id(machine: &Rest, pool: u32) -> Result<PoolId, red_status> {
    if pool < machine.pools() { Ok(PoolId::new(pool as u8)) } else { Err(red_status::UnknownPool) }
}

/// Makes a sensor known that captures a frame each `period_ns`, from time 0 on; jobs released between two captures share the
/// earlier one. Sensors of one period are one: the frame's number tells them apart.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(sensors). Errors: RED_STATUS_ZERO_PERIOD,
/// RED_STATUS_SENSORS_FULL.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_add_sensor(
    scheduler: *mut red_scheduler,
    period_ns: u64,
    sensor: *mut u32,
) -> red_status {
    change(scheduler, |machine| {
        let out = Out::of(sensor)?;
        let added = machine.add_sensor(Duration::from_nanos(period_ns));
        Ok(status(added, |id| out.put(id.index() as u32)))
    })
}

/// The configuration of a scheduler.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: those of the handle.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_config(
    scheduler: *const red_scheduler,
    config: *mut red_config,
) -> red_status {
    look(scheduler, |machine| {
        let out = OutGrowing::of(config)?;
        out.put(red_config::of(machine.config()));
        Ok(red_status::Ok)
    })
}

/// Bytes that running units and kept results hold of a pool's budget.
///
/// Threads: any, while nobody changes the scheduler. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_POOL.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_memory_used(
    scheduler: *const red_scheduler,
    pool: u32,
    used_bytes: *mut u64,
) -> red_status {
    look(scheduler, |machine| {
        let out = Out::of(used_bytes)?;
        out.put(machine.memory_used(pool_id(machine, pool)?).0);
        Ok(red_status::Ok)
    })
}

/// Bytes that red_scheduler_open_4x16x16 needs here: at most RED_SCHEDULER_4X16X16_BYTES.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_bytes_4x16x16() -> usize {
    size_of::<Shared<Small>>()
}

/// Bytes that red_scheduler_open_8x64x32 needs here: at most RED_SCHEDULER_8X64X32_BYTES.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_bytes_8x64x32() -> usize {
    size_of::<Shared<Medium>>()
}

/// Bytes that red_scheduler_open_16x256x64 needs here: at most RED_SCHEDULER_16X256X64_BYTES.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_bytes_16x256x64() -> usize {
    size_of::<Shared<Large>>()
}

/// The alignment that all memory needs which is lent to this library: at most RED_ALIGN.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_align() -> usize {
    align_of::<Shared<Large>>()
}
