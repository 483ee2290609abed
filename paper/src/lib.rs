//! The experiments of the RED paper as data, and what becomes of its claims.
//!
//! Each experiment is a module with one function, from a [`Run`] to a [`Table`](table::Table): the paper's values, ours with their
//! confidence intervals, and the verdicts. Equal seeds give equal tables, whatever the number of CPUs.
#![forbid(unsafe_code)]

mod experiments;
pub mod markdown;
pub mod platform;
mod rng;
mod run;
pub mod scenario;
mod scoreboard;
pub mod stat;
pub mod table;
pub mod trial;

pub use experiments::{EXPERIMENTS, Experiment, Group};
pub use run::{PaperError, Run};

/// Seeds that intervals of confidence are made of, unless told.
pub const SEEDS: u64 = 20;
