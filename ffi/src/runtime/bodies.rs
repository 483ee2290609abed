#![allow(unsafe_code, reason = "functions that C gives and lanes call")]
//! Which function runs for which node, and the call.

use super::fork;
use super::values::{RED_BODY_DONE, RED_BODY_THREW, red_body, red_callback, red_context};
use crate::values::{RED_ABI_VERSION, RED_NONE};
use core::cell::Cell;
use core::ffi::c_void;
use core::ptr;
use core::sync::atomic::{AtomicU64, Ordering};
use red_core::{Capacity, NodeId, TaskId};
use red_record::class::Large;
use red_rt::cuda::{self, NotSubmitted};
use red_rt::handler::{Failed, Handler, Work};
use red_sync::SeqLock;
use std::sync::Arc;

thread_local! {
    /// The process in which this thread is in a body: a child that a body forks is in none.
    static IN_BODY: Cell<Option<u32>> = const { Cell::new(None) };
}

/// Whether the calling thread is in a body, and so must not wait for lanes.
pub(crate) fn is_in_body() -> bool {
    IN_BODY.get() == Some(fork::generation())
}

/// Task, units that were started before, body and `user` of a node.
type Slot = SeqLock<4>;

/// The bodies of all nodes of all tasks. Written under the scheduler's lock before a job with the node can be released.
///
/// A lane reads them after it has given that lock back. Meanwhile the task or the node may be removed, and another one come
/// in its place: the lane then finds the other task's name, or a node that is younger than its unit, and runs nothing.
pub(crate) struct Bodies {
    slots: Box<[Slot]>,
    pub(crate) threw: AtomicU64,
}

impl Bodies {
    pub(crate) fn new() -> Arc<Self> {
        let slots = (0..Large::TASKS * Large::NODES).map(|_| Slot::new()).collect();
        Arc::new(Self { slots, threw: AtomicU64::new(0) })
    }

    fn slot(&self, task: TaskId, node: NodeId) -> Option<&Slot> {
        self.slots.get(task.index() * Large::NODES + node.index())
    }

    /// Sets the bodies of a task's new nodes, which so many units were started before.
    pub(crate) fn set(&self, task: TaskId, units: u64, callbacks: &[red_callback]) {
        for callback in callbacks {
            let Some(slot) = self.slot(task, NodeId::new(callback.node as u8)) else { continue };
            let body = callback.body.map_or(ptr::null_mut(), |body| body as *mut ());
            slot.write([name(task), word(units), body, callback.user.cast()]);
        }
    }

    fn get(&self, work: &Work) -> Option<(red_body, *mut c_void)> {
        let [task, units, body, user] = self.slot(work.task, work.node)?.read()?;
        // SAFETY: it is NULL, which is no body, or was made of a function of this type in `set`.
        let body = unsafe { core::mem::transmute::<*mut (), red_body>(body) };
        let is_its = task == name(work.task) && (units.addr() as u64) < work.unit.to_bits() >> 16;
        is_its.then_some((body, user.cast()))
    }
}

/// A task as a word.
fn name(task: TaskId) -> *mut () {
    word(task.to_bits().into())
}

fn word(number: u64) -> *mut () {
    ptr::without_provenance_mut(number as usize)
}

/// Calls the bodies on a lane.
pub(crate) struct Calls {
    bodies: Arc<Bodies>,
    origin_ns: u64,
}

impl Calls {
    pub(crate) const fn new(bodies: Arc<Bodies>) -> Self {
        Self { bodies, origin_ns: 0 }
    }
}

impl Calls {
    fn call(&self, work: &Work, stream: *mut c_void) -> Result<(), Failed> {
        let Some((Some(body), user)) = self.bodies.get(work) else { return Err(Failed) };
        let since_boot = |ns: u64| self.origin_ns.saturating_add(ns);
        let context = red_context {
            struct_size: size_of::<red_context>() as u32,
            abi_version: RED_ABI_VERSION,
            task: work.task.to_bits(),
            node: work.node.index() as u32,
            lane: work.lane().index() as u32,
            pool: work.pool.index() as u32,
            output: work.output.map_or(RED_NONE, u32::from),
            reserved: 0,
            job: work.job,
            release_ns: since_boot(work.release_ns),
            deadline_ns: since_boot(work.deadline_ns),
            sub_deadline_ns: since_boot(work.sub_deadline_ns),
            wcet_ns: work.wcet_ns,
            stream,
        };
        IN_BODY.set(Some(fork::generation()));
        let answer = body(user, &raw const context);
        IN_BODY.set(None);
        if answer == RED_BODY_THREW {
            self.bodies.threw.fetch_add(1, Ordering::Relaxed);
        }
        if answer == RED_BODY_DONE { Ok(()) } else { Err(Failed) }
    }
}

impl Handler for Calls {
    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.call(work, ptr::null_mut())
    }
}

impl cuda::Bodies for Calls {
    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn submit(&mut self, work: &Work, stream: &cuda::Stream) -> Result<(), NotSubmitted> {
        self.call(work, stream.as_ptr()).map_err(|Failed| NotSubmitted::Body)
    }
}

#[cfg(test)]
mod tests;
