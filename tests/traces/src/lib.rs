//! Random workloads in virtual time, each written down action by action. No allocation, no float: the same code
//! runs on a desk and on a microcontroller, and the text has to be the same, byte for byte.
//!
//! A workload takes one of the five policies, several pools, tasks with stages that share frames, edits of live
//! graphs, bodies that fail or overrun, lanes that report twice, a clock that steps back, and more load than there
//! are lanes. Releases go through a mailbox and all calls through the lock, so `red-sync` takes part.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod host;
mod rng;
pub mod workload;

pub use rng::Rng;

use core::fmt::{self, Write};

use red_core::{Caps, Config, DeadlineRule};

/// The capacities of every workload: 4 tasks of 32 nodes, 16 jobs, 8 lanes in 3 pools, and a record of events.
pub type Board = Caps<4, 32, 16, 8, 3, 1, 512>;

/// The policies, taken by turns, and their names.
pub const POLICIES: [(&str, Config); 5] = [
    ("edf", Config::EDF),
    ("red-fg", Config::RED_FG),
    ("red-ida", Config::RED_IDA),
    ("red", Config::RED),
    ("redrt", Config::REDRT),
];

/// Every deadline rule, in the order of the specification.
pub const RULES: [DeadlineRule; 6] = [
    DeadlineRule::EndToEnd,
    DeadlineRule::LevelSum,
    DeadlineRule::LevelGraham,
    DeadlineRule::PathProportional,
    DeadlineRule::LatestFinish,
    DeadlineRule::LatestStart,
];

/// In which order a host tells what happened in one instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Lanes by their number, as every host does.
    ByLane,
    /// The last lane first: a tie broken the other way, which a comparison of traces has to notice.
    LastLaneFirst,
}

/// Runs the workload of this seed and writes its trace.
///
/// # Errors
/// What `out` could not take.
///
/// ```
/// use red_traces::{Order, write_trace};
/// let (mut once, mut again) = (String::new(), String::new());
/// write_trace(7, Order::ByLane, &mut once)?;
/// write_trace(7, Order::ByLane, &mut again)?;
/// assert_eq!(once, again);
/// # Ok::<(), std::fmt::Error>(())
/// ```
pub fn write_trace(seed: u64, order: Order, out: &mut impl Write) -> fmt::Result {
    host::Host::new(seed, order).run(out)
}

/// Does what the command line asks: `COUNT [last-lane-first]` writes the traces of the first `COUNT` seeds.
///
/// # Errors
/// The arguments are others, or what `out` could not take.
pub fn run<'a>(arguments: impl Iterator<Item = &'a str>, out: &mut impl Write) -> fmt::Result {
    let mut arguments = arguments.fuse();
    let count: u64 = arguments.next().and_then(|word| word.parse().ok()).ok_or(fmt::Error)?;
    let order = match (arguments.next(), arguments.next()) {
        (None, _) => Order::ByLane,
        (Some("last-lane-first"), None) => Order::LastLaneFirst,
        _ => return Err(fmt::Error),
    };
    (0..count).try_for_each(|seed| write_trace(seed, order, out))
}

#[cfg(test)]
mod tests;
