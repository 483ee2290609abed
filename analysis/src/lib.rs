//! Proofs that every job of a set of tasks meets its deadline, whatever the offsets of sporadic releases and whatever the
//! execution times up to the WCET.
//!
//! They hold for the dispatcher of this project as it is configured by default: work-conserving in each cluster of lanes,
//! non-preemptive, ordered by latest start, no gates, and nothing that waits on purpose. [`prove`] searches, and writes what
//! it found into a certificate, which the package `red-certificate` checks without searching.
#![forbid(unsafe_code)]

mod divide;
mod interference;
mod member;
mod prove;
mod several;
mod shape;
mod single;
#[cfg(test)]
mod world;

pub use divide::divide;
pub use prove::prove;
