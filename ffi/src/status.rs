#![allow(unsafe_code, reason = "names of C")]
//! One number for every way in which a call can end. Numbers are never used again.

use core::ffi::{CStr, c_char};
use red_core::{
    AddTaskError, CommitError, CompleteError, EdgeError, NodeError, PoolError, RefineError, ReleaseError,
    SensorError,
};

/// How a call ended. Nothing has changed unless it is RED_STATUS_OK, or the function says otherwise; but a time that a
/// scheduler was told counts all the same, and it never goes back.
#[repr(i32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_status {
    /// Done.
    Ok = 0,
    /// A pointer is NULL: give one.
    NullPointer = 1,
    /// An address is not aligned for its type: use alignas, or the alignment that the header says.
    Misaligned = 2,
    /// Memory or an array is too short: the header says the size, or the count that was written.
    TooShort = 3,
    /// Struct_size is not that of any version: begin with the INIT macro of the struct.
    StructSize = 4,
    /// Abi_version is another one: build against the header of the library that is loaded.
    Version = 5,
    /// A field that this library does not know, or a reserved one, is not zero: the header is newer than the library.
    UnknownField = 6,
    /// The handle was closed, or never opened.
    Closed = 7,
    /// The handle is of another copy of this library, or made up.
    Foreign = 8,
    /// The handle is of something else: a graph is no scheduler.
    OtherKind = 9,
    /// Graph and scheduler are of different capacity classes.
    OtherClass = 10,
    /// It is in use: another call goes on, or a body asked for what waits for a lane; call again later, from elsewhere.
    Busy = 11,
    /// The memory overlaps with that of something open, or has the place of the answer in it.
    Overlap = 12,
    /// A number is outside of its enumeration or range, which the header says beside its field.
    OutOfRange = 13,
    /// An array is longer than anything that could be meant.
    TooLong = 14,
    /// As many handles are open as there may be: close one.
    TooManyOpen = 15,
    /// A bug of this library: report it; what was called is closed.
    Internal = 16,
    /// The capacity class has no room for another node.
    NodesFull = 20,
    /// The sum of all costs would not fit 64 bits.
    WorkOverflow = 21,
    /// The edge would close a cycle.
    Cycle = 22,
    /// The edge is there already.
    DuplicateEdge = 23,
    /// A decoder reads the result of one encoder: make a node that fuses several an ordinary one.
    SecondEncoder = 24,
    /// No such node in this graph, or it was named twice.
    UnknownNode = 25,
    /// No such edge in this graph.
    UnknownEdge = 26,
    /// A stage needs at least one decoder.
    NoDecoder = 27,
    /// The capacity class has no room for another task.
    TasksFull = 40,
    /// The graph has no node.
    EmptyGraph = 41,
    /// A deadline is 1 ns to 2^62 ns.
    Deadline = 42,
    /// No such pool: add it first.
    UnknownPool = 43,
    /// A node, or an encoder and one of its decoders together, needs more memory than its pool has.
    Memory = 44,
    /// The certificate does not fit, and admission is enforced.
    Unschedulable = 45,
    /// No such task, or it was removed.
    UnknownTask = 46,
    /// Another commit came between, or the graph is no edit of this task: begin the edit again.
    Conflict = 47,
    /// The graph before the current one still has jobs: commit again when they have ended.
    Draining = 48,
    /// A pool needs at least one lane.
    NoLane = 49,
    /// The capacity class has no room for another pool, or for so many lanes.
    PoolsFull = 50,
    /// A period is at least 1 ns.
    ZeroPeriod = 51,
    /// The capacity class has no room for another sensor.
    SensorsFull = 52,
    /// No such sensor: add it first.
    UnknownSensor = 53,
    /// No such lane, or it is not as this call needs it.
    UnknownLane = 54,
    /// The configuration preempts, or opens graphs level by level: nothing can be dispatched ahead.
    NotAhead = 55,
    /// As many jobs are in flight as the capacity class has room for: count it as shed.
    JobsFull = 60,
    /// A time is too long, or a release or its deadline lies beyond 2^63 ns.
    TimeOverflow = 61,
    /// The unit was reported before.
    Stale = 62,
    /// No such unit was ever dispatched.
    NotRunning = 63,
    /// The unit's jobs had been given up meanwhile; it is counted, and its lane is free.
    Late = 64,
    /// No such job in flight.
    UnknownJob = 65,
    /// A real-time right is missing: red_runtime_message says which, and how to get it.
    NotPermitted = 80,
    /// The lanes do not get a CPU each: red_runtime_message says why, and what to do.
    Cpus = 81,
    /// The system refused something: red_runtime_message says what, and what to do.
    System = 82,
    /// A lane cannot interrupt a body: set preempt to 0.
    Preempts = 83,
    /// A node has no body: give one for each.
    NoBody = 84,
    /// A node that was there before keeps its body: give bodies for new nodes only.
    HasBody = 85,
    /// The runtime was started: this has to come before.
    Started = 86,
    /// The runtime was not started, or there is no log.
    Idle = 87,
    /// No lane came to the releases before: release less often.
    MailboxFull = 88,
    /// The runtime was stopped, or its time is over.
    Over = 89,
    /// The time has passed, and the runtime goes on.
    Timeout = 90,
    /// A child of fork has no lanes: open a runtime of its own.
    Forked = 91,
    /// A text is empty, not UTF-8, or not ended within 4,096 bytes.
    Text = 92,
    /// There is a log, or something was set up already: begin it before.
    LogLate = 93,
    /// The log cannot be written there: errno says why.
    LogFile = 94,
    /// The process has no memory left: nothing was done, free some and try again.
    NoMemory = 95,
    /// There is no CUDA driver, or no device that works: red_runtime_message says what is missing.
    Cuda = 96,
}

