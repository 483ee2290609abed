//! Every input of a scheduler in a log, and the run again from it.
//!
//! The scheduler has no clock and no threads, so its inputs and their order are all there is to a run: fed again, they
//! give the same actions to the bit. A host that records makes its calls on a [`Recorded`] instead of the scheduler.
//!
//! ```text
//! Recorded -> Tape -> (chunks by mailbox) -> Writer -> file -> Reader -> replay
//! under the lock      off the real-time path
//! ```
//!
//! The side under the lock writes words into memory that it owns: no system call, no allocation, no waiting, no atomic
//! operation but when a chunk is full. If the other side does not keep up, the log ends there, and what came after is
//! counted; what is kept has no gaps.
#![forbid(unsafe_code)]

mod entry;
mod error;
mod header;
mod reader;
mod recorded;
mod replay;
mod tape;
mod words;
mod writer;

pub use entry::{Answer, Call, Entry};
pub use error::LogError;
pub use header::{FORMAT, Header};
pub use reader::Reader;
pub use recorded::Recorded;
pub use replay::{Difference, Replay, replay};
pub use tape::Tape;
pub use writer::{Totals, Writer};
