//! Names of what a replay shows: task, job and node instead of numbers.

use red_core::{Capacity, JobId, Scheduler, UnitId};
use red_record::{Answer, Call, Entry, Started};
use red_workload::build::Numbered;
use red_workload::model::Workload;
use std::collections::VecDeque;

/// More than are shown before a difference.
const UNITS: usize = 64;

/// A job by its task and number.
type Job = (usize, u64);

/// Follows a replay; its memory does not grow.
pub(super) struct Names {
    tasks: Vec<String>,
    /// `None`: their numbers are their names.
    nodes: Option<Vec<Vec<Numbered>>>,
    /// Jobs of each task that were released, refused ones included.
    released: Vec<u64>,
    /// The job that was released last in each place.
    jobs: Vec<Option<(JobId, Job)>>,
    /// Units that started last.
    units: VecDeque<(UnitId, Job)>,
}

impl Names {
    pub(super) fn new(workload: &Workload, nodes: Vec<Vec<Numbered>>) -> Self {
        Self {
            tasks: workload.tasks.iter().map(|task| task.name.clone()).collect(),
            nodes: Some(nodes),
            released: vec![0; workload.tasks.len()],
            jobs: Vec::new(),
            units: VecDeque::new(),
        }
    }

    /// Of at most so many tasks at once that nobody named.
    pub(super) fn by_number(tasks: usize) -> Self {
        Self {
            tasks: (0..tasks).map(|task| format!("task-{task}")).collect(),
            nodes: None,
            released: vec![0; tasks],
            jobs: Vec::new(),
            units: VecDeque::new(),
        }
    }

    /// The next entry, which was as recorded.
    pub(super) fn watch(&mut self, entry: &Entry) {
        match (entry.call, entry.answer) {
            (Call::Release { task, .. }, Answer::Released(answer)) => {
                let Some(released) = self.released.get_mut(task.index()) else { return };
                if let Ok(job) = answer {
                    if self.jobs.len() <= job.index() {
                        self.jobs.resize(job.index() + 1, None);
                    }
                    self.jobs[job.index()] = Some((job, (task.index(), *released)));
                }
                *released += 1;
            }
            // Another task than the one that was there before.
            (Call::AddTask { .. }, Answer::Task(Ok(task))) => {
                if let Some(released) = self.released.get_mut(task.index()) {
                    *released = 0;
                }
            }
            (_, Answer::Started(started) | Answer::Ahead(started)) => {
                if let Some(job) = self.job(started.job) {
                    self.units.truncate(UNITS - 1);
                    self.units.push_front((started.unit, job));
                }
            }
            _ => {}
        }
    }

    /// Of a unit that starts.
    pub(super) fn of_start(&self, started: &Started) -> Option<String> {
        self.name(self.job(started.job)?, started.unit)
    }

    /// Of a unit that runs, or did a while ago.
    pub(super) fn of_unit<C: Capacity>(&self, unit: UnitId, scheduler: &Scheduler<C>) -> Option<String> {
        let known = self.units.iter().find(|(named, _)| *named == unit).map(|(_, job)| *job);
        let runs = || scheduler.unit(unit).map(|unit| (unit.first.task.index(), unit.first.index));
        self.name(known.or_else(runs)?, unit)
    }

    fn job(&self, job: JobId) -> Option<Job> {
        let (found, named) = (*self.jobs.get(job.index())?)?;
        (found == job).then_some(named)
    }

    fn name(&self, (task, job): Job, unit: UnitId) -> Option<String> {
        let (task_name, node) = (self.tasks.get(task)?, unit.node().index());
        Some(match &self.nodes {
            Some(nodes) => format!("{task_name}/{job}/{}", nodes.get(task)?.get(node)?.name),
            None => format!("{task_name}/{job}/node-{node}"),
        })
    }
}

#[cfg(test)]
mod tests;
