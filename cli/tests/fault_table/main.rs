//! The fault table: one test for each row of `docs/faults.md`, by the row's number. `cargo xtask faults` runs these and
//! prints the table; a row without a test, or a test without a row, fails there.

#[path = "../process/alone.rs"]
mod alone;
mod execution;
mod files;
mod graph;
mod host;
mod numbers;
#[path = "../process/plugin.rs"]
mod plugin;
#[path = "../process/mod.rs"]
mod process;
#[path = "../process/refused.rs"]
mod refusal;
mod supply;
mod virtual_time;
