#![allow(unsafe_code, reason = "names of C")]
//! Tasks: admitted, edited, removed.

use crate::boundary::{Memory, Out, OutGrowing, take, take_growing};
use crate::graph::AnyGraph;
use crate::handles;
use crate::machine::Rest;
use crate::proof::red_certificate;
use crate::scheduler::{change, look};
use crate::status::red_status;
use crate::values::{red_dag, red_scheduler, red_timing};
use core::ffi::c_void;
use red_core::{Duration, Instant, TaskId, Timing};

impl red_timing {
    pub(crate) fn read(self) -> Result<Timing, red_status> {
        if self.reserved != 0 {
            return Err(red_status::UnknownField);
        }
        if self.floor_keep > self.floor_of {
            return Err(red_status::OutOfRange);
        }
        let timing = Timing::new(Duration::from_nanos(self.deadline_ns)).value(self.value);
        let timing = if self.floor_of > 0 { timing.floor(self.floor_keep, self.floor_of) } else { timing };
        Ok(if self.period_ns > 0 { timing.every(Duration::from_nanos(self.period_ns)) } else { timing })
    }
}

/// Makes a call that changes a scheduler and takes a graph.
fn change_by(
    scheduler: *const red_scheduler,
    dag: *const red_dag,
    call: impl FnOnce(&mut Rest, &AnyGraph) -> Result<red_status, red_status>,
) -> red_status {
    change(scheduler, |machine| call(machine, handles::graph(take(dag)?.bits)?.look()?))
}

/// Admits a task. The graph is copied.
///
/// Threads: one at a time on a scheduler, while nobody changes the graph. Real time: no. Time: O(lanes * (nodes + edges) +
/// nodes log nodes). Errors: RED_STATUS_TASKS_FULL, RED_STATUS_EMPTY_GRAPH, RED_STATUS_DEADLINE,
/// RED_STATUS_UNKNOWN_POOL, RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE,
/// RED_STATUS_OTHER_CLASS, RED_STATUS_OUT_OF_RANGE: floor_keep above floor_of.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_add_task(
    scheduler: *mut red_scheduler,
    dag: *const red_dag,
    timing: *const red_timing,
    task: *mut u32,
) -> red_status {
    change_by(scheduler, dag, |machine, graph| {
        let out = Out::of(task)?;
        let timing = take_growing(timing)?.read()?;
        out.put(machine.add_task(graph, timing)?.to_bits());
        Ok(red_status::Ok)
    })
}

/// Removes a task; its jobs in flight are given up with the reason RED_SHED_REMOVED.
///
/// Threads: one at a time on a scheduler. Real time: yes. Time: O(jobs * nodes). Errors: RED_STATUS_UNKNOWN_TASK.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_remove_task(
    scheduler: *mut red_scheduler,
    task: u32,
    now_ns: u64,
) -> red_status {
    change(scheduler, |machine| {
        let removed = machine.remove_task(TaskId::from_bits(task), Instant::from_nanos(now_ns));
        Ok(if removed { red_status::Ok } else { red_status::UnknownTask })
    })
}

/// The bound on the response time of the task's newest graph, alone on its pools.
///
/// Threads: any, while nobody changes the scheduler. Real time: no. Time: O(lanes * (nodes + edges)). Errors:
/// RED_STATUS_UNKNOWN_TASK.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_certificate(
    scheduler: *const red_scheduler,
    task: u32,
    certificate: *mut red_certificate,
) -> red_status {
    look(scheduler, |machine| {
        let out = OutGrowing::of(certificate)?;
        let proof = machine.certificate(TaskId::from_bits(task)).ok_or(red_status::UnknownTask)?;
        out.put(proof.into());
        Ok(red_status::Ok)
    })
}

/// Begins an edit: opens the task's newest graph as one of its own, to be changed and given to red_scheduler_commit, and
/// closed. `memory` is as for red_dag_open of the scheduler's class. Closing it without a commit changes nothing.
///
/// Threads: any, while nobody changes the scheduler. Real time: no. Time: O(nodes + edges). Errors:
/// RED_STATUS_UNKNOWN_TASK, RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED, RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_edit(
    scheduler: *const red_scheduler,
    task: u32,
    memory: *mut c_void,
    bytes: usize,
    dag: *mut red_dag,
) -> red_status {
    look(scheduler, |machine| {
        let out = Out::of(dag)?;
        machine.edit(take(scheduler)?.bits, TaskId::from_bits(task), Memory::of(memory, bytes), out)?;
        Ok(red_status::Ok)
    })
}

/// Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release. An edit that was
/// begun on another scheduler is none of this one's: RED_STATUS_CONFLICT.
///
/// Threads: one at a time on a scheduler, while nobody changes the graph. Real time: no. Time: O(nodes log nodes + lanes *
/// (nodes + edges)). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_CONFLICT, RED_STATUS_DRAINING, RED_STATUS_EMPTY_GRAPH,
/// RED_STATUS_UNKNOWN_POOL, RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE,
/// RED_STATUS_OTHER_CLASS.
#[unsafe(no_mangle)]
pub extern "C" fn red_scheduler_commit(
    scheduler: *mut red_scheduler,
    dag: *const red_dag,
    now_ns: u64,
    certificate: *mut red_certificate,
) -> red_status {
    change_by(scheduler, dag, |machine, graph| {
        let out = OutGrowing::of(certificate)?;
        out.put(machine.commit(take(scheduler)?.bits, graph, Instant::from_nanos(now_ns))?.into());
        Ok(red_status::Ok)
    })
}
