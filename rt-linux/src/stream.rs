//! What a lane gives its units to where they run by themselves: a stream of a GPU.

use crate::handler::{Failed, Work};
use crate::stream_seat::StreamSeat;
use red_core::UnitId;
use std::sync::Arc;

/// A queue that runs what it was given by itself, in its order. Its lane gives, looks, and sleeps meanwhile.
pub trait Stream {
    /// Gives it a unit, to start after what it was given before and after these units of other lanes. Returns before
    /// that. For bodies of the host's this is where they submit.
    fn submit(&mut self, work: &Work, after: &[UnitId]) -> Submitted;

    /// How far the oldest unit is that it was given and has not said [`Progress::Done`] of.
    fn look(&mut self) -> Progress;

    /// Has the seat's bell rung when that unit is done: before a lane sleeps that shares its CPU.
    ///
    /// # Errors
    /// It cannot: the lane looks again and again.
    fn call(&mut self, seat: &Arc<StreamSeat>) -> Result<(), Failed>;

    /// Nothing is given to it any more, because a unit does not come to its end: what it uses must be left to it.
    fn quarantine(&mut self) {}

    /// Whether what it runs on is gone, and nothing that is given to it ends well any more.
    fn is_lost(&mut self) -> bool {
        false
    }
}

/// What came of giving a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Submitted {
    /// It has it.
    Given,
    /// Not yet: a unit that it has to wait for was not given to its own stream so far. To be tried again.
    NotYet,
    /// It did not take it: the job is given up with the reason `fault`.
    Failed,
}

/// How far a unit is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// It waits for units of other lanes.
    Waits,
    /// It runs, as far as anybody knows.
    Runs,
    /// It ended.
    Done(Result<(), Failed>),
}
