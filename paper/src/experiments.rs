//! The list of experiments, in the order of the paper.

mod effectiveness;
mod lone;
mod worked_example;

use crate::run::{PaperError, Run};
use crate::table::Table;

/// An experiment.
#[derive(Clone, Copy)]
pub struct Experiment {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is about, in a line.
    pub what: &'static str,
    /// Runs it.
    pub run: fn(&Run<'_>) -> Result<Table, PaperError>,
}

/// All of them.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "worked-example",
        what: "the chain of 20, 20 and 40 s within 120 s",
        run: worked_example::run,
    },
    Experiment {
        name: "effectiveness",
        what: "latency, misses and quality on Nano, TX2, Xavier and Orin",
        run: effectiveness::run,
    },
];
