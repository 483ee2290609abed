//! Workload files of `redrt`: from bytes on a disk to a checked [`model::Workload`].
//!
//! [`load`] reads a file and [`parse`] reads text. Both formats become one tree of values with their places in
//! the text; one reader turns the tree into the model, so TOML and YAML have the same keys, the same checks and
//! the same messages:
//!
//! ```text
//! bytes -> text -> tree -> read -> graph -> model::Workload
//!                    (each step refuses with a place)
//! ```
//!
//! A file that this crate accepts is valid for every policy: names resolve, graphs are acyclic before and after
//! each event, whether refined or not, and no sum over a task overflows.

pub mod build;
mod change;
mod error;
mod file;
#[cfg(test)]
mod fixtures;
mod graph;
pub mod metrics;
pub mod model;
pub mod plan;
pub mod policy;
mod read;
mod text;
mod tree;
pub mod units;

pub use error::{LoadError, Nearest, Place, Refusal, shown, shown_path};
pub use file::{Format, MAX_FILE_BYTES, Source, load, parse};
