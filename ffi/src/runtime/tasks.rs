#![allow(unsafe_code, reason = "names of C")]
//! Tasks of a runtime: admitted, edited, removed, before the start and while lanes run.

use super::bodies::Bodies;
use super::notes::Notes;
use super::open::{on, with_room};
use super::task_report::red_task_report;
use super::values::{red_callback, red_runtime};
use crate::boundary::{Array, Memory, Out, OutGrowing, take, take_growing};
use crate::dag::open_dag;
use crate::graph::MOST_NODES;
use crate::handles;
use crate::proof::red_certificate;
use crate::status::red_status;
use crate::values::{red_dag, red_timing};
use core::ffi::c_void;
use red_core::{Certificate, Dag, Instant, NodeId, TaskId, Timing};
use red_record::Recorder;
use red_record::class::Large;

/// What C gives for a graph: a copy of it, and its bodies by node.
struct Given {
    dag: Box<Dag<Large>>,
    /// The runtime that an edit was begun on is this one.
    may_change: Result<(), red_status>,
    callbacks: Vec<red_callback>,
}

// SAFETY: the pointers in it are C's, which vouches that bodies may be called from any lane.
unsafe impl Send for Given {}

impl Given {
    fn take(
        runtime: *const red_runtime,
        dag: *const red_dag,
        callbacks: *const red_callback,
        count: usize,
    ) -> Result<Self, red_status> {
        let callbacks: Vec<red_callback> = Array::of(callbacks, count, MOST_NODES)?.iter().collect();
        let graph = handles::graph(take(dag)?.bits)?.look()?;
        let dag = graph.any().downcast_ref::<Dag<Large>>().ok_or(red_status::OtherClass)?;
        for (i, callback) in callbacks.iter().enumerate() {
            let is_there = u8::try_from(callback.node).is_ok_and(|node| dag.contains(NodeId::new(node)));
            let is_twice = callbacks.iter().take(i).any(|before| before.node == callback.node);
            if !is_there || is_twice {
                return Err(red_status::UnknownNode);
            }
            if callback.reserved != 0 {
                return Err(red_status::UnknownField);
            }
            if callback.body.is_none() {
                return Err(red_status::NoBody);
            }
        }
        let may_change = graph.may_change(take(runtime)?.bits);
        Ok(Self { dag: Box::new(*dag), may_change, callbacks })
    }

    fn has(&self, node: NodeId) -> bool {
        self.callbacks.iter().any(|callback| callback.node as usize == node.index())
    }

    fn add(
        &self,
        scheduler: &mut Recorder<'_, Large>,
        timing: Timing,
        bodies: &Bodies,
        notes: &Notes,
    ) -> Result<TaskId, red_status> {
        let task = scheduler.add_task(&self.dag, timing)?;
        if let Some(of_task) = notes.tasks.get(task.index()) {
            of_task.begin(task, &timing);
        }
        bodies.set(task, scheduler.counters().units, &self.callbacks);
        Ok(task)
    }

    /// New nodes have a body, and others keep theirs, which jobs in flight may be about to run.
    fn commit(
        &self,
        scheduler: &mut Recorder<'_, Large>,
        now: Instant,
        bodies: &Bodies,
    ) -> Result<Certificate, red_status> {
        self.may_change?;
        let (task, _) = self.dag.origin();
        for node in self.dag.nodes() {
            let wrong = match (scheduler.task_node(task, node).is_some(), self.has(node)) {
                (false, false) => red_status::NoBody,
                (true, true) => red_status::HasBody,
                _ => continue,
            };
            return Err(self.left_behind(scheduler).unwrap_or(wrong));
        }
        let proof = scheduler.commit(&self.dag, now)?;
        bodies.set(task, scheduler.counters().units, &self.callbacks);
        Ok(proof)
    }

    /// Which nodes are new says nothing where the edit is of a graph that is no more.
    fn left_behind(&self, scheduler: &Recorder<'_, Large>) -> Option<red_status> {
        match (**scheduler).edit(self.dag.origin().0) {
            None => Some(red_status::UnknownTask),
            Some(newest) => (newest.origin() != self.dag.origin()).then_some(red_status::Conflict),
        }
    }
}

/// Admits a task, also while lanes run. The graph (of class 16x256x64) is copied; `callbacks` has a body for each of its nodes.
///
/// Threads: any but a body's, at once, while nobody changes the graph. Real time: no. Time: until a lane has a turn. Errors:
/// RED_STATUS_TASKS_FULL, RED_STATUS_EMPTY_GRAPH, RED_STATUS_DEADLINE, RED_STATUS_UNKNOWN_POOL,
/// RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE, RED_STATUS_OTHER_CLASS,
/// RED_STATUS_OUT_OF_RANGE: floor_keep above floor_of; RED_STATUS_NO_BODY; RED_STATUS_UNKNOWN_NODE: a body for no node, or
/// two for one; RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_add_task(
    runtime: *mut red_runtime,
    dag: *const red_dag,
    callbacks: *const red_callback,
    callback_count: usize,
    timing: *const red_timing,
    task: *mut u32,
) -> red_status {
    with_room(runtime, |engine| {
        let out = Out::of(task)?;
        let timing = take_growing(timing)?.read()?;
        let given = Given::take(runtime, dag, callbacks, callback_count)?;
        if given.dag.nodes().any(|node| !given.has(node)) {
            return Err(red_status::NoBody);
        }
        let (bodies, notes) = (engine.bodies.clone(), engine.notes.clone());
        let added = engine.change(move |scheduler, _now| given.add(scheduler, timing, &bodies, &notes))?;
        out.put(added.to_bits());
        Ok(red_status::Ok)
    })
}

