//! What a simulation answers: rows, sheds, counts.

use red_workload::model::Workload;

use super::Sim;
use super::job::{Job, SubId};
use crate::graph::Graph;

/// One sub-job that started. The order of the fields is the order of the rows.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Row {
    /// When it started.
    pub start_ns: u64,
    /// Pool name.
    pub pool: String,
    /// Lane within the pool; `None` for a frame-cache hit.
    pub lane: Option<u32>,
    /// Task name.
    pub task: String,
    /// Job index within the task.
    pub job: u64,
    /// Node name.
    pub node: String,
    /// When it ends, also where that is beyond the horizon.
    pub finish_ns: u64,
}

/// Why a job was given up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// It could not end in time any more.
    Hopeless,
    /// Dropped under REDRT for others that would be late.
    Overload,
    /// Dropped for others under RED.
    Urgency,
    /// Too many jobs were in flight: it was refused, or under REDRT replaced.
    Full,
}

impl Reason {
    /// The word in the JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hopeless => "hopeless",
            Self::Overload => "overload",
            Self::Urgency => "urgency",
            Self::Full => "full",
        }
    }
}

/// One job given up. The order of the fields is the order of the list.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ShedRow {
    /// When.
    pub at_ns: u64,
    /// Task name.
    pub task: String,
    /// Job index within the task.
    pub job: u64,
    /// Why.
    pub reason: Reason,
}

/// What became of one task's jobs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskOutcome {
    /// Name.
    pub name: String,
    /// Released before the horizon.
    pub released: u64,
    /// Ended before the horizon.
    pub completed: u64,
    /// Ended by the deadline.
    pub on_time: u64,
    /// Ended late, or shed, or neither though the deadline is before the horizon.
    pub missed: u64,
    /// Given up.
    pub shed: u64,
    /// Response of each completed job, in order of release.
    pub response_ns: Vec<u64>,
    /// Tardiness of each completed job, in order of release; 0 on time.
    pub tardiness_ns: Vec<u64>,
}

impl TaskOutcome {
    /// Mean over decided jobs of 1 / (1 + e^lambda * tardiness in seconds); a job that did not complete scores 0.
    /// `None` without decided jobs.
    pub fn qoe(&self, lambda: f64) -> Option<f64> {
        let score = |&tardiness: &u64| 1.0 / (1.0 + lambda.exp() * tardiness as f64 * 1e-9);
        let decided = self.on_time + self.missed;
        (decided > 0).then(|| self.tardiness_ns.iter().map(score).sum::<f64>() / decided as f64)
    }
}

/// A whole simulation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// One row per start of a sub-job, sorted.
    pub rows: Vec<Row>,
    /// Every job given up, sorted.
    pub sheds: Vec<ShedRow>,
    /// One per task, in file order.
    pub tasks: Vec<TaskOutcome>,
    /// Encoder sub-jobs that completed without executing.
    pub encoder_runs_saved: u64,
    /// Units that took a lane.
    pub units_dispatched: u64,
    /// Busy lane time of each pool up to the horizon, in file order.
    pub busy_ns: Vec<u64>,
    ends: Vec<JobEnd>,
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct JobEnd {
    task: usize,
    index: u64,
    release: u64,
    due: i128,
    end: Option<u64>,
    shed: Option<Reason>,
}

impl Outcome {
    pub(super) fn new(workload: &Workload) -> Self {
        let task = |task: &red_workload::model::Task| TaskOutcome {
            name: task.name.clone(),
            ..TaskOutcome::default()
        };
        Self {
            rows: Vec::new(),
            sheds: Vec::new(),
            tasks: workload.tasks.iter().map(task).collect(),
            encoder_runs_saved: 0,
            units_dispatched: 0,
            busy_ns: vec![0; workload.pools.len()],
            ends: Vec::new(),
        }
    }

    pub(super) fn release(&mut self, job: &Job) {
        let Job { task, index, release, due, .. } = *job;
        self.ends.push(JobEnd { task, index, release, due, end: None, shed: None });
    }

    pub(super) fn end(&mut self, job: &Job, now: u64) {
        self.record(job).end = Some(now);
    }

    pub(super) fn shed(&mut self, job: &Job, now: u64, reason: Reason) {
        self.record(job).shed = Some(reason);
        let task = self.tasks[job.task].name.clone();
        self.sheds.push(ShedRow { at_ns: now, task, job: job.index, reason });
    }

    fn record(&mut self, job: &Job) -> &mut JobEnd {
        let mine = |end: &&mut JobEnd| (end.task, end.index) == (job.task, job.index);
        self.ends.iter_mut().rev().find(mine).expect("every job is recorded at its release")
    }

    /// Whether a job was given up, refused, or ended late.
    pub(super) fn is_lost(&self, task: usize, index: u64) -> bool {
        let found = self.ends.iter().rev().find(|end| (end.task, end.index) == (task, index));
        found.is_some_and(|job| job.shed.is_some() || job.end.is_some_and(|end| i128::from(end) > job.due))
    }

    /// Index of the newest job of a task that is no more in flight.
    pub(super) fn newest_ended(&self, task: usize) -> Option<u64> {
        let gone = |end: &&JobEnd| end.task == task && (end.end.is_some() || end.shed.is_some());
        self.ends.iter().filter(gone).map(|end| end.index).max()
    }

    pub(super) fn row(
        &mut self,
        workload: &Workload,
        (task, job, node): SubId,
        graph: &Graph,
        lane: Option<u32>,
        start_ns: u64,
        finish_ns: u64,
    ) {
        let sub = &graph.nodes[node];
        let pool = workload.pools[sub.pool].name.clone();
        let task = workload.tasks[task].name.clone();
        self.rows.push(Row { start_ns, pool, lane, task, job, node: sub.name.clone(), finish_ns });
    }

    fn count(&mut self, horizon: u64) {
        for end in &self.ends {
            let task = &mut self.tasks[end.task];
            let late = |at: u64| i128::from(at) > end.due;
            task.released += 1;
            task.shed += u64::from(end.shed.is_some());
            if let Some(at) = end.end {
                task.completed += 1;
                task.response_ns.push(at - end.release);
                let tardiness = (i128::from(at) - end.due).max(0);
                task.tardiness_ns.push(u64::try_from(tardiness).expect("an instant is a u64"));
            }
            task.on_time += u64::from(end.end.is_some_and(|at| !late(at)));
            let missed = match end.end {
                Some(at) => late(at),
                None => end.shed.is_some() || end.due < i128::from(horizon),
            };
            task.missed += u64::from(missed);
        }
    }
}

impl Sim<'_> {
    pub(super) fn into_outcome(self) -> Outcome {
        let mut outcome = self.outcome;
        outcome.count(self.horizon);
        outcome.rows.sort();
        outcome.sheds.sort();
        outcome
    }
}
