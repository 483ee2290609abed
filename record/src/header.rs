//! The beginning of a log: what was recorded, so that it can be set up again.

use red_core::Capacity;
use serde::{Deserialize, Serialize};

/// First bytes of every log.
pub(crate) const MAGIC: [u8; 6] = *b"REDLOG";
/// Version of the format that this crate writes, and the only one that it reads.
pub const FORMAT: u16 = 2;

/// A run is 146 years long at most, so that its end and a deadline later are times.
pub(crate) const LONGEST_RUN_NS: u64 = 1 << 62;

/// What was recorded.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// The program that wrote the log, with its version.
    pub program: String,
    /// Tasks, nodes, jobs, lanes, pools of the scheduler.
    pub capacities: [usize; 5],
    /// Policy by its name.
    pub policy: String,
    /// No release from then on.
    pub duration_ns: u64,
    /// Whether lanes had real-time rights.
    pub realtime: bool,
    /// Where the workload came from, for people.
    pub file: String,
    /// `toml` or `yaml`.
    pub format: String,
    /// The workload's text.
    pub workload: String,
}

impl Header {
    /// The capacities of `C` as a log has them.
    #[must_use]
    pub const fn capacities_of<C: Capacity>() -> [usize; 5] {
        [C::TASKS, C::NODES, C::JOBS, C::LANES, C::POOLS]
    }
}
