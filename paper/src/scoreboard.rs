//! Policies beside each other, on workloads that are not the paper's.

pub(crate) mod acceptance;
mod bound;
mod drive;
pub(crate) mod makespan;
mod reference;
mod rules;
mod sets;
