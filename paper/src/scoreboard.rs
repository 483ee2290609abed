//! Policies beside each other, on workloads that are not the paper's.

pub(crate) mod acceptance;
mod bound;
mod drive;
mod federated;
pub(crate) mod makespan;
pub(crate) mod mixes;
mod reference;
mod rules;
mod sets;
