//! Early warning: a deadline that will be missed.

use crate::boundary::plain;
use crate::values::{RED_NONE, RED_NONE_64};
use red_core::{Instant, Warning};

/// A predicted deadline miss. This struct does not grow.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct red_warning {
    /// The job. It is given up already where its outcome says so.
    pub job: u32,
    /// Its task.
    pub task: u32,
    /// The index of the job in its task, from 0.
    pub index: u64,
    /// When it is due.
    pub deadline_ns: u64,
    /// When that was known.
    pub at_ns: u64,
    /// How long after its deadline it would end, by the estimates of then, in whole microseconds rounded up. 0: it would not be late, but goes so that the
    /// other job is in time.
    pub by_ns: u64,
    /// The index of the job that takes the lanes it needs, in because_task; RED_NONE_64: it is late on its own.
    pub because_index: u64,
    /// Whose job takes the lanes it needs; RED_NONE: nobody's.
    pub because_task: u32,
    /// 0.
    pub reserved: u32,
}
plain!(red_warning {
    job: u32,
    task: u32,
    index: u64,
    deadline_ns: u64,
    at_ns: u64,
    by_ns: u64,
    because_index: u64,
    because_task: u32,
    reserved: u32,
});

impl red_warning {
    /// What was known at `at`.
    pub(crate) fn of(warning: &Warning, at: Instant) -> Self {
        let (task, index) =
            warning.because.map_or((RED_NONE, RED_NONE_64), |(task, index)| (task.to_bits(), index));
        Self {
            job: warning.job.to_bits(),
            task: warning.task.to_bits(),
            index: warning.index,
            deadline_ns: warning.deadline.as_nanos(),
            at_ns: at.as_nanos(),
            by_ns: warning.by.as_nanos(),
            because_index: index,
            because_task: task,
            reserved: 0,
        }
    }
}
