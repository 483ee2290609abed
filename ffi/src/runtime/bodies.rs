#![allow(unsafe_code, reason = "functions that C gives and lanes call")]
//! Which function runs for which node, and the call.

use super::values::{RED_BODY_DONE, RED_BODY_THREW, red_body, red_callback, red_context};
use crate::values::{RED_ABI_VERSION, RED_NONE};
use core::cell::Cell;
use core::ffi::c_void;
use core::ptr;
use core::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, Ordering, fence};
use red_core::{Capacity, NodeId, TaskId};
use red_record::class::Large;
use red_rt::handler::{Failed, Handler, Work};
use std::sync::Arc;

thread_local! {
    static IS_IN_BODY: Cell<bool> = const { Cell::new(false) };
}

/// Whether the calling thread is in a body, and so must not wait for lanes.
pub(crate) fn is_in_body() -> bool {
    IS_IN_BODY.get()
}

/// What runs for a node.
///
/// A lane reads it after it has given the scheduler's lock back. Meanwhile the task may be removed and another one admitted
/// in its place; the lane then gets nothing, and never the body of one with the `user` of the other.
#[derive(Default)]
struct Slot {
    /// Odd while somebody writes.
    version: AtomicU32,
    body: AtomicPtr<c_void>,
    user: AtomicPtr<c_void>,
}

impl Slot {
    /// One thread at a time.
    fn set(&self, body: *mut c_void, user: *mut c_void) {
        let version = self.version.load(Ordering::Relaxed);
        self.version.store(version.wrapping_add(1), Ordering::Relaxed);
        // Release: pairs with the Acquire fence in `get`, which then sees the odd version if it saw what follows.
        fence(Ordering::Release);
        self.user.store(user, Ordering::Relaxed);
        self.body.store(body, Ordering::Relaxed);
        // Release: pairs with the Acquire in `get`.
        self.version.store(version.wrapping_add(2), Ordering::Release);
    }

    /// Body and user of one `set`; `None` if another one came between.
    fn get(&self) -> Option<(*mut c_void, *mut c_void)> {
        // Acquire: pairs with the Release at the end of `set`.
        let version = self.version.load(Ordering::Acquire);
        let found = (self.body.load(Ordering::Relaxed), self.user.load(Ordering::Relaxed));
        // Acquire: pairs with the Release fence in `set`.
        fence(Ordering::Acquire);
        (version.is_multiple_of(2) && self.version.load(Ordering::Relaxed) == version).then_some(found)
    }
}

/// The bodies of all nodes of all tasks. Written under the scheduler's lock before a job with the node can be released.
pub(crate) struct Bodies {
    slots: Box<[Slot]>,
    /// Handles of tasks, by their places.
    tasks: Box<[AtomicU32]>,
    pub(crate) threw: AtomicU64,
}

impl Bodies {
    pub(crate) fn new() -> Arc<Self> {
        let slots = (0..Large::TASKS * Large::NODES).map(|_| Slot::default()).collect();
        let tasks = (0..Large::TASKS).map(|_| AtomicU32::new(0)).collect();
        Arc::new(Self { slots, tasks, threw: AtomicU64::new(0) })
    }

    fn slot(&self, task: usize, node: NodeId) -> Option<&Slot> {
        self.slots.get(task * Large::NODES + node.index())
    }

    /// Sets the bodies of a task's new nodes.
    pub(crate) fn set(&self, task: TaskId, callbacks: &[red_callback]) {
        if let Some(place) = self.tasks.get(task.index()) {
            place.store(task.to_bits(), Ordering::Relaxed);
        }
        for callback in callbacks {
            let Some(slot) = self.slot(task.index(), NodeId::new(callback.node as u8)) else { continue };
            let body = callback.body.map_or(ptr::null_mut(), |body| body as *mut c_void);
            slot.set(body, callback.user);
        }
    }

    fn get(&self, work: &Work) -> Option<(red_body, *mut c_void)> {
        let (body, user) = self.slot(work.task, work.node)?.get()?;
        // SAFETY: it is NULL, which is no body, or was made of a function of this type in `set`.
        let body = unsafe { core::mem::transmute::<*mut c_void, red_body>(body) };
        Some((body, user))
    }
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

impl Handler for Calls {
    fn begin(&mut self, origin_ns: u64) {
        self.origin_ns = origin_ns;
    }

    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        let Some((Some(body), user)) = self.bodies.get(work) else { return Err(Failed) };
        let since_boot = |ns: u64| self.origin_ns.saturating_add(ns);
        let task = self.bodies.tasks.get(work.task).map_or(0, |task| task.load(Ordering::Relaxed));
        let context = red_context {
            struct_size: size_of::<red_context>() as u32,
            abi_version: RED_ABI_VERSION,
            task,
            node: work.node.index() as u32,
            lane: work.lane.index() as u32,
            pool: work.pool.index() as u32,
            output: work.output.map_or(RED_NONE, u32::from),
            reserved: 0,
            job: work.job,
            release_ns: since_boot(work.release_ns),
            deadline_ns: since_boot(work.deadline_ns),
            sub_deadline_ns: since_boot(work.sub_deadline_ns),
            wcet_ns: work.wcet_ns,
            stream: ptr::null_mut(),
        };
        IS_IN_BODY.set(true);
        let answer = body(user, &raw const context);
        IS_IN_BODY.set(false);
        if answer == RED_BODY_THREW {
            self.bodies.threw.fetch_add(1, Ordering::Relaxed);
        }
        if answer == RED_BODY_DONE { Ok(()) } else { Err(Failed) }
    }
}
