//! The RED executive: a scheduler of DAGs of neural networks as a plain state machine.
//!
//! No allocation, no floats, no clock, no threads: the host brings time and lanes. Every capacity is in the type
//! ([`Caps`]), every public call returns a typed error and changes nothing when it fails.
//!
//! The loop of every host:
//!
//! 1. something happened: tell it ([`Scheduler::release`], [`Scheduler::complete`], [`Scheduler::fail`],
//!    [`Scheduler::commit`]), all events of one instant before the next step;
//! 2. ask [`Scheduler::poll`];
//! 3. carry the [`Action`] out;
//! 4. ask again until `None`;
//! 5. sleep until [`Scheduler::poll_at`] or until something happens;
//! 6. go to 1.
//!
//! Modules in layers, each of which uses its own and those before it: words (`time`, `id`, `capacity`, `fmt`,
//! `error`); `graph`; `deadlines` and `analysis`; `ready_queue`; `policy` and `config`; `scheduler`.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

mod analysis;
mod capacity;
mod config;
mod deadlines;
mod error;
mod fmt;
mod graph;
mod id;
mod policy;
mod ready_queue;
mod scheduler;
mod time;

pub use analysis::*;
pub use capacity::{Capacity, Caps, Empty, Item, Store, Table};
pub use config::{Admission, BestCase, Config, Gate, Late, Reassign, Shed};
pub use deadlines::*;
pub use graph::*;
pub use id::{JobId, LaneId, NodeId, PoolId, SensorId, TaskId, UnitId};
pub use policy::*;
pub use ready_queue::ReadyQueue;
pub use scheduler::Scheduler;
pub use scheduler::action::{Action, Dispatch, Outcome, ShedReason};
pub use scheduler::complete::CompleteError;
pub use scheduler::edit::CommitError;
pub use scheduler::event::{Event, EventKind};
pub use scheduler::pools::{PoolError, SensorError};
pub use scheduler::release::ReleaseError;
pub use scheduler::status::Counters;
pub use scheduler::tasks::{AddTaskError, Timing};
pub use scheduler::units::{Member, Unit};
pub use scheduler::warning::Warning;
pub use time::{Bytes, Contention, CostEstimate, Duration, Instant, Ppm, SignedDuration, Wcet};
