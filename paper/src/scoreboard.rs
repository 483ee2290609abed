//! Policies beside each other, on workloads that are not the paper's.

pub(crate) mod acceptance;
pub(crate) mod admission;
mod bound;
mod drive;
mod federated;
pub(crate) mod makespan;
pub(crate) mod mixes;
pub(crate) mod overload;
mod reference;
mod rules;
mod sets;
pub(crate) mod soundness;