impl red_status {
    /// All of them.
    pub const ALL: &[Self] = &[
        Self::Ok,
        Self::NullPointer,
        Self::Misaligned,
        Self::TooShort,
        Self::StructSize,
        Self::Version,
        Self::UnknownField,
        Self::Closed,
        Self::Foreign,
        Self::OtherKind,
        Self::OtherClass,
        Self::Busy,
        Self::Overlap,
        Self::OutOfRange,
        Self::TooLong,
        Self::TooManyOpen,
        Self::Internal,
        Self::NodesFull,
        Self::WorkOverflow,
        Self::Cycle,
        Self::DuplicateEdge,
        Self::SecondEncoder,
        Self::UnknownNode,
        Self::UnknownEdge,
        Self::NoDecoder,
        Self::TasksFull,
        Self::EmptyGraph,
        Self::Deadline,
        Self::UnknownPool,
        Self::Memory,
        Self::Unschedulable,
        Self::UnknownTask,
        Self::Conflict,
        Self::Draining,
        Self::NoLane,
        Self::PoolsFull,
        Self::ZeroPeriod,
        Self::SensorsFull,
        Self::UnknownSensor,
        Self::UnknownLane,
        Self::NotAhead,
        Self::JobsFull,
        Self::TimeOverflow,
        Self::Stale,
        Self::NotRunning,
        Self::Late,
        Self::UnknownJob,
        Self::NotPermitted,
        Self::Cpus,
        Self::System,
        Self::Preempts,
        Self::NoBody,
        Self::HasBody,
        Self::Started,
        Self::Idle,
        Self::MailboxFull,
        Self::Over,
        Self::Timeout,
        Self::Forked,
        Self::Text,
        Self::LogLate,
        Self::LogFile,
        Self::NoMemory,
        Self::Cuda,
    ];

    /// In words, with what to do about it.
    #[must_use]
    pub const fn text(self) -> &'static CStr {
        match self {
            Self::Ok => c"done",
            Self::NullPointer => c"a pointer is NULL: give one",
            Self::Misaligned => c"an address is not aligned for its type: use alignas, or the alignment that the header says",
            Self::TooShort => c"memory or an array is too short: the header says the size, or the count that was written",
            Self::StructSize => c"struct_size is not that of any version: begin with the INIT macro of the struct",
            Self::Version => c"abi_version is another one: build against the header of the library that is loaded",
            Self::UnknownField => c"a field that this library does not know, or a reserved one, is not zero: the header is newer than the library",
            Self::Closed => c"the handle was closed, or never opened",
            Self::Foreign => c"the handle is of another copy of this library, or made up",
            Self::OtherKind => c"the handle is of something else: a graph is no scheduler",
            Self::OtherClass => c"graph and scheduler are of different capacity classes",
            Self::Busy => c"it is in use: another call goes on, or a body asked for what waits for a lane; call again later, from elsewhere",
            Self::Overlap => c"the memory overlaps with that of something open, or has the place of the answer in it",
            Self::OutOfRange => c"a number is outside of its enumeration or range, which the header says beside its field",
            Self::TooLong => c"an array is longer than anything that could be meant",
            Self::TooManyOpen => c"as many handles are open as there may be: close one",
            Self::Internal => c"a bug of this library: report it; what was called is closed",
            Self::NodesFull => c"the capacity class has no room for another node",
            Self::WorkOverflow => c"the sum of all costs would not fit 64 bits",
            Self::Cycle => c"the edge would close a cycle",
            Self::DuplicateEdge => c"the edge is there already",
            Self::SecondEncoder => c"a decoder reads the result of one encoder: make a node that fuses several an ordinary one",
            Self::UnknownNode => c"no such node in this graph, or it was named twice",
            Self::UnknownEdge => c"no such edge in this graph",
            Self::NoDecoder => c"a stage needs at least one decoder",
            Self::TasksFull => c"the capacity class has no room for another task",
            Self::EmptyGraph => c"the graph has no node",
            Self::Deadline => c"a deadline is 1 ns to 2^62 ns",
            Self::UnknownPool => c"no such pool: add it first",
            Self::Memory => c"a node, or an encoder and one of its decoders together, needs more memory than its pool has",
            Self::Unschedulable => c"the certificate does not fit, and admission is enforced",
            Self::UnknownTask => c"no such task, or it was removed",
            Self::Conflict => c"another commit came between, or the graph is no edit of this task: begin the edit again",
            Self::Draining => c"the graph before the current one still has jobs: commit again when they have ended",
            Self::NoLane => c"a pool needs at least one lane",
            Self::PoolsFull => c"the capacity class has no room for another pool, or for so many lanes",
            Self::ZeroPeriod => c"a period is at least 1 ns",
            Self::SensorsFull => c"the capacity class has no room for another sensor",
            Self::UnknownSensor => c"no such sensor: add it first",
            Self::UnknownLane => c"no such lane, or it is not as this call needs it",
            Self::NotAhead => c"the configuration preempts, or opens graphs level by level: nothing can be dispatched ahead",
            Self::JobsFull => c"as many jobs are in flight as the capacity class has room for: count it as shed",
            Self::TimeOverflow => c"a time is too long, or a release or its deadline lies beyond 2^63 ns",
            Self::Stale => c"the unit was reported before",
            Self::NotRunning => c"no such unit was ever dispatched",
            Self::Late => c"the unit's jobs had been given up meanwhile; it is counted, and its lane is free",
            Self::UnknownJob => c"no such job in flight",
            Self::NotPermitted => c"a real-time right is missing: red_runtime_message says which, and how to get it",
            Self::Cpus => c"the lanes do not get a CPU each: red_runtime_message says why, and what to do",
            Self::System => c"the system refused something: red_runtime_message says what, and what to do",
            Self::Preempts => c"a lane cannot interrupt a body: set preempt to 0",
            Self::NoBody => c"a node has no body: give one for each",
            Self::HasBody => c"a node that was there before keeps its body: give bodies for new nodes only",
            Self::Started => c"the runtime was started: this has to come before",
            Self::Idle => c"the runtime was not started, or there is no log",
            Self::MailboxFull => c"no lane came to the releases before: release less often",
            Self::Over => c"the runtime was stopped, or its time is over",
            Self::Timeout => c"the time has passed, and the runtime goes on",
            Self::Forked => c"a child of fork has no lanes: open a runtime of its own",
            Self::Text => c"a text is empty, not UTF-8, or not ended within 4,096 bytes",
            Self::LogLate => c"there is a log, or something was set up already: begin it before",
            Self::LogFile => c"the log cannot be written there: errno says why",
            Self::NoMemory => c"the process has no memory left: nothing was done, free some and try again",
            Self::Cuda => c"there is no CUDA driver, or no device that works: red_runtime_message says what is missing",
        }
    }
}

