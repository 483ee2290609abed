//! What a simulation says, as `redrt sim --json` prints it.

use red_workload::metrics::{JobEnd, TaskMetrics};
use serde::Serialize;

/// A whole simulation. Field names and their order are a contract.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Policy.
    pub policy: &'static str,
    /// Seed of the execution times.
    pub seed: u64,
    /// Simulated time.
    pub horizon_ns: u64,
    /// Per task, in file order.
    pub tasks: Vec<TaskMetrics>,
    /// Sub-jobs that ended after their sub-deadlines.
    pub nodes_missed: u64,
    /// Units that got a lane.
    pub units_dispatched: u64,
    /// Encoder sub-jobs that completed without executing.
    pub encoder_runs_saved: u64,
    /// Per pool, in file order.
    pub pools: Vec<PoolMetrics>,
    /// With `--schedule`: every sub-job that started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub schedule: Option<Vec<Row>>,
    /// With `--schedule`: every job that was given up.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sheds: Option<Vec<Shed>>,
    /// How each job ended, by task and job index.
    #[serde(skip)]
    pub jobs: Vec<Vec<JobEnd>>,
}

/// A pool in numbers.
#[derive(Clone, Debug, Serialize)]
pub struct PoolMetrics {
    /// Pool.
    pub name: String,
    /// Its lanes.
    pub lanes: u32,
    /// Lane time used before the horizon.
    pub busy_ns: u64,
}

/// One sub-job that started.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Row {
    /// Task.
    pub task: String,
    /// Job index, from 0.
    pub job: u64,
    /// Node.
    pub node: String,
    /// Pool.
    pub pool: String,
    /// Lane within its pool; `null` for an encoder that took a kept result.
    pub lane: Option<u32>,
    /// Start.
    pub start_ns: u64,
    /// Finish, also where it lies after the horizon.
    pub finish_ns: u64,
}

/// A job that was given up.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Shed {
    /// Task.
    pub task: String,
    /// Job index, from 0.
    pub job: u64,
    /// When.
    pub at_ns: u64,
    /// Why.
    pub reason: &'static str,
}
