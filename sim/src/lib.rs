//! The RED scheduler in virtual time: the same core as on a robot, and time that jumps from event to event.
//!
//! Same workload and options, same result, to the byte.

mod execution;
mod host;
mod past;
mod report;
mod rows;
mod world;

pub use execution::Execution;
pub use host::{Options, SimError, simulate, simulate_in, simulate_past};
pub use past::Past;
pub use report::{PoolMetrics, Report, Row, Shed};
pub use world::{Drawn, World};

/// Capacities of the host: the limits of a workload file.
pub type Lab = red_core::Caps<16, 256, 64, 32, 32, 4, 4096>;
