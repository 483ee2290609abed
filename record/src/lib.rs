//! Every input of a scheduler in a log, and the run again from it.
//!
//! The scheduler has no clock and no threads, so its inputs and their order are all there is to a run: fed again, they
//! give the same actions to the bit. A host that records makes its calls on a [`Recorder`] instead of the scheduler.
//!
//! ```text
//! Recorder -> Tape -> (chunks by mailbox) -> Writer -> file -> Reader -> replay
//! under the lock      off the real-time path
//! ```
//!
//! What set the scheduler up is in the header or in the entries. A host with a workload file puts its text into the
//! header, and its graph changes are entries with a number. A host that builds its graphs by calls makes those calls on
//! the [`Recorder`], too, and its header has the configuration ([`Header::by_calls`]): such a log needs nothing else
//! ([`replay_calls`]), only capacities that the program knows ([`class`]).
//!
//! The side under the lock writes words into memory that it owns: no system call, no allocation, no waiting, and in the
//! usual turn of a lane no atomic operation. If the other side does not keep up, the log ends there, and what came after
//! is counted; what is kept has no gaps.
#![forbid(unsafe_code)]

pub mod class;
mod entry;
mod error;
mod graph;
mod header;
mod reader;
mod recorder;
mod replay;
mod started;
mod tape;
mod totals;
mod words;
mod writer;

pub use entry::{Answer, Call, End, Entry};
pub use error::{LogError, StartError};
pub use header::{FORMAT, Header};
pub use reader::Reader;
pub use recorder::Recorder;
pub use replay::{Broken, Difference, Replay, replay, replay_calls, replay_calls_events, replay_events};
pub use started::{Members, Started};
pub use tape::Tape;
pub use totals::{Cut, Totals};
pub use writer::Writer;
