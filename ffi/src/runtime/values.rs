//! Structs and numbers of the runtime that go through the header.

use crate::boundary::{Growing, Plain, plain};
use core::ffi::{c_int, c_void};
use red_core::Empty;

/// A runtime: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct red_runtime {
    /// For the library.
    pub bits: u64,
}
plain!(red_runtime { bits: u64 });

/// How the lanes run.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_mode {
    /// SCHED_FIFO, memory locked, each lane alone on a CPU. Without the rights red_runtime_start is refused.
    RealTime = 0,
    /// Ordinary threads that share CPUs: no promise. red_report says so.
    BestEffort = 1,
}

/// How a runtime runs. Begin with RED_RUNTIME_CONFIG_INIT.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_runtime_config {
    /// RED_RUNTIME_CONFIG_INIT sets it.
    pub struct_size: u32,
    /// RED_RUNTIME_CONFIG_INIT sets it.
    pub abi_version: u32,
    /// One of red_mode.
    pub mode: u32,
    /// Of SCHED_FIFO; 1 to 98, the watchdog runs one above. RED_RUNTIME_CONFIG_INIT: 80.
    pub priority: u32,
    /// No release from then on after the start; 0: until red_runtime_stop.
    pub duration_ns: u64,
    /// How long jobs in flight may go on after that. RED_RUNTIME_CONFIG_INIT: 1 s.
    pub drain_ns: u64,
}
plain!(red_runtime_config {
    struct_size: u32,
    abi_version: u32,
    mode: u32,
    priority: u32,
    duration_ns: u64,
    drain_ns: u64,
});
impl Growing for red_runtime_config {
    const LEAST: usize = 32;
}

/// What a body is told. Times are nanoseconds of CLOCK_MONOTONIC.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_context {
    /// Size of this struct in the library.
    pub struct_size: u32,
    /// RED_ABI_VERSION of the library.
    pub abi_version: u32,
    /// The task.
    pub task: u32,
    /// The node.
    pub node: u32,
    /// Where it runs, counted over all pools.
    pub lane: u32,
    /// The lane's pool.
    pub pool: u32,
    /// Number of the encoder result that it writes or reads, or RED_NONE. One number stays the same result until
    /// nobody in flight needs it.
    pub output: u32,
    /// 0.
    pub reserved: u32,
    /// The how-manieth job of its task, from 0.
    pub job: u64,
    /// When the job was released.
    pub release_ns: u64,
    /// When the job is due.
    pub deadline_ns: u64,
    /// When the node should end.
    pub sub_deadline_ns: u64,
    /// The node's worst-case execution time.
    pub wcet_ns: u64,
    /// The CUDA stream of the lane; NULL where there is none.
    pub stream: *mut c_void,
}

/// A body did its work.
pub const RED_BODY_DONE: c_int = 0;
/// A body failed: its job is given up with the reason RED_SHED_FAULT. So is it for every number but RED_BODY_DONE.
pub const RED_BODY_FAILED: c_int = 1;
/// A C++ exception came out of a body. The trampoline of red.hpp returns it; it is counted apart.
pub const RED_BODY_THREW: c_int = 2;

/// What runs for a node, on a lane's thread: `user` is what came with it. It must return: not throw, not leave by longjmp, not
/// end its thread by pthread_exit. It may release jobs and stop the runtime; whatever would wait for a lane is
/// RED_STATUS_BUSY there.
pub type red_body = Option<extern "C" fn(user: *mut c_void, context: *const red_context) -> c_int>;

/// Which body runs for a node. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct red_callback {
    /// The node.
    pub node: u32,
    /// 0.
    pub reserved: u32,
    /// Its body.
    pub body: red_body,
    /// What the body is called with; may be NULL, and must be there as long as a job of the node may run.
    pub user: *mut c_void,
}
impl Empty for red_callback {
    const EMPTY: Self = Self { node: 0, reserved: 0, body: None, user: core::ptr::null_mut() };
}
// A null pointer is no body, any other is one that C vouches for.
crate::boundary::vouched!(red_callback);

/// Where a runtime is.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_runtime_state {
    /// It can be set up, and started.
    SetUp = 0,
    /// Its lanes run.
    Running = 1,
    /// Its lanes have ended.
    Ended = 2,
    /// red_runtime_start was refused; red_runtime_message says why. It can be closed.
    Failed = 3,
}

const _: () = {
    const fn plain<T: Plain>() {}
    plain::<red_callback>();
};
