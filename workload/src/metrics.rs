//! What a run is judged by, from the ends of its jobs: the same for the simulator and for real time.

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
        self.jobs.push(JobEnd { release_ns, deadline_ns, at_ns: None, shed: None });
    }

    /// A job found no place.
    pub fn refused(&mut self, release_ns: u64, deadline_ns: u64) {
        let (at_ns, shed) = (Some(release_ns), Some(ShedReason::Full));
        self.jobs.push(JobEnd { release_ns, deadline_ns, at_ns, shed });
    }

    /// A job ended.
    pub fn ended(&mut self, outcome: &Outcome) {
        let job = usize::try_from(outcome.index).ok().and_then(|i| self.jobs.get_mut(i));
        if let Some(job) = job {
            job.at_ns = Some(outcome.at.as_nanos());
            job.shed = outcome.shed;
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
    /// Release to end, over completed jobs.
    pub response_ns: Distribution,
    /// Lateness above zero, over completed jobs.
    pub tardiness_ns: Tardiness,
    /// Quality of experience by lambda, mean over decided jobs; one that was given up or did not end scores 0.
    pub qoe: BTreeMap<&'static str, Option<f64>>,
}

/// Nearest-rank percentile of a sorted list.
#[must_use]
pub fn percentile(sorted: &[u64], per_mille: usize) -> Option<u64> {
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

/// Counts the jobs that were released before `until`, by what happened to them before `end`.
#[must_use]
pub fn summarise(name: &str, log: &TaskLog, until: Instant, end: Instant) -> TaskMetrics {
    let (until, end) = (until.as_nanos(), end.as_nanos());
    let mut responses = Vec::new();
    let mut tardiness = Vec::new();
    let mut scores = Vec::new();
    let mut metrics = TaskMetrics {
        name: name.to_owned(),
        released: 0,
        completed: 0,
        on_time: 0,
        missed: 0,
        shed: 0,
        response_ns: Distribution::default(),
        tardiness_ns: Tardiness::default(),
        qoe: BTreeMap::new(),
    };
    for job in log.jobs.iter().filter(|job| job.release_ns < until) {
        metrics.released += 1;
        let ended = job.at_ns.filter(|at| *at < end || job.shed == Some(ShedReason::Full));
        match (ended, job.shed) {
            (Some(_), Some(_)) => {
                metrics.shed += 1;
                metrics.missed += 1;
                scores.push(None);
            }
            (Some(at), None) => {
                metrics.completed += 1;
                let late = at.saturating_sub(job.deadline_ns);
                if late == 0 {
                    metrics.on_time += 1;
                } else {
                    metrics.missed += 1;
                }
                responses.push(at.saturating_sub(job.release_ns));
                tardiness.push(late);
                scores.push(Some(late));
            }
            (None, _) if job.deadline_ns < end => {
                metrics.missed += 1;
                scores.push(None);
            }
            (None, _) => {}
        }
    }
    metrics.response_ns = distribution(&mut responses);
    metrics.tardiness_ns = Tardiness { mean: mean(&tardiness), max: tardiness.iter().max().copied() };
    for (label, lambda) in LAMBDAS {
        let sum: f64 = scores.iter().map(|late| late.map_or(0.0, |late| quality(lambda, late))).sum();
        metrics.qoe.insert(label, (!scores.is_empty()).then(|| sum / scores.len() as f64));
    }
    metrics
}
