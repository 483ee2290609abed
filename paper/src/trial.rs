//! One workload under one system, over seeds.

use crate::stat::Estimate;
use red_core::{BestCase, Config, Shed};
use red_sim::{Drawn, Execution, Options, Report, SimError, World, simulate_in};
use red_workload::metrics::{JobEnd, quality};
use red_workload::model::Workload;
use red_workload::policy::Policy;

/// A system of the paper, or ours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum System {
    /// The paper's baseline.
    Edf,
    /// Refined, level shares, level barrier.
    RedFg,
    /// With re-assignment.
    RedIda,
    /// The paper's RED without ProactiveDrop. Its predicate speaks of overload while a GPU is busy, which the paper says
    /// it always was: a pipeline one of whose decoders waits for the lane would be given up, alone as it is.
    Red,
    /// With ProactiveDrop.
    RedDrops,
    /// Ours.
    Redrt,
}

impl System {
    /// The paper's four and ours, without ProactiveDrop.
    pub const ALL: [Self; 5] = [Self::Edf, Self::RedFg, Self::RedIda, Self::Red, Self::Redrt];

    /// Name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Edf => "EDF",
            Self::RedFg => "RED-FG",
            Self::RedIda => "RED-IDA",
            Self::Red => "RED",
            Self::RedDrops => "RED + drop",
            Self::Redrt => "REDRT",
        }
    }

    /// The policy that it is.
    #[must_use]
    pub const fn policy(self) -> Policy {
        match self {
            Self::Edf => Policy::Edf,
            Self::RedFg => Policy::RedFg,
            Self::RedIda => Policy::RedIda,
            Self::Red | Self::RedDrops => Policy::Red,
            Self::Redrt => Policy::Redrt,
        }
    }

    /// Its configuration.
    #[must_use]
    pub const fn config(self) -> Config {
        let config = Config { best_case: BestCase::Declared, ..self.policy().config() };
        match self {
            Self::Red => Config { shed: Shed::Never, ..config },
            _ => config,
        }
    }
}

/// What is run.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What is scheduled.
    pub workload: Workload,
    /// Execution times.
    pub execution: Execution,
    /// Simulated time, in nanoseconds.
    pub horizon_ns: u64,
}

/// One run in numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sample {
    /// Mean response time of completed jobs, in seconds; `None` where none completed.
    pub latency_s: Option<f64>,
    /// Share of decided jobs that missed their deadlines, those given up among them.
    pub missed: f64,
    /// Share of decided jobs that were given up.
    pub given_up: f64,
    /// Share of started sub-jobs that ended after their sub-deadlines.
    pub nodes_missed: f64,
    /// Tardiness of decided jobs in nanoseconds; `None` for those that never ended.
    pub tardiness_ns: Vec<Option<u64>>,
    /// Encoder executions that were saved.
    pub encoders_saved: f64,
    /// Units that got a lane.
    pub units: f64,
}

impl Sample {
    /// Mean quality of experience; a job that never ended scores 0.
    #[must_use]
    pub fn quality(&self, lambda: f64) -> f64 {
        let scores = self.tardiness_ns.iter().map(|late| late.map_or(0.0, |late| quality(lambda, late)));
        scores.sum::<f64>() / (self.tardiness_ns.len().max(1) as f64)
    }

    /// Two runs as one: of all their jobs.
    #[must_use]
    pub fn and(mut self, other: Self) -> Self {
        let (a, b) = (self.tardiness_ns.len() as f64, other.tardiness_ns.len() as f64);
        let share = |x: f64, y: f64| if a + b > 0.0 { (a * x + b * y) / (a + b) } else { 0.0 };
        let completed = |s: &Self| s.tardiness_ns.iter().flatten().count() as f64;
        let (c, d) = (completed(&self), completed(&other));
        self.latency_s = match (self.latency_s, other.latency_s) {
            (Some(x), Some(y)) => Some((c * x + d * y) / (c + d)),
            (one, None) | (None, one) => one,
        };
        self.missed = share(self.missed, other.missed);
        self.given_up = share(self.given_up, other.given_up);
        self.nodes_missed = share(self.nodes_missed, other.nodes_missed);
        self.encoders_saved += other.encoders_saved;
        self.units += other.units;
        self.tardiness_ns.extend(other.tardiness_ns);
        self
    }

