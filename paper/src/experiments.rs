//! The list of experiments, in the order of the paper.

mod burst;
mod case_1;
mod case_2;
mod deadlines;
mod effectiveness;
mod extended;
mod lone;
mod non_partitionable;
mod overhead;
mod qualities;
mod ros2;
mod worked_example;

use crate::run::{PaperError, Run};
use crate::scoreboard::{acceptance, admission, makespan, mixes, overload, soundness};
use crate::table::Table;

/// What an experiment belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The paper's.
    Paper,
    /// Policies beside each other, on other workloads: `scoreboard` on the command line.
    Scoreboard,
}

/// An experiment.
#[derive(Clone, Copy)]
pub struct Experiment {
    /// Name on the command line.
    pub name: &'static str,
    /// What it is about, in a line.
    pub what: &'static str,
    /// What it belongs to.
    pub group: Group,
    /// Runs it.
    pub run: fn(&Run<'_>) -> Result<Table, PaperError>,
}

/// All of them.
pub const EXPERIMENTS: &[Experiment] = &[
    Experiment {
        name: "case-1",
        what: "an obstacle puts a task into the pipeline",
        group: Group::Paper,
        run: case_1::run,
    },
    Experiment { name: "case-2", what: "30 Hz against 33 Hz", group: Group::Paper, run: case_2::run },
    Experiment {
        name: "worked-example",
        what: "the chain of 20, 20 and 40 s within 120 s",
        group: Group::Paper,
        run: worked_example::run,
    },
    Experiment {
        name: "effectiveness",
        what: "latency, misses and quality on Nano, TX2, Xavier and Orin",
        group: Group::Paper,
        run: effectiveness::run,
    },
    Experiment {
        name: "ros2",
        what: "one frame, four outputs, six levels of interference",
        group: Group::Paper,
        run: ros2::run,
    },
    Experiment {
        name: "deadlines",
        what: "latency against six deadlines on Xavier",
        group: Group::Paper,
        run: deadlines::run,
    },
    Experiment {
        name: "lambda",
        what: "quality at five values of lambda",
        group: Group::Paper,
        run: qualities::run,
    },
    Experiment {
        name: "overhead",
        what: "memory and decisions of the scheduler",
        group: Group::Paper,
        run: overhead::run,
    },
    Experiment {
        name: "extended",
        what: "five scenarios on three platforms",
        group: Group::Paper,
        run: extended::run,
    },
    Experiment {
        name: "non-partitionable",
        what: "0, 50 and 100 % of tasks that cannot be split",
        group: Group::Paper,
        run: non_partitionable::run,
    },
    Experiment { name: "burst", what: "0, 50 and 100 % of bursts", group: Group::Paper, run: burst::run },
    Experiment {
        name: "acceptance",
        what: "random DAG sets under every rule",
        group: Group::Scoreboard,
        run: acceptance::run,
    },
    Experiment {
        name: "makespan",
        what: "graphs whose optimum is known, under every rule",
        group: Group::Scoreboard,
        run: makespan::run,
    },
    Experiment {
        name: "frame-cache",
        what: "mixes of the paper's pipelines, step by step",
        group: Group::Scoreboard,
        run: mixes::run,
    },
    Experiment {
        name: "overload",
        what: "more work than the lanes can do, under ours and the literature's",
        group: Group::Scoreboard,
        run: overload::run,
    },
    Experiment {
        name: "broken-groups",
        what: "protected groups that redrt breaks, and who kept a lane from them",
        group: Group::Scoreboard,
        run: overload::broken::run,
    },
    Experiment {
        name: "admission",
        what: "random DAG sets that are proved before they run",
        group: Group::Scoreboard,
        run: admission::run,
    },
    Experiment {
        name: "admission-trial",
        what: "what is proved, against the scheduler",
        group: Group::Scoreboard,
        run: soundness::run,
    },
];
