//! Counters, samples and events.

use crate::boundary::{Growing, plain};

/// What happened so far, and what is now.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_figures {
    /// RED_FIGURES_INIT sets it.
    pub struct_size: u32,
    /// RED_FIGURES_INIT sets it.
    pub abi_version: u32,
    /// Units dispatched.
    pub units: u64,
    /// Encoder sub-jobs that completed without executing.
    pub encoder_runs_saved: u64,
    /// Executions beyond the WCET, where the configuration takes samples of executions.
    pub overruns: u64,
    /// Calls whose now_ns was before an earlier one; the latest time was kept.
    pub clock_steps_back: u64,
    /// Completions of units whose jobs had been given up.
    pub late_completions: u64,
    /// Results thrown away for memory; their encoders run again.
    pub evictions: u64,
    /// Events that found no room; exact.
    pub events_dropped: u64,
    /// Lanes over all pools, retired ones too.
    pub lanes: u32,
    /// Jobs in flight.
    pub jobs_in_flight: u32,
    /// Sub-jobs that are ready and wait for a lane.
    pub ready: u32,
    /// Units that run.
    pub running: u32,
    /// 1: a pool has both a free lane and a sub-job that could start there, so red_scheduler_poll is to be called.
    pub can_dispatch: u32,
    /// 0.
    pub reserved: u32,
}
plain!(red_figures {
    struct_size: u32,
    abi_version: u32,
    units: u64,
    encoder_runs_saved: u64,
    overruns: u64,
    clock_steps_back: u64,
    late_completions: u64,
    evictions: u64,
    events_dropped: u64,
    lanes: u32,
    jobs_in_flight: u32,
    ready: u32,
    running: u32,
    can_dispatch: u32,
    reserved: u32,
});
impl Growing for red_figures {
    const LEAST: usize = 88;
}

/// What the executions of a node took, of its last 8.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_executions {
    /// RED_EXECUTIONS_INIT sets it.
    pub struct_size: u32,
    /// RED_EXECUTIONS_INIT sets it.
    pub abi_version: u32,
    /// Mean, or RED_NONE_64 before the first.
    pub mean_ns: u64,
    /// Shortest, or RED_NONE_64 before the first.
    pub minimum_ns: u64,
    /// Longest, or RED_NONE_64 before the first.
    pub maximum_ns: u64,
}
plain!(red_executions { struct_size: u32, abi_version: u32, mean_ns: u64, minimum_ns: u64, maximum_ns: u64 });
impl Growing for red_executions {
    const LEAST: usize = 32;
}

/// What happened.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_event_kind {
    /// A kind that this header has no word for.
    Other = 0,
    /// A job was released.
    Released = 1,
    /// A release found no place.
    Refused = 2,
    /// A sub-job started; each member of a unit has its own event.
    Started = 3,
    /// A sub-job that ran completed.
    Completed = 4,
    /// An encoder completed without executing: its result was there.
    Hit = 5,
    /// A sub-job lost its lane to a smaller key.
    Preempted = 6,
    /// A sub-job took longer than its WCET.
    Overran = 7,
    /// All nodes of a job completed.
    Ended = 8,
    /// A job was given up.
    Shed = 9,
    /// A task has a new graph.
    Edited = 10,
    /// A kept result was thrown away for memory.
    Evicted = 11,
    /// A job will miss its deadline, as far as is known: a red_warning says by how much and because of whom.
    Warned = 12,
}

/// One event. Fields that do not apply are 0. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_event {
    /// When.
    pub at_ns: u64,
    /// The how-manieth job of its task, from 0.
    pub job: u64,
    /// One of red_event_kind.
    pub kind: u32,
    /// Of RED_EVENT_KIND_SHED: one of red_shed.
    pub shed: u32,
    /// Whose.
    pub task: u32,
    /// Which node.
    pub node: u32,
    /// Which lane.
    pub lane: u32,
    /// 0.
    pub reserved: u32,
}
plain!(red_event {
    at_ns: u64,
    job: u64,
    kind: u32,
    shed: u32,
    task: u32,
    node: u32,
    lane: u32,
    reserved: u32,
});

impl From<&red_core::Event> for red_event {
    fn from(event: &red_core::Event) -> Self {
        use red_core::EventKind;
        let (kind, shed) = match event.kind {
            EventKind::Released => (red_event_kind::Released, 0),
            EventKind::Refused => (red_event_kind::Refused, 0),
            EventKind::Started => (red_event_kind::Started, 0),
            EventKind::Completed => (red_event_kind::Completed, 0),
            EventKind::Hit => (red_event_kind::Hit, 0),
            EventKind::Preempted => (red_event_kind::Preempted, 0),
            EventKind::Overran => (red_event_kind::Overran, 0),
            EventKind::Ended => (red_event_kind::Ended, 0),
            EventKind::Shed(reason) => (red_event_kind::Shed, reason as u32),
            EventKind::Edited => (red_event_kind::Edited, 0),
            EventKind::Evicted => (red_event_kind::Evicted, 0),
            EventKind::Warned => (red_event_kind::Warned, 0),
            _ => (red_event_kind::Other, 0),
        };
        Self {
            at_ns: event.at.as_nanos(),
            job: event.job,
            kind: kind as u32,
            shed,
            task: event.task.to_bits(),
            node: event.node.index() as u32,
            lane: event.lane.index() as u32,
            reserved: 0,
        }
    }
}