    /// Of one task, or of all.
    fn of(report: &Report, task: Option<usize>) -> Self {
        let end = report.horizon_ns;
        let of_task = |(nth, _): &(usize, _)| task.is_none_or(|task| task == *nth);
        let of_tasks = report.jobs.iter().enumerate().filter(of_task);
        let jobs: Vec<&JobEnd> =
            of_tasks.flat_map(|(_, jobs)| jobs).filter(|job| is_decided(job, end)).collect();
        let count = jobs.len().max(1) as f64;
        let ended = |job: &JobEnd| job.at_ns.filter(|_| job.shed.is_none());
        let latencies: Vec<f64> =
            jobs.iter().filter_map(|job| Some((ended(job)? - job.release_ns) as f64 / 1e9)).collect();
        let tardiness_ns: Vec<Option<u64>> =
            jobs.iter().map(|job| Some(ended(job)?.saturating_sub(job.deadline_ns))).collect();
        let late = tardiness_ns.iter().filter(|late| **late != Some(0)).count();
        let rows = report.schedule.as_ref().map_or(0, Vec::len).max(1);
        Self {
            latency_s: Estimate::of(&latencies).map(|e| e.mean),
            missed: late as f64 / count,
            given_up: jobs.iter().filter(|job| job.shed.is_some()).count() as f64 / count,
            nodes_missed: report.nodes_missed as f64 / rows as f64,
            tardiness_ns,
            encoders_saved: report.encoder_runs_saved as f64,
            units: report.units_dispatched as f64,
        }
    }
}

/// Whether it is known what became of a job before `end`.
const fn is_decided(job: &JobEnd, end: u64) -> bool {
    matches!(job.at_ns, Some(at) if at < end) || job.deadline_ns < end
}

impl Trial {
    /// Runs it once.
    ///
    /// # Errors
    /// [`SimError`].
    pub fn run(&self, system: System, seed: u64) -> Result<Sample, SimError> {
        let world = Drawn { workload: &self.workload, execution: self.execution, seed };
        self.run_in(&world, system, system.config(), seed)
    }

    /// Runs it once in a world of the caller's, under a configuration of the caller's; the sample is of all tasks.
    ///
    /// # Errors
    /// [`SimError`].
    pub fn run_in(
        &self,
        world: &dyn World,
        system: System,
        config: Config,
        seed: u64,
    ) -> Result<Sample, SimError> {
        Ok(Sample::of(&self.simulate(world, system, config, seed)?, None))
    }

    /// [`Trial::run_in`], a sample for each task, with the jobs of that task; units and nodes are of all.
    ///
    /// # Errors
    /// [`SimError`].
    pub fn run_by_task(
        &self,
        world: &dyn World,
        system: System,
        config: Config,
        seed: u64,
    ) -> Result<Vec<Sample>, SimError> {
        let report = self.simulate(world, system, config, seed)?;
        Ok((0..self.workload.tasks.len()).map(|task| Sample::of(&report, Some(task))).collect())
    }

    fn simulate(
        &self,
        world: &dyn World,
        system: System,
        config: Config,
        seed: u64,
    ) -> Result<Report, SimError> {
        let timed = self.execution.best_cases_of(&self.workload);
        let options = Options {
            policy: system.policy(),
            horizon_ns: self.horizon_ns,
            seed,
            execution: self.execution,
            preempt: false,
            schedule: true,
        };
        simulate_in(world, &timed, config, &options)
    }
}

/// Runs of one system, by seed.
#[derive(Clone, Debug, Default)]
pub struct Samples(pub Vec<Sample>);

impl Samples {
    /// One number of each run.
    #[must_use]
    pub fn each(&self, of: impl Fn(&Sample) -> f64) -> Vec<f64> {
        self.0.iter().map(of).collect()
    }

    /// Mean response times, in seconds, by seed; a run in which no job completed has none.
    #[must_use]
    pub fn latencies_s(&self) -> Vec<f64> {
        self.0.iter().filter_map(|sample| sample.latency_s).collect()
    }

    /// Response time in seconds.
    #[must_use]
    pub fn latency_s(&self) -> Option<Estimate> {
        Estimate::of(&self.latencies_s())
    }

    /// End-to-end misses, as a share.
    #[must_use]
    pub fn missed(&self) -> Option<Estimate> {
        Estimate::of(&self.each(|sample| sample.missed))
    }

    /// Node misses, as a share.
    #[must_use]
    pub fn nodes_missed(&self) -> Option<Estimate> {
        Estimate::of(&self.each(|sample| sample.nodes_missed))
    }

    /// Jobs given up, as a share.
    #[must_use]
    pub fn given_up(&self) -> Option<Estimate> {
        Estimate::of(&self.each(|sample| sample.given_up))
    }

    /// Quality of experience.
    #[must_use]
    pub fn quality(&self, lambda: f64) -> Option<Estimate> {
        Estimate::of(&self.each(|sample| sample.quality(lambda)))
    }
}
