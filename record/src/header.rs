//! The beginning of a log: what was recorded, so that it can be set up again.

mod config;

use red_core::{Capacity, Config};
use serde::{Deserialize, Serialize};

/// First bytes of every log.
pub(crate) const MAGIC: [u8; 6] = *b"REDLOG";
/// Version of the format that this crate writes, and the only one that it reads.
pub const FORMAT: u16 = 5;

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
    /// No release from then on; 0 where nobody knew beforehand.
    pub duration_ns: u64,
    /// Whether lanes had real-time rights.
    pub realtime: bool,
    /// Where the workload came from, for people.
    pub file: String,
    /// `toml` or `yaml`.
    pub format: String,
    /// The workload's text.
    pub workload: String,
    /// Which kind of log it is: `None`, and the workload says what is set up; else the log needs none: this is what
    /// the scheduler was configured with, and pools, sensors, tasks and graphs are entries.
    #[serde(default, with = "config", skip_serializing_if = "Option::is_none")]
    pub config: Option<Config>,
}

impl Header {
    /// Of a log that needs no workload: the scheduler has just been configured with `config`, and whatever follows is
    /// recorded. `policy` is for people.
    #[must_use]
    pub fn by_calls<C: Capacity>(program: &str, policy: &str, config: Config) -> Self {
        Self {
            program: program.to_owned(),
            capacities: Self::capacities_of::<C>(),
            policy: policy.to_owned(),
            duration_ns: 0,
            realtime: false,
            file: String::new(),
            format: String::new(),
            workload: String::new(),
            config: Some(config),
        }
    }

    /// The capacities of `C` as a log has them.
    #[must_use]
    pub const fn capacities_of<C: Capacity>() -> [usize; 5] {
        [C::TASKS, C::NODES, C::JOBS, C::LANES, C::POOLS]
    }
}
