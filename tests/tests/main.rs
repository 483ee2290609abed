//! The tests of the scheduler from outside, in one program: the core is generic, and each program compiles it anew.
//! Two have programs of their own: the comparison with the oracle, which other processors run alone, and what counts
//! allocations.

mod ahead;
mod counterexamples;
mod errors;
mod every_overload_history;
mod every_queue_sequence;
mod every_small_graph;
mod golden;
mod hopeless;
mod late_looks;
mod layering;
mod lost_pool;
mod manual;
mod observed_use;
mod overtaking;
mod paper_algorithms;
mod paper_schedulability;
mod paper_tables;
mod paper_worked_example;
mod papers;
mod plan_json;
mod promises;
mod properties;
mod purpose;
mod sources;
mod waiting;
mod warnings;