/// Removes a task; its jobs in flight are given up with the reason RED_SHED_REMOVED. Bodies that run go on to their ends.
///
/// Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
/// RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_remove_task(runtime: *mut red_runtime, task: u32) -> red_status {
    with_room(runtime, |engine| {
        let task = TaskId::from_bits(task);
        engine.change(move |scheduler, now| {
            if scheduler.remove_task(task, now) { Ok(red_status::Ok) } else { Err(red_status::UnknownTask) }
        })
    })
}

/// The bound on the response time of the task's newest graph, alone on its pools.
///
/// Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
/// RED_STATUS_BUSY: from a body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_certificate(
    runtime: *mut red_runtime,
    task: u32,
    certificate: *mut red_certificate,
) -> red_status {
    with_room(runtime, |engine| {
        let out = OutGrowing::of(certificate)?;
        let task = TaskId::from_bits(task);
        let proof = engine.look(move |scheduler| scheduler.certificate(task))?;
        out.put(proof.ok_or(red_status::UnknownTask)?.into());
        Ok(red_status::Ok)
    })
}

/// What became of the task's jobs so far; also after the end of the run.
///
/// Threads: any, at once, also a body. Real time: yes. Time: O(1). Errors: RED_STATUS_UNKNOWN_TASK, RED_STATUS_FORKED.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_task_report(
    runtime: *const red_runtime,
    task: u32,
    report: *mut red_task_report,
) -> red_status {
    on(runtime, |engine| {
        let out = OutGrowing::of(report)?;
        let task = TaskId::from_bits(task);
        let of_task = engine.notes.tasks.get(task.index()).ok_or(red_status::UnknownTask)?;
        out.put(of_task.report(task).ok_or(red_status::UnknownTask)?);
        Ok(red_status::Ok)
    })
}

/// Begins an edit: opens the task's newest graph in `memory`, of RED_DAG_16X256X64_BYTES, to be changed, given to
/// red_runtime_commit, and closed. Closing it without a commit changes nothing.
///
/// Threads: any but a body's, at once. Real time: no. Time: until a lane has a turn. Errors: RED_STATUS_UNKNOWN_TASK,
/// RED_STATUS_TOO_SHORT, RED_STATUS_MISALIGNED, RED_STATUS_OVERLAP, RED_STATUS_TOO_MANY_OPEN, RED_STATUS_BUSY: from a
/// body; RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_edit(
    runtime: *mut red_runtime,
    task: u32,
    memory: *mut c_void,
    bytes: usize,
    dag: *mut red_dag,
) -> red_status {
    with_room(runtime, |engine| {
        let out = Out::of(dag)?;
        let place = Memory::of(memory, bytes).room_for()?;
        let task = TaskId::from_bits(task);
        let edit = engine.look(move |scheduler| scheduler.edit(task))?;
        open_dag(&place, edit.ok_or(red_status::UnknownTask)?, take(runtime)?.bits, out)?;
        Ok(red_status::Ok)
    })
}

/// Applies an edit to the jobs that are released from now on; jobs in flight keep the graph of their release. `callbacks` has a
/// body for each node that is new; others keep theirs. An edit that was begun on another runtime is none of this one's:
/// RED_STATUS_CONFLICT.
///
/// Threads: any but a body's, at once, while nobody changes the graph. Real time: no. Time: until a lane has a turn. Errors:
/// RED_STATUS_UNKNOWN_TASK, RED_STATUS_CONFLICT, RED_STATUS_DRAINING, RED_STATUS_EMPTY_GRAPH, RED_STATUS_UNKNOWN_POOL,
/// RED_STATUS_UNKNOWN_SENSOR, RED_STATUS_MEMORY, RED_STATUS_UNSCHEDULABLE, RED_STATUS_OTHER_CLASS, RED_STATUS_NO_BODY,
/// RED_STATUS_HAS_BODY, RED_STATUS_UNKNOWN_NODE: a body for no node, or two for one; RED_STATUS_BUSY: from a body;
/// RED_STATUS_OVER, RED_STATUS_FORKED, RED_STATUS_NO_MEMORY.
#[unsafe(no_mangle)]
pub extern "C" fn red_runtime_commit(
    runtime: *mut red_runtime,
    dag: *const red_dag,
    callbacks: *const red_callback,
    callback_count: usize,
    certificate: *mut red_certificate,
) -> red_status {
    with_room(runtime, |engine| {
        let out = OutGrowing::of(certificate)?;
        let given = Given::take(runtime, dag, callbacks, callback_count)?;
        let bodies = engine.bodies.clone();
        let proof = engine.change(move |scheduler, now| given.commit(scheduler, now, &bodies))?;
        out.put(proof.into());
        Ok(red_status::Ok)
    })
}
