//! What became of each task's jobs, as `plan` tells it.

use crate::given_up;
use red_sim::Report;
use red_workload::metrics::TaskMetrics;
use red_workload::metrics::floor::FloorMetrics;
use serde::Serialize;
use std::collections::BTreeMap;

/// One task's jobs. Field names and their order are a contract.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Losses {
    pub(super) name: String,
    pub(super) released: u64,
    pub(super) on_time: u64,
    given_up: BTreeMap<&'static str, u64>,
    floor: Option<FloorMetrics>,
    #[serde(skip)]
    missed: u64,
    /// The WCET of the longest of its nodes that ran.
    #[serde(skip)]
    pub(super) ran_ns: u64,
}

/// What each task of a simulated workload lost.
pub(super) fn of(report: Report) -> Vec<Losses> {
    report.tasks.into_iter().map(Losses::from).collect()
}

impl From<TaskMetrics> for Losses {
    fn from(task: TaskMetrics) -> Self {
        let ran = task.nodes.iter().filter(|node| node.count > 0);
        let ran_ns = ran.map(|node| node.wcet_ns).max().unwrap_or(0);
        let TaskMetrics { name, released, on_time, given_up, floor, missed, .. } = task;
        Self { name, released, on_time, given_up, floor, missed, ran_ns }
    }
}

impl Losses {
    /// Jobs that were not on time, for whatever reason.
    pub(super) const fn lost(&self) -> u64 {
        self.missed
    }

    pub(super) fn cells(&self) -> [String; 7] {
        let late = self.missed - self.given_up.values().sum::<u64>();
        let floor = self.floor.map(|floor| {
            let kept = if floor.kept { "kept" } else { "not kept" };
            (format!("{} of {} {kept}", floor.m, floor.k), format!("{} of {}", floor.worst, floor.k))
        });
        let (floor, worst) = floor.unwrap_or_else(|| ("-".to_owned(), "-".to_owned()));
        let [released, on_time, late] = [self.released, self.on_time, late].map(|count| count.to_string());
        [self.name.clone(), released, on_time, late, given_up::list(&self.given_up), floor, worst]
    }
}
