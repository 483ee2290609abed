//! RED seen from outside: a slow reference scheduler, an independent judge of schedules, and random workloads.
//!
//! Everything here is written from the specification alone and shares no code with the scheduler that it
//! judges: where the two differ, one of them misread the specification.
//!
//! ```
//! use red_tests::oracle::{Policy, simulate};
//! use red_tests::rng::{Shape, random_workload};
//!
//! let workload = random_workload(7, &Shape::default());
//! let outcome = simulate(&workload, Policy::Redrt, 200_000_000);
//! red_tests::check::validate(&workload, Policy::Redrt, 200_000_000, &outcome.rows, &outcome.sheds).unwrap();
//! ```

pub mod check;
#[cfg(test)]
mod fixtures;
pub mod graph;
pub mod oracle;
pub mod plan;
pub mod rng;
