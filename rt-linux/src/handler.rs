//! What a lane runs for a node.

use crate::stream::Stream;
use red_core::{LaneId, NodeId, PoolId, TaskId, Unit, UnitId};

/// One execution: which node of which job, and by when.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// The unit that it is.
    pub unit: UnitId,
    /// The task: its place, and which of those that had it.
    pub task: TaskId,
    /// The node.
    pub node: NodeId,
    /// The pool of its lane.
    pub pool: PoolId,
    /// The how-manieth job of its task, from 0; up to 2^48, as units are.
    pub job: u64,
    /// The job's release, in nanoseconds since the start of the run.
    pub release_ns: u64,
    /// When the job is due.
    pub deadline_ns: u64,
    /// When the unit became dispatchable.
    pub since_ns: u64,
    /// When the node should have ended.
    pub sub_deadline_ns: u64,
    /// The node's worst-case execution time.
    pub wcet_ns: u64,
    /// Number of the encoder result that the node writes or reads.
    pub output: Option<u16>,
}

impl Work {
    pub(crate) fn of(name: UnitId, unit: &Unit, since_ns: u64) -> Self {
        Self {
            unit: name,
            task: unit.first.task,
            node: unit.first.node,
            pool: unit.pool,
            job: unit.first.index,
            release_ns: unit.first.release.as_nanos(),
            deadline_ns: unit.first.deadline.as_nanos(),
            since_ns,
            sub_deadline_ns: unit.first.sub_deadline.as_nanos(),
            wcet_ns: unit.wcet.as_nanos(),
            output: unit.output,
        }
    }

    /// Where it runs, counted over all pools.
    #[must_use]
    pub const fn lane(&self) -> LaneId {
        self.unit.lane()
    }
}

/// A body failed; its job is given up with the reason `fault`. What went wrong is the handler's to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed;

/// The bodies of all nodes, as one lane runs them. Every lane has a handler of its own.
pub trait Handler: Send {
    /// Runs a node's body. A panic fails the job as well, and leaves the lane running.
    ///
    /// # Errors
    /// [`Failed`].
    fn run(&mut self, work: &Work) -> Result<(), Failed>;

    /// The stream that its units are given to; then [`Handler::run`] is not called. Of a lane that
    /// [`Setup::streams`](crate::runtime::Setup::streams) names.
    fn stream(&mut self) -> Option<&mut dyn Stream> {
        None
    }

    /// Called once on the lane's thread before real time starts: warm-up.
    fn prepare(&mut self) {}

    /// Called once on the lane's thread when the run starts, after [`Handler::prepare`]. The times of [`Work`] count
    /// from `origin_ns`, nanoseconds of `CLOCK_MONOTONIC`.
    fn begin(&mut self, origin_ns: u64) {
        let _unused = origin_ns;
    }
}
