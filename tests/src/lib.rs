//! RED seen from outside: a slow reference scheduler, an independent judge of schedules, and random workloads.
//!
//! The oracle, the judge of schedules and the formulas are written from the specification alone and share no code with
//! the scheduler that they judge: where the two differ, one of them misread the specification. Beside them are hosts
//! that drive the scheduler for the tests and the fuzzers, and watch it: [`drive`] and [`model`] as a host should,
//! [`calls`] as nobody should.
//!
//! ```
//! use red_tests::oracle::{Policy, simulate};
//! use red_tests::rng::{Shape, random_workload};
//!
//! let workload = random_workload(7, &Shape::default());
//! let outcome = simulate(&workload, Policy::Redrt, 200_000_000);
//! red_tests::check::validate(&workload, Policy::Redrt, 200_000_000, &outcome.rows, &outcome.sheds).unwrap();
//! ```

pub mod calls;
pub mod check;
pub mod differential;
pub mod drive;
#[cfg(test)]
mod fixtures;
pub mod graph;
pub mod model;
pub mod oracle;
pub mod plan;
pub mod rng;
