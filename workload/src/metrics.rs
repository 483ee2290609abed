//! What a run is judged by, from the ends of its jobs: the same for the simulator and for real time.

pub mod floor;
pub mod nodes;

use crate::model::Task;
use floor::FloorMetrics;
use nodes::NodeMetrics;
use red_core::{Instant, Outcome, ShedReason};
use serde::Serialize;
use std::collections::BTreeMap;

/// Percentages of the distribution that are reported, and the two lambdas of the quality of experience.
const LAMBDAS: [(&str, f64); 2] = [("0.05", 0.05), ("1", 1.0)];

/// How one job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JobEnd {
    /// When it was released.
    pub release_ns: u64,
    /// When it was due.
    pub deadline_ns: u64,
    /// When it ended; `None` if it had not at the end of the run.
    pub at_ns: Option<u64>,
    /// Why it was given up, if it was.
    pub shed: Option<ShedReason>,
    /// When the scheduler warned of its miss, if it did.
    pub warned_ns: Option<u64>,
}

/// Jobs of one task.
#[derive(Clone, Debug, Default)]
pub struct TaskLog {
    /// By job index.
    jobs: Vec<JobEnd>,
}

impl TaskLog {
    /// Room for this many jobs, so that a run allocates nothing.
    #[must_use]
    pub fn with_capacity(jobs: usize) -> Self {
        Self { jobs: Vec::with_capacity(jobs) }
    }

    /// Whether another job can be noted without allocating.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.jobs.len() < self.jobs.capacity()
    }

    /// The next job was released.
    pub fn released(&mut self, release_ns: u64, deadline_ns: u64) {
        self.jobs.push(JobEnd { release_ns, deadline_ns, at_ns: None, shed: None, warned_ns: None });
    }

    /// A job found no place.
    pub fn refused(&mut self, release_ns: u64, deadline_ns: u64) {
        let (at_ns, shed) = (Some(release_ns), Some(ShedReason::Full));
        self.jobs.push(JobEnd { release_ns, deadline_ns, at_ns, shed, warned_ns: None });
    }

    /// A job ended.
    pub fn ended(&mut self, outcome: &Outcome) {
        let job = usize::try_from(outcome.index).ok().and_then(|i| self.jobs.get_mut(i));
        if let Some(job) = job {
            job.at_ns = Some(outcome.at.as_nanos());
            job.shed = outcome.shed;
        }
    }

    /// The scheduler predicts that a job misses its deadline.
    pub fn warned(&mut self, index: u64, at_ns: u64) {
        if let Some(job) = usize::try_from(index).ok().and_then(|i| self.jobs.get_mut(i)) {
            job.warned_ns = Some(at_ns);
        }
    }

    /// How the jobs ended, by job index.
    #[must_use]
    pub fn jobs(&self) -> &[JobEnd] {
        &self.jobs
    }
}

/// A distribution in nanoseconds; `null` in JSON where there was no job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Distribution {
    /// Mean, rounded down.
    pub mean: Option<u64>,
    /// Median, nearest rank.
    pub p50: Option<u64>,
    /// 99th percentile, nearest rank.
    pub p99: Option<u64>,
    /// Largest.
    pub max: Option<u64>,
}

/// Mean and largest, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tardiness {
    /// Mean, rounded down.
    pub mean: Option<u64>,
    /// Largest.
    pub max: Option<u64>,
}

/// How long before their deadlines jobs were warned of, in nanoseconds; below zero where that was after them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Early {
    /// Median, nearest rank.
    pub p50: Option<i64>,
    /// 99th percentile, nearest rank.
    pub p99: Option<i64>,
}

/// What a task is judged by besides its jobs.
#[derive(Clone, Copy, Debug)]
pub struct Judged<'a> {
    /// Its name.
    pub name: &'a str,
    /// What one of its jobs is worth.
    pub value: u32,
    /// `m` of any `k` consecutive jobs are to be on time.
    pub floor: Option<(u32, u32)>,
}

impl<'a> From<&'a Task> for Judged<'a> {
    fn from(task: &'a Task) -> Self {
        Self { name: &task.name, value: task.value, floor: task.floor }
    }
}

/// A task's jobs in numbers. `released = on_time + missed + undecided`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskMetrics {
    /// Task.
    pub name: String,
    /// Jobs released within the horizon.
    pub released: u64,
    /// Jobs whose nodes all ended within it.
    pub completed: u64,
    /// Completed by their deadlines.
    pub on_time: u64,
    /// Completed late, given up, or not ended though due before the horizon.
    pub missed: u64,
    /// Given up.
    pub shed: u64,
    /// Given up, by reason; reasons that did not occur are left out.
    pub given_up: BTreeMap<&'static str, u64>,
    /// The task's floor, and whether it was kept; `null` in JSON where it has none.
    pub floor: Option<FloorMetrics>,
    /// Value of the jobs that were on time.
    pub value_on_time: u64,
    /// Value of all jobs released.
    pub value_released: u64,
    /// Jobs whose miss the scheduler predicted.
    pub warned: u64,
    /// Jobs whose miss it predicted, and that were on time.
    pub warned_on_time: u64,
    /// Deadline less warning, over the jobs that were warned of.
    pub early_ns: Early,
    /// Release to end, over completed jobs.
    pub response_ns: Distribution,
    /// Lateness above zero, over completed jobs.
    pub tardiness_ns: Tardiness,
    /// Quality of experience by lambda, mean over decided jobs; one that was given up or did not end scores 0.
    pub qoe: BTreeMap<&'static str, Option<f64>>,
    /// Its nodes, in the order of their numbers; left out where executions were not followed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub nodes: Vec<NodeMetrics>,
}

