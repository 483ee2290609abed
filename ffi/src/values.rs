//! What is none, handles, and when a task's jobs come.

use crate::boundary::{Growing, plain};

/// Version of the ABI that this header is of. A library of another one refuses every struct.
pub const RED_ABI_VERSION: u32 = 1;
/// In the place of a number: none.
pub const RED_NONE: u32 = u32::MAX;
/// In the place of a time, a budget or a capture: none; nothing to wait for; unlimited; the job's own.
pub const RED_NONE_64: u64 = u64::MAX;

/// A scheduler: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct red_scheduler {
    /// For the library.
    pub bits: u64,
}
plain!(red_scheduler { bits: u64 });

/// A graph: a place and a generation, no address. To be moved, not copied: of two copies one is left over.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct red_dag {
    /// For the library.
    pub bits: u64,
}
plain!(red_dag { bits: u64 });

/// When a task's jobs come and are due, and what they are worth.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_timing {
    /// RED_TIMING_INIT sets it.
    pub struct_size: u32,
    /// RED_TIMING_INIT sets it.
    pub abi_version: u32,
    /// End to end, relative to the release; 1 ns to 2^62 ns.
    pub deadline_ns: u64,
    /// Period, or minimum time between releases, for admission; 0: none declared.
    pub period_ns: u64,
    /// Rank under overload: a lower value costs none of a higher one its deadline, but for nodes that hold a lane; 1 is usual.
    pub value: u32,
    /// At least so many of any floor_of consecutive jobs are to be on time, before every value; 0 of 0: no floor.
    pub floor_keep: u32,
    /// See floor_keep; at least as many.
    pub floor_of: u32,
    /// 0.
    pub reserved: u32,
}
plain!(red_timing {
    struct_size: u32,
    abi_version: u32,
    deadline_ns: u64,
    period_ns: u64,
    value: u32,
    floor_keep: u32,
    floor_of: u32,
    reserved: u32,
});
impl Growing for red_timing {
    const LEAST: usize = 40;
}
