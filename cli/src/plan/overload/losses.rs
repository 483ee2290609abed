//! What became of each task's jobs, counted from their ends.

use crate::given_up::GivenUp;
use red_core::ShedReason;
use red_sim::Report;
use red_workload::metrics::{JobEnd, TaskMetrics};
use red_workload::model::{Task, Workload};
use serde::Serialize;
use std::collections::VecDeque;

/// One task's jobs. Field names and their order are a contract.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Losses {
    pub(super) name: String,
    pub(super) released: u64,
    pub(super) on_time: u64,
    given_up: GivenUp,
    floor: Option<Floor>,
    #[serde(skip)]
    missed: u64,
}

/// At least `m` of any `k` jobs in a row are to be on time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
struct Floor {
    m: u32,
    k: u32,
    /// Fewest jobs on time of any `k` in a row; jobs before the first, and those that are not decided, count as on time.
    worst: u32,
    kept: bool,
}

/// What each task of a simulated workload lost.
pub(super) fn of(workload: &Workload, report: &Report) -> Vec<Losses> {
    let jobs = report.tasks.iter().zip(&report.jobs);
    jobs.zip(&workload.tasks).map(|((metrics, jobs), task)| Losses::of(task, metrics, jobs, report)).collect()
}

impl Losses {
    fn of(task: &Task, metrics: &TaskMetrics, jobs: &[JobEnd], report: &Report) -> Self {
        let end = report.horizon_ns;
        // A job that finds no place is decided when it is released.
        let is_decided =
            |job: &&JobEnd| job.at_ns.is_some_and(|at| at < end || job.shed == Some(ShedReason::Full));
        let reasons = jobs.iter().filter(is_decided).filter_map(|job| job.shed).map(ShedReason::name);
        Self {
            name: metrics.name.clone(),
            released: metrics.released,
            on_time: metrics.on_time,
            given_up: reasons.collect(),
            floor: task.floor.map(|(m, k)| Floor::of(m, k, jobs, end)),
            missed: metrics.missed,
        }
    }

    /// Jobs that were not on time, for whatever reason.
    pub(super) const fn lost(&self) -> u64 {
        self.missed
    }

    pub(super) fn cells(&self) -> [String; 7] {
        let late = self.missed - self.given_up.total();
        let floor = self.floor.map(|floor| {
            let kept = if floor.kept { "kept" } else { "not kept" };
            (format!("{} of {} {kept}", floor.m, floor.k), format!("{} of {}", floor.worst, floor.k))
        });
        let (floor, worst) = floor.unwrap_or_else(|| ("-".to_owned(), "-".to_owned()));
        let counts = [self.released, self.on_time, late].map(|count| count.to_string());
        let [released, on_time, late] = counts;
        [self.name.clone(), released, on_time, late, self.given_up.to_string(), floor, worst]
    }
}

impl Floor {
    fn of(m: u32, k: u32, jobs: &[JobEnd], end: u64) -> Self {
        let is_lost = |job: &JobEnd| match (job.at_ns, job.shed) {
            (Some(at), Some(reason)) => at < end || reason == ShedReason::Full,
            (Some(at), None) => at > job.deadline_ns && job.deadline_ns < end,
            (None, _) => job.deadline_ns < end,
        };
        let (mut window, mut lost, mut most) = (VecDeque::new(), 0_u32, 0);
        for job in jobs.iter().map(is_lost) {
            window.push_back(job);
            lost += u32::from(job);
            if window.len() > k as usize {
                lost -= u32::from(window.pop_front() == Some(true));
            }
            most = most.max(lost);
        }
        let worst = k - most;
        Self { m, k, worst, kept: worst >= m }
    }
}

#[cfg(test)]
mod tests;
