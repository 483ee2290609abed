//! The fault table: one test for each row of `docs/faults.md`, by the row's number. `cargo xtask faults` runs these and
//! prints the table; a row without a test, or a test without a row, fails there.

mod abi;
#[path = "../process/alone.rs"]
mod alone;
mod apart;
mod cpus;
mod execution;
mod files;
mod gpu;
mod graph;
mod host;
mod lanes;
mod numbers;
#[path = "../process/plugin.rs"]
mod plugin;
#[path = "../process/mod.rs"]
mod process;
mod redrt;
#[path = "../process/refused.rs"]
mod refusal;
mod rights;
mod supply;
mod threads;
mod virtual_time;
