//! The call from a lane into a body.

use crate::BodyError;

/// One call of a body: which job it works for, and that job's times.
///
/// *Units.* Nanoseconds of `CLOCK_MONOTONIC`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Call {
    /// When the lane started the body.
    pub now_ns: u64,
    /// When the job was released.
    pub release_ns: u64,
    /// When the job is due.
    pub deadline_ns: u64,
    /// Job of the task, counted from 0.
    pub job: u64,
    /// Task, in the order of the workload file.
    pub task: u32,
    /// Lane on which the body runs, counted over all pools.
    pub lane: u32,
}

/// What one lane executes for one node.
pub trait Body: Send {
    /// Executes the node once, to the end, on the calling thread.
    ///
    /// Nothing of ours allocates, locks or waits in here. An inference engine allocates its intermediate tensors
    /// (see [`crate::onnx`]), and a plugin does what its author wrote.
    ///
    /// # Errors
    /// The body failed for this job. The next call is a fresh attempt.
    fn run(&mut self, call: &Call) -> Result<(), BodyError>;
}
