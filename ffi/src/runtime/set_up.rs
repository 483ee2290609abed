#![allow(unsafe_code, reason = "names of C")]
//! What a runtime is before it starts: pools, sensors, CPUs, releases by the clock, a log.

use super::on_device::OnDevice;
use super::open::{on, with_room};
use super::text;
use super::values::{red_mode, red_runtime};
use crate::boundary::{Array, Out};
use crate::config;
use crate::log::no_file;
use crate::room::{OF_A_LOG, room};
use crate::status::{flat, red_status, status};
use core::ffi::c_char;
use red_core::{Duration, PoolError, PoolId, TaskId};
use red_record::class::Large;
use red_record::{Header, StartError, Writer};
use red_rt::timeline::Releases;
use std::path::Path;

/// Lanes, and CPUs, at most.
const MOST_CPUS: usize = 32;

/// Adds a pool of `lanes` lanes after the others; the first, 0, is that of the configuration. `memory_bytes` is its budget,
/// RED_NONE_64: unlimited. Before the start only.
///
/// Threads: any, at once. Real time: no. Time: O(lanes). Errors: RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL,
/// RED_STATUS_STARTED, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_add_pool(
    runtime: *mut red_runtime,
    lanes: u32,
    memory_bytes: u64,
    pool: *mut u32,
) -> red_status {
    on(runtime, |engine| {
        let out = Out::of(pool)?;
        let lanes = u8::try_from(lanes).map_err(|_| red_status::PoolsFull)?;
        engine.set_up(|set_up| {
            let added = set_up.call(|calls| calls.add_pool(lanes, config::bytes(memory_bytes)));
            Ok(status(added, |id| out.put(id.index() as u32)))
        })
    })
}

/// Adds a pool of `lanes` lanes after the others that are streams of a CUDA device, by its number from 0. The driver is loaded
/// at run time. A body of a node there has the lane's stream in its context, submits its work to that, and returns without
/// waiting for it: it has ended when the stream gets there. Nodes start on the device after those they follow, without the
/// CPU in between; what follows on the CPU starts when the stream got there. Streams are of the device's primary context, which
/// is the calling lane's; make what bodies need before the start, for the whole device may wait for an allocation or a module.
/// Before the start only; one device for a runtime.
///
/// Threads: any, at once. Real time: no. Time: the driver's, on first use a second. Errors: RED_STATUS_CUDA,
/// RED_STATUS_OUT_OF_RANGE: another device than that of a pool before, RED_STATUS_NO_LANE, RED_STATUS_POOLS_FULL,
/// RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_add_cuda_pool(
    runtime: *mut red_runtime,
    device: u32,
    lanes: u32,
    memory_bytes: u64,
    pool: *mut u32,
) -> red_status {
    with_room(runtime, |engine| {
        let out = Out::of(pool)?;
        let lanes = u8::try_from(lanes).map_err(|_| red_status::PoolsFull)?;
        let ordinal = i32::try_from(device).map_err(|_| red_status::OutOfRange)?;
        engine.set_up(|set_up| {
            let mut on = match &set_up.device {
                Some(on) if on.ordinal == ordinal => on.clone(),
                Some(_) => return Err(red_status::OutOfRange),
                None => {
                    engine.said().clear();
                    OnDevice::open(ordinal).map_err(|why| {
                        *engine.said() = why.to_string();
                        red_status::Cuda
                    })?
                }
            };
            let first = set_up.scheduler.lanes();
            let added = set_up.call(|calls| {
                let pool = calls.add_pool(lanes, config::bytes(memory_bytes))?;
                // Not where the policy opens graphs level by level: nothing is ahead there.
                calls.dispatch_ahead(pool);
                Ok::<_, PoolError>(pool)
            });
            Ok(status(added, |id: PoolId| {
                on.lanes |= (first..first + usize::from(lanes)).fold(0, |set, lane| set | 1 << lane);
                on.pools.push(id);
                set_up.device = Some(on);
                out.put(id.index() as u32);
            }))
        })
    })
}

