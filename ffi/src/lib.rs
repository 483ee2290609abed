//! The scheduler and the Linux runtime as a C ABI: `include/red.h` is made from these files.
//!
//! | file | what |
//! |---|---|
//! | `status` | one number for every way in which a call can end |
//! | `boundary` | pointers from C, looked at before they are used |
//! | `handles`, `name`, `guard` | what is open: a handle is a place and a generation, never an address; one call at a time |
//! | `capacity` | the three classes of schedulers and graphs, and their sizes |
//! | `values`, `config`, `node`, `action`, `event`, `warning`, `proof` | structs and enumerations of the header |
//! | `dag`, `dag_look` | graphs |
//! | `scheduler`, `tasks`, `job`, `look` | the scheduler: open, tasks, the loop, what a host may ask |
//! | `machine`, `graph` | a scheduler, a graph of any class |
//! | `runtime`, `log`, `room` | lanes as threads of ours, logs, memory that the system gives; not part of the core's library |
//!
//! An entry converts what came in, makes one call, and converts what goes out. Outputs are looked at before the call
//! and written after it, only when it succeeds.
#![cfg_attr(not(feature = "runtime"), no_std)]
#![allow(non_camel_case_types, reason = "the names of C")]
#![allow(clippy::missing_safety_doc, reason = "what C has to keep is in docs/c-abi.md, once for all")]

mod action;
mod boundary;
mod capacity;
mod config;
mod dag;
mod dag_look;
mod event;
mod graph;
mod guard;
mod handles;
mod job;
#[cfg(feature = "runtime")]
mod log;
mod look;
mod machine;
mod name;
#[cfg(not(feature = "runtime"))]
mod no_log;
#[cfg(not(feature = "runtime"))]
mod no_runtime;
mod node;
#[cfg(not(any(feature = "runtime", test)))]
mod panic;
mod proof;
#[cfg(feature = "runtime")]
mod room;
#[cfg(feature = "runtime")]
mod runtime;
mod scheduler;
mod status;
mod tasks;
#[cfg(test)]
mod tests;
mod values;
mod warning;

#[cfg(not(feature = "runtime"))]
use {no_log as log, no_runtime as runtime};

pub use action::*;
pub use capacity::*;
pub use config::*;
pub use dag::*;
pub use dag_look::*;
pub use event::*;
pub use job::*;
#[cfg(feature = "runtime")]
pub use log::*;
pub use look::*;
pub use node::*;
pub use proof::*;
#[cfg(feature = "runtime")]
pub use runtime::*;
pub use scheduler::*;
pub use status::*;
pub use tasks::*;
pub use values::*;
pub use warning::*;
