//! What was proved of a workload, and the check of it: all that has to be trusted.
//!
//! Whoever searches for a proof (the package `red-analysis`) may be wrong. [`verify`] evaluates the inequalities that a
//! [`Certificate`] names, against the [`Set`] alone: no search, no fixed point, and nothing of the searcher's code.
//!
//! What a proof assumes of the dispatcher (M1 to M6 in `docs/admission.md`) nothing here can see; tests of the scheduler do.
#![forbid(unsafe_code)]

#[cfg(test)]
mod by_hand;
mod format;
mod graph;
mod inequality;
mod rejected;
mod rivals;
mod set;
mod verify;
mod work;

pub use format::{
    Certificate, ClusterProof, Guarantee, Keys, Proof, TaskProof, VERSION, Variant, VersionProof,
};
pub use rejected::Rejected;
pub use set::{Cluster, Graph, Node, Set, Task};
pub use verify::verify;