/// Makes a sensor known that captures a frame each `period_ns` from the start on; jobs released between two captures share
/// the earlier one. Sensors of one period are one: the frame's number tells them apart. Before the start only.
///
/// Threads: any, at once. Real time: no. Time: O(sensors). Errors: RED_STATUS_ZERO_PERIOD, RED_STATUS_SENSORS_FULL,
/// RED_STATUS_STARTED, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_add_sensor(
    runtime: *mut red_runtime,
    period_ns: u64,
    sensor: *mut u32,
) -> red_status {
    on(runtime, |engine| {
        let out = Out::of(sensor)?;
        engine.set_up(|set_up| {
            let added = set_up.call(|calls| calls.add_sensor(Duration::from_nanos(period_ns)));
            Ok(status(added, |id| out.put(id.index() as u32)))
        })
    })
}

/// Pins lane i to the i-th of `cpus`, in real time: as many as there are lanes, each another one. Without this call they are
/// chosen, CPU 0 last. Before the start only.
///
/// Threads: any, at once. Real time: no. Time: O(count). Errors: RED_STATUS_TOO_LONG: more than 32,
/// RED_STATUS_OUT_OF_RANGE: CPU 1024 and above, RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_pin(runtime: *mut red_runtime, cpus: *const u32, count: usize) -> red_status {
    with_room(runtime, |engine| {
        let given = Array::of(cpus, count, MOST_CPUS)?;
        if given.iter().any(|cpu| cpu >= 1024) {
            return Err(red_status::OutOfRange);
        }
        engine.set_up(|set_up| {
            set_up.cpus = given.iter().map(|cpu| cpu as usize).collect();
            Ok(red_status::Ok)
        })
    })
}

/// Has jobs of a task released by the clock: the first `first_ns` after the start, then each `period_ns`; 0: one only. Before
/// the start only.
///
/// Threads: any, at once. Real time: no. Time: O(1). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_STARTED,
/// RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_every(
    runtime: *mut red_runtime,
    task: u32,
    first_ns: u64,
    period_ns: u64,
) -> red_status {
    with_room(runtime, |engine| {
        engine.set_up(|set_up| {
            let task = TaskId::from_bits(task);
            let _there = set_up.scheduler.certificate(task).ok_or(red_status::UnknownTask)?;
            let period_ns = (period_ns > 0).then_some(period_ns);
            set_up.releases.try_reserve(1).map_err(|_| red_status::NoMemory)?;
            set_up.releases.push(Releases { task, first_ns, period_ns });
            Ok(red_status::Ok)
        })
    })
}

/// Records every input of the run in a log at `path` (UTF-8), which `redrt replay` feeds to a scheduler again. Before anything
/// else is set up.
///
/// Threads: any, at once. Real time: no. Time: one file is created. Errors: RED_STATUS_TEXT, RED_STATUS_LOG_LATE,
/// RED_STATUS_LOG_FILE: red_runtime_message and errno say why, RED_STATUS_STARTED, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_record(runtime: *mut red_runtime, path: *const c_char) -> red_status {
    on(runtime, |engine| {
        room(OF_A_LOG)?;
        let path = text::take(path)?;
        engine.set_up(|set_up| {
            if set_up.is_begun || set_up.tape.is_some() {
                return Err(red_status::LogLate);
            }
            let program = concat!("libred ", env!("CARGO_PKG_VERSION"));
            let mut header = Header::by_calls::<Large>(program, "custom", *set_up.scheduler.config());
            header.realtime = engine.config.mode == red_mode::RealTime as u32;
            header.duration_ns = engine.config.duration_ns;
            let (writer, tape) = Writer::start(Path::new(&path), &header).map_err(|why| {
                let fix = if matches!(why, StartError::File(_)) {
                    "; fix: choose a file that can be written"
                } else {
                    ""
                };
                *engine.said() = format!("{path}: {why}{fix}");
                no_file(Some(why.into()))
            })?;
            engine.said().clear();
            (set_up.writer, set_up.tape) = (Some(writer), Some(tape));
            Ok(red_status::Ok)
        })
    })
}

/// Nanoseconds of CLOCK_MONOTONIC, the clock of all times that the runtime takes and gives.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none besides a NULL or misaligned pointer.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_now(now_ns: *mut u64) -> red_status {
    flat(Out::of(now_ns).map(|out| {
        out.put(red_rt::clock::now_ns());
        red_status::Ok
    }))
}