/// A status in words, with what to do about it; of a number that is none, that it is none. The text is constant.
///
/// Threads: any, at once. Real time: yes. Time: O(1). Errors: none.
#[unsafe(no_mangle)]
pub extern "C" fn red_status_text(status: i32) -> *const c_char {
    let known = red_status::ALL.iter().find(|known| **known as i32 == status);
    known.map_or(c"no status of this library", |known| known.text()).as_ptr()
}

/// Errors of the core, each with its number.
macro_rules! same {
    ($($error:ident { $($variant:ident => $status:ident),* $(,)? })*) => { $(
        impl From<$error> for red_status {
            fn from(error: $error) -> Self {
                match error {
                    $($error::$variant => Self::$status,)*
                    _ => Self::Internal,
                }
            }
        }
    )* };
}

same! {
    NodeError { Full => NodesFull, WorkOverflow => WorkOverflow }
    EdgeError {
        Cycle => Cycle, Duplicate => DuplicateEdge, SecondEncoder => SecondEncoder, UnknownNode => UnknownNode,
    }
    RefineError {
        UnknownNode => UnknownNode, NoDecoder => NoDecoder, Full => NodesFull, WorkOverflow => WorkOverflow,
    }
    AddTaskError {
        Full => TasksFull, Empty => EmptyGraph, Deadline => Deadline, UnknownPool => UnknownPool,
        UnknownSensor => UnknownSensor, Memory => Memory, Unschedulable => Unschedulable,
    }
    CommitError {
        UnknownTask => UnknownTask, Conflict => Conflict, Busy => Draining, Empty => EmptyGraph,
        UnknownPool => UnknownPool, UnknownSensor => UnknownSensor, Memory => Memory,
        Unschedulable => Unschedulable,
    }
    PoolError { NoLane => NoLane, Full => PoolsFull }
    SensorError { ZeroPeriod => ZeroPeriod, Full => SensorsFull }
    ReleaseError { UnknownTask => UnknownTask, Full => JobsFull, Overflow => TimeOverflow }
    CompleteError { Stale => Stale, NotRunning => NotRunning, Late => Late }
}

/// The number of what was answered.
#[inline(always)]
pub(crate) fn status<T, E: Into<red_status>>(answer: Result<T, E>, done: impl FnOnce(T)) -> red_status {
    match answer {
        Ok(value) => {
            done(value);
            red_status::Ok
        }
        Err(error) => error.into(),
    }
}

/// The number where there is nothing but that.
#[inline(always)]
pub(crate) fn flat(answer: Result<red_status, red_status>) -> red_status {
    match answer {
        Ok(status) | Err(status) => status,
    }
}

// Of texts, which the interpreter is slow to compare.
#[cfg(all(test, not(miri)))]
mod tests;
