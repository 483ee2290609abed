//! What was asked for, released and ended, told twice: by calls and by events. Both have to agree, every release has to
//! be answered, every job that was accepted has one outcome, and floors hold back the lowest urgency.

use super::Name;
use red_core::{Instant, JobId, Outcome, ReleaseError, ShedReason};
use red_tests::model::is_violated;
use red_workload::model::Workload;
use std::collections::HashMap;

/// What became of a job.
type End = Option<ShedReason>;

struct Task {
    deadline_ns: u64,
    floor: Option<(u32, u32)>,
    /// When each job was released, and whether there was room for it.
    releases: Vec<(Instant, bool)>,
    is_removed: bool,
}

pub(super) struct Books {
    tasks: Vec<Task>,
    /// Releases that were answered, those of a task that is gone too.
    answered: u64,
    begun: u64,
    /// By events, and by outcomes.
    ends: HashMap<Name, End>,
    outcomes: HashMap<Name, End>,
}

fn ensure(holds: bool, why: impl FnOnce() -> String) -> Result<(), String> {
    if holds { Ok(()) } else { Err(why()) }
}

impl Books {
    pub(super) fn of(workload: &Workload) -> Self {
        let task = |task: &red_workload::model::Task| Task {
            deadline_ns: task.deadline_ns,
            floor: task.floor,
            releases: Vec::new(),
            is_removed: false,
        };
        let tasks = workload.tasks.iter().map(task).collect();
        Self { tasks, answered: 0, begun: 0, ends: HashMap::new(), outcomes: HashMap::new() }
    }

    /// A release was answered. Of a task that is gone it is no job.
    pub(super) fn released(&mut self, task: usize, release: Instant, taken: Result<JobId, ReleaseError>) {
        self.answered += 1;
        if !self.tasks[task].is_removed {
            self.tasks[task].releases.push((release, taken.is_ok()));
        }
    }

    pub(super) fn remove(&mut self, task: usize) {
        self.tasks[task].is_removed = true;
    }

    pub(super) fn is_removed(&self, task: usize) -> bool {
        self.tasks[task].is_removed
    }

    /// The event of a job that was accepted.
    pub(super) fn begins(&mut self, name: Name) -> Result<(), String> {
        self.begun += 1;
        ensure(self.release(name).is_some_and(|(_, taken)| taken), || "nobody released it".to_owned())
    }

    /// The event of a job that found no room.
    pub(super) fn refused(&self, name: Name) -> Result<(), String> {
        ensure(self.release(name).is_some_and(|(_, taken)| !taken), || "it was not refused".to_owned())
    }

    /// The event of a job's end.
    pub(super) fn ends(&mut self, name: Name, end: End) {
        self.ends.insert(name, end);
    }

    pub(super) fn outcome(&mut self, outcome: &Outcome) -> Result<(), String> {
        let name = (outcome.task.index(), outcome.index);
        let (release, deadline) = (outcome.release.as_nanos(), outcome.deadline.as_nanos());
        ensure(self.outcomes.insert(name, outcome.shed).is_none(), || "a second time".to_owned())?;
        ensure(self.release(name) == Some((outcome.release, true)), || {
            "it was not released then".to_owned()
        })?;
        ensure(self.times(name) == (release, deadline), || "it was due at another instant".to_owned())?;
        ensure(outcome.shed.is_some() || outcome.at >= outcome.release, || "before its release".to_owned())
    }

    /// When a job was released and due.
    pub(super) fn times(&self, name: Name) -> (u64, u64) {
        let release = self.release(name).map_or(0, |(release, _)| release.as_nanos());
        (release, release.saturating_add(self.tasks[name.0].deadline_ns))
    }

    /// At the end, `asked` releases having been asked for.
    pub(super) fn close(&self, asked: u64) -> Result<(), String> {
        ensure(self.answered == asked, || format!("of {asked} releases {} were made", self.answered))?;
        let taken =
            self.tasks.iter().flat_map(|task| &task.releases).filter(|(_, taken)| *taken).count() as u64;
        ensure(self.begun == taken, || format!("{taken} jobs were accepted, {} began", self.begun))?;
        for (name, end) in &self.ends {
            let told = self.outcomes.get(name);
            ensure(told == Some(end), || {
                format!("the outcome of {name:?} is {told:?}, it ended with {end:?}")
            })?;
        }
        ensure(self.outcomes.len() as u64 == taken, || {
            format!("{taken} jobs were accepted, {} have an outcome", self.outcomes.len())
        })?;
        for (index, task) in self.tasks.iter().enumerate() {
            // To the other reasons of overload a floor is a matter of rank.
            let held_back = |end: &End| *end == Some(ShedReason::Urgency);
            let ends = self.ends.iter().filter(|(name, end)| name.0 == index && held_back(end));
            let mut dropped: Vec<u64> = ends.map(|(name, _)| name.1).collect();
            dropped.sort_unstable();
            let holds = task.floor.is_none_or(|(m, k)| !is_violated(&dropped, m, k));
            ensure(holds, || {
                format!("task {index}: floor {:?}, given up for urgency {dropped:?}", task.floor)
            })?;
        }
        Ok(())
    }

    fn release(&self, name: Name) -> Option<(Instant, bool)> {
        self.tasks[name.0].releases.get(usize::try_from(name.1).ok()?).copied()
    }
}
