//! What is outside of the scheduler: when jobs come, how long nodes execute, which fail.

use crate::execution::Execution;
use red_workload::build::Numbered;
use red_workload::model::{Arrival, Workload};

/// The world of a simulation. Times are in nanoseconds.
pub trait World {
    /// When the job of this number of a task is released, if there is one. Later jobs come no earlier.
    fn release(&self, task: usize, job: usize) -> Option<u64>;

    /// How long a node of a job executes, and whether that is more than a guess.
    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool);

    /// Whether its body fails.
    fn fails(&self, task: usize, job: u64, node: &Numbered) -> bool {
        let _never = (task, job, node);
        false
    }
}

/// Releases as the workload has them, execution times by a model.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// Whose releases.
    pub workload: &'a Workload,
    /// Execution times.
    pub execution: Execution,
    /// Their seed.
    pub seed: u64,
}

impl World for Drawn<'_> {
    fn release(&self, task: usize, job: usize) -> Option<u64> {
        let task = self.workload.tasks.get(task)?;
        let after = match task.arrival {
            Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => {
                t.checked_mul(job as u64)?
            }
            Arrival::Once => (job == 0).then_some(0)?,
        };
        task.offset_ns.checked_add(after)
    }

    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        (self.execution.draw(self.seed, task, job, node), true)
    }
}
