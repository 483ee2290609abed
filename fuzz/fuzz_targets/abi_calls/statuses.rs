//! The errors of the core in the words of the header.

use red_core::*;
use red_ffi::red_status;

/// The status of an error of the core.
macro_rules! statuses {
    ($($name:ident($error:ident) { $($variant:ident => $status:ident),* $(,)? })*) => { $(
        pub(crate) fn $name(error: $error) -> red_status {
            match error {
                $($error::$variant => red_status::$status,)*
                other => panic!("an error that the header has not: {other:?}"),
            }
        }
    )* };
}

statuses! {
    node_error(NodeError) { Full => NodesFull, WorkOverflow => WorkOverflow }
    edge_error(EdgeError) {
        Cycle => Cycle, Duplicate => DuplicateEdge, SecondEncoder => SecondEncoder, UnknownNode => UnknownNode,
    }
    refine_error(RefineError) {
        UnknownNode => UnknownNode, NoDecoder => NoDecoder, Full => NodesFull, WorkOverflow => WorkOverflow,
    }
    task_error(AddTaskError) {
        Full => TasksFull, Empty => EmptyGraph, Deadline => Deadline, UnknownPool => UnknownPool,
        UnknownSensor => UnknownSensor, Memory => Memory, Unschedulable => Unschedulable,
    }
    commit_error(CommitError) {
        UnknownTask => UnknownTask, Conflict => Conflict, Busy => Draining, Empty => EmptyGraph,
        UnknownPool => UnknownPool, UnknownSensor => UnknownSensor, Memory => Memory,
        Unschedulable => Unschedulable,
    }
    pool_error(PoolError) { NoLane => NoLane, Full => PoolsFull }
    sensor_error(SensorError) { ZeroPeriod => ZeroPeriod, Full => SensorsFull }
    release_error(ReleaseError) { UnknownTask => UnknownTask, Full => JobsFull, Overflow => TimeOverflow }
    complete_error(CompleteError) { Stale => Stale, NotRunning => NotRunning, Late => Late }
}
