//! What a poll answers, and what a unit is.

use crate::boundary::{Growing, Out, plain};
use crate::values::RED_NONE;

/// Why a job was given up.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_shed {
    /// It was not: all its nodes completed.
    Not = 0,
    /// Not even its best case could end by the deadline.
    Hopeless = 1,
    /// Another job would have been late beside it.
    Overload = 2,
    /// Lasting overload under the paper's rule; it had the lowest urgency.
    Urgency = 3,
    /// No place for another job: at its own release, or at that of a job of a higher rank.
    Full = 4,
    /// It was past its deadline, and the late policy is to abort.
    Late = 5,
    /// One of its nodes failed.
    Fault = 6,
    /// Its task was removed.
    Removed = 7,
}

/// How a job ended. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_outcome {
    /// The job; its place may be used again from now on.
    pub job: u32,
    /// Its task.
    pub task: u32,
    /// The how-manieth job of its task, from 0.
    pub index: u64,
    /// When it was released.
    pub release_ns: u64,
    /// When it was due.
    pub deadline_ns: u64,
    /// When it ended.
    pub at_ns: u64,
    /// One of red_shed.
    pub shed: u32,
    /// 0.
    pub reserved: u32,
}
plain!(red_outcome {
    job: u32,
    task: u32,
    index: u64,
    release_ns: u64,
    deadline_ns: u64,
    at_ns: u64,
    shed: u32,
    reserved: u32,
});

impl From<red_core::Outcome> for red_outcome {
    #[inline]
    fn from(outcome: red_core::Outcome) -> Self {
        Self {
            job: outcome.job.to_bits(),
            task: outcome.task.to_bits(),
            index: outcome.index,
            release_ns: outcome.release.as_nanos(),
            deadline_ns: outcome.deadline.as_nanos(),
            at_ns: outcome.at.as_nanos(),
            shed: outcome.shed.map_or(0, |reason| reason as u32),
            reserved: 0,
        }
    }
}

/// What the host has to do.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum red_action_kind {
    /// Nothing, until something happens or the time of red_scheduler_poll_at comes.
    Nothing = 0,
    /// Start the unit on its lane, and report it with red_scheduler_complete or red_scheduler_fail.
    Dispatch = 1,
    /// Take the lane from this unit, which goes on later as another unit. Only if the configuration preempts.
    Preempt = 2,
    /// A job ended. A lane that still runs one of its units must report it all the same.
    Ended = 3,
    /// Give the unit to its lane, to start after what that runs and after the units of red_scheduler_waits_for; report it
    /// as any other. Only in pools of red_scheduler_dispatch_ahead.
    Ahead = 4,
}

/// One answer of a poll. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_action {
    /// One of red_action_kind.
    pub kind: u32,
    /// Of a unit: its lane, counted over all pools in their order.
    pub lane: u32,
    /// Of a unit: its handle, used once. Bits 8 to 15 are the node of its first member.
    pub unit: u64,
    /// Of a job that ended. Else it is not written.
    pub outcome: red_outcome,
}
plain!(red_action { kind: u32, lane: u32, unit: u64, outcome: red_outcome });

/// What an action begins with.
#[repr(C)]
#[derive(Clone, Copy)]
pub(crate) struct red_action_head {
    pub(crate) kind: u32,
    pub(crate) lane: u32,
    pub(crate) unit: u64,
}
plain!(red_action_head { kind: u32, lane: u32, unit: u64 });

impl Out<red_action> {
    /// Where it begins.
    pub(crate) const fn head(self) -> Out<red_action_head> {
        const { assert!(core::mem::offset_of!(red_action, outcome) == size_of::<red_action_head>(), "the same") };
        self.cast()
    }
}

/// One sub-job of a unit. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_member {
    /// The job.
    pub job: u32,
    /// Its task.
    pub task: u32,
    /// The node.
    pub node: u32,
    /// 0.
    pub reserved: u32,
    /// The how-manieth job of its task, from 0.
    pub index: u64,
    /// When the job was released.
    pub release_ns: u64,
    /// When the job is due.
    pub deadline_ns: u64,
    /// When the node should end.
    pub sub_deadline_ns: u64,
}
plain!(red_member {
    job: u32,
    task: u32,
    node: u32,
    reserved: u32,
    index: u64,
    release_ns: u64,
    deadline_ns: u64,
    sub_deadline_ns: u64,
});

impl From<red_core::Member> for red_member {
    fn from(member: red_core::Member) -> Self {
        Self {
            job: member.job.to_bits(),
            task: member.task.to_bits(),
            node: member.node.index() as u32,
            reserved: 0,
            index: member.index,
            release_ns: member.release.as_nanos(),
            deadline_ns: member.deadline.as_nanos(),
            sub_deadline_ns: member.sub_deadline.as_nanos(),
        }
    }
}

/// What a unit is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_unit {
    /// RED_UNIT_INIT sets it.
    pub struct_size: u32,
    /// RED_UNIT_INIT sets it.
    pub abi_version: u32,
    /// Its first member: the one whose body runs.
    pub first: red_member,
    /// Where it runs.
    pub lane: u32,
    /// The lane's pool.
    pub pool: u32,
    /// Number of the encoder result that it writes or reads, or RED_NONE. One number stays the same result until
    /// nobody in flight needs it.
    pub output: u32,
    /// 0.
    pub reserved: u32,
    /// When it started.
    pub started_ns: u64,
    /// The worst-case execution time of the first member's node.
    pub wcet_ns: u64,
}
plain!(red_unit {
    struct_size: u32,
    abi_version: u32,
    first: red_member,
    lane: u32,
    pool: u32,
    output: u32,
    reserved: u32,
    started_ns: u64,
    wcet_ns: u64,
});
impl Growing for red_unit {
    const LEAST: usize = 88;
}

impl From<red_core::Unit> for red_unit {
    fn from(unit: red_core::Unit) -> Self {
        Self {
            struct_size: 0,
            abi_version: 0,
            first: unit.first.into(),
            lane: unit.lane.index() as u32,
            pool: unit.pool.index() as u32,
            output: unit.output.map_or(RED_NONE, u32::from),
            reserved: 0,
            started_ns: unit.started.as_nanos(),
            wcet_ns: unit.wcet.as_nanos(),
        }
    }
}
