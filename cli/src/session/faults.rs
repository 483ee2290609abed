//! Which bodies failed in a run, and how that is told: they are noted under real time, and worded after it.

use red_bodies::BodyError;
use red_core::{Event, EventKind, ShedReason};
use red_cuda::CudaError;
use red_rt::panics::BodyPanic;
use red_workload::build::Numbered;
use red_workload::{shown, shown_path};

/// Faults that are told one by one.
const MOST: usize = 8;

/// An error of a body: its task, job and node, and what it said.
pub(crate) type Said = (usize, u64, usize, Fault);

/// What was wrong.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The body said it.
    Body(BodyError),
    /// The CUDA driver did.
    Device(CudaError),
}

impl Fault {
    /// In words.
    pub(crate) fn told(&self) -> String {
        match self {
            Self::Body(error) => error.told(shown, shown_path),
            Self::Device(error) => error.to_string(),
        }
    }
}

impl From<BodyError> for Fault {
    fn from(error: BodyError) -> Self {
        Self::Body(error)
    }
}

impl From<CudaError> for Fault {
    fn from(error: CudaError) -> Self {
        Self::Device(error)
    }
}

/// A table of errors that takes no memory while lanes run.
pub(crate) fn table() -> Vec<Said> {
    Vec::with_capacity(MOST)
}

/// Notes an error where there is room; the first ones tell most.
pub(crate) fn say(table: &mut Vec<Said>, said: Said) {
    if table.len() < table.capacity() {
        table.push(said);
    }
}

/// Jobs that were given up because a body of theirs failed.
#[derive(Debug)]
pub(crate) struct Faults {
    /// What each lane runs: task, job, node.
    running: Vec<Option<(usize, u64, usize)>>,
    /// Task and job, and the nodes of which one is at fault.
    jobs: Vec<(usize, u64, [Option<usize>; 2])>,
    more: u64,
}

impl Faults {
    /// None yet.
    pub(crate) fn new(lanes: usize) -> Self {
        Self { running: vec![None; lanes], jobs: Vec::with_capacity(MOST), more: 0 }
    }

    /// Follows the record.
    pub(crate) fn event(&mut self, event: &Event) {
        let (task, job) = (event.task.index(), event.job);
        match event.kind {
            EventKind::Started => self.run(event, Some((task, job, event.node.index()))),
            EventKind::Completed => self.run(event, None),
            EventKind::Shed(ShedReason::Fault) if self.jobs.len() < self.jobs.capacity() => {
                let ran = self.running.iter().flatten().filter(|(t, j, _)| (*t, *j) == (task, job));
                let mut nodes = ran.map(|(_, _, node)| *node);
                self.jobs.push((task, job, [nodes.next(), nodes.next()]));
            }
            EventKind::Shed(ShedReason::Fault) => self.more += 1,
            _ => {}
        }
    }

    fn run(&mut self, event: &Event, what: Option<(usize, u64, usize)>) {
        if let Some(lane) = self.running.get_mut(event.lane.index()) {
            *lane = what;
        }
    }

    /// One line for each. `hung` is how many bodies the watchdog gave up.
    pub(crate) fn words(
        &self,
        tasks: &[String],
        nodes: &[Vec<Numbered>],
        said: &[Said],
        panics: &[BodyPanic],
        hung: u64,
    ) -> Vec<String> {
        let panicked = |panic: &BodyPanic| {
            let node = &nodes[panic.task][panic.node.index()].name;
            let message = panic.message.escape_debug();
            format!("job {}: node `{}.{node}` panicked: {message}", panic.job, tasks[panic.task])
        };
        let panic_of =
            |task: usize, job: u64| panics.iter().find(|panic| (panic.task, panic.job) == (task, job));
        let error_of = |task: usize, job: u64| said.iter().find(|(t, j, ..)| (*t, *j) == (task, job));
        let silent = |(t, j, _): &&(usize, u64, _)| panic_of(*t, *j).is_none() && error_of(*t, *j).is_none();
        // A lane that is lost takes the words of its panics along.
        let how = match hung {
            0 => "panicked",
            hung if self.jobs.iter().filter(silent).count() as u64 <= hung => {
                "did not return within its bound"
            }
            _ => "panicked or did not return within its bound",
        };
        let of_job = |(task, job, ran): &(usize, u64, [Option<usize>; 2])| {
            let name = |node: usize| format!("`{}.{}`", tasks[*task], nodes[*task][node].name);
            if let Some(panic) = panic_of(*task, *job) {
                return panicked(panic);
            }
            if let Some((_, _, node, error)) = error_of(*task, *job) {
                let error = error.told();
                return format!("job {job}: node {}: {error}", name(*node));
            }
            let nodes: Vec<String> = ran.iter().flatten().map(|node| name(*node)).collect();
            let nodes = nodes.join(" or ");
            format!("job {job}: the body of node {nodes} {how}; mend the body")
        };
        let mut words: Vec<String> = self.jobs.iter().map(of_job).collect();
        if self.more > 0 {
            words.push(format!("{} more jobs failed", self.more));
        } else {
            // In jobs that had been given up for another reason.
            let untold =
                |panic: &&BodyPanic| self.jobs.iter().all(|(t, j, _)| (*t, *j) != (panic.task, panic.job));
            words.extend(panics.iter().filter(untold).map(panicked));
        }
        words
    }
}

#[cfg(test)]
mod tests;
