//! The runtime: lanes as threads of ours, which call back.
//!
//! | file | what |
//! |---|---|
//! | `values`, `report`, `task_report` | structs and enumerations of the header |
//! | `bodies` | which function runs for which node, and the call |
//! | `notes` | jobs that ended and events, until somebody takes them |
//! | `engine` | a runtime: being set up, running, ended |
//! | `lanes` | its lanes, and a stop that comes before they do |
//! | `called` | the runtime of a handle, as long as calls on it last |
//! | `open`, `set_up`, `tasks`, `run` | the functions of the header |
//! | `fork` | a child of `fork` has none of our threads |

mod bodies;
mod called;
mod engine;
pub(crate) mod fork;
mod lanes;
mod notes;
mod on_device;
mod open;
mod prepared;
mod report;
mod run;
mod set_up;
mod task_report;
mod tasks;
#[cfg(test)]
mod tests;
pub(crate) mod text;
mod values;

pub(crate) use engine::Engine;
pub use open::*;
pub use report::*;
pub use run::*;
pub use set_up::*;
pub use task_report::red_task_report;
pub use tasks::*;
pub use values::*;

/// Counts what lanes allocate outside of bodies, for red_report.
#[cfg(feature = "counts")]
#[global_allocator]
static ALLOCATOR: red_rt::allocations::CountingAllocator = red_rt::allocations::CountingAllocator;