/// Nearest-rank percentile of a sorted list.
#[must_use]
pub fn percentile<T: Copy>(sorted: &[T], per_mille: usize) -> Option<T> {
    let rank = (sorted.len() * per_mille).div_ceil(1_000).max(1);
    sorted.get(rank - 1).copied()
}

/// Mean, median, 99th percentile and maximum of a list, which is sorted on the way.
#[must_use]
pub fn distribution(values: &mut [u64]) -> Distribution {
    values.sort_unstable();
    Distribution {
        mean: mean(values),
        p50: percentile(values, 500),
        p99: percentile(values, 990),
        max: values.last().copied(),
    }
}

fn mean(values: &[u64]) -> Option<u64> {
    let sum: u128 = values.iter().copied().map(u128::from).sum();
    let mean = sum.checked_div(values.len() as u128)?;
    u64::try_from(mean).ok()
}

/// The paper's score: 1 / (1 + e^lambda * tardiness in seconds).
#[must_use]
pub fn quality(lambda: f64, tardiness_ns: u64) -> f64 {
    1.0 / (1.0 + lambda.exp() * (tardiness_ns as f64) * 1e-9)
}

/// What became of a job by the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fate {
    GivenUp(ShedReason),
    /// With its lateness.
    Completed(u64),
    /// It was due, and had not ended.
    Overdue,
    Undecided,
}

impl JobEnd {
    fn fate(&self, end_ns: u64) -> Fate {
        let ended = self.at_ns.filter(|at| *at < end_ns || self.shed == Some(ShedReason::Full));
        match (ended, self.shed) {
            (Some(_), Some(reason)) => Fate::GivenUp(reason),
            (Some(at), None) => Fate::Completed(at.saturating_sub(self.deadline_ns)),
            (None, _) if self.deadline_ns < end_ns => Fate::Overdue,
            (None, _) => Fate::Undecided,
        }
    }
}

/// Counts the jobs that were released before `until`, by what happened to them before `end`.
#[must_use]
pub fn summarise<'a>(of: impl Into<Judged<'a>>, log: &TaskLog, until: Instant, end: Instant) -> TaskMetrics {
    let (of, until, end) = (of.into(), until.as_nanos(), end.as_nanos());
    let counted = log.jobs.iter().filter(|job| job.release_ns < until);
    let counted: Vec<(&JobEnd, Fate)> = counted.map(|job| (job, job.fate(end))).collect();
    let count = |is: &dyn Fn(Fate) -> bool| counted.iter().filter(|(_, fate)| is(*fate)).count() as u64;
    let (released, on_time) = (count(&|_| true), count(&|fate| fate == Fate::Completed(0)));
    let mut given_up = BTreeMap::new();
    let (mut responses, mut tardiness, mut scores) = (Vec::new(), Vec::new(), Vec::new());
    for (job, fate) in &counted {
        match *fate {
            Fate::GivenUp(reason) => {
                *given_up.entry(reason.name()).or_default() += 1;
                scores.push(None);
            }
            Fate::Completed(late) => {
                responses.push(job.at_ns.unwrap_or(end).saturating_sub(job.release_ns));
                tardiness.push(late);
                scores.push(Some(late));
            }
            Fate::Overdue => scores.push(None),
            Fate::Undecided => {}
        }
    }
    let score = |lambda: f64| {
        let sum: f64 = scores.iter().map(|late| late.map_or(0.0, |late| quality(lambda, late))).sum();
        (!scores.is_empty()).then(|| sum / scores.len() as f64)
    };
    let warned = counted.iter().filter_map(|(job, fate)| Some((job.deadline_ns, job.warned_ns?, *fate)));
    let mut early: Vec<i64> =
        warned.clone().map(|(due, warned, _)| due.cast_signed().wrapping_sub(warned.cast_signed())).collect();
    early.sort_unstable();
    let decided = counted.iter().filter(|(_, fate)| *fate != Fate::Undecided);
    TaskMetrics {
        name: of.name.to_owned(),
        released,
        completed: responses.len() as u64,
        on_time,
        missed: scores.len() as u64 - on_time,
        shed: count(&|fate| matches!(fate, Fate::GivenUp(_))),
        given_up,
        floor: of
            .floor
            .map(|(m, k)| FloorMetrics::of(m, k, decided.map(|(_, fate)| *fate == Fate::Completed(0)))),
        value_on_time: on_time.saturating_mul(of.value.into()),
        value_released: released.saturating_mul(of.value.into()),
        warned: early.len() as u64,
        warned_on_time: warned.filter(|(_, _, fate)| *fate == Fate::Completed(0)).count() as u64,
        early_ns: Early { p50: percentile(&early, 500), p99: percentile(&early, 990) },
        response_ns: distribution(&mut responses),
        tardiness_ns: Tardiness { mean: mean(&tardiness), max: tardiness.iter().max().copied() },
        qoe: LAMBDAS.into_iter().map(|(label, lambda)| (label, score(lambda))).collect(),
        nodes: Vec::new(),
    }
}
