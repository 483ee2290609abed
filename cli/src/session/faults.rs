//! Which bodies failed in a run, and how that is told: they are noted under real time, and worded after it.

use red_bodies::BodyError;
use red_core::{Event, EventKind, ShedReason};
use red_cuda::CudaError;
use red_rt::panics::BodyPanic;
use red_rt::report::{RunReport, StreamHang};
use red_workload::build::{Numbered, Role};
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

/// What tasks and their nodes are called.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Names<'a> {
    pub(crate) tasks: &'a [String],
    pub(crate) nodes: &'a [Vec<Numbered>],
}

impl Names<'_> {
    fn of(&self, task: usize, node: usize) -> String {
        format!("`{}.{}`", self.tasks[task], self.nodes[task][node].name)
    }

    /// The pool whose lanes run a node.
    fn pool(&self, task: usize, node: usize) -> usize {
        match &self.nodes[task][node].role {
            Role::Plain(part) | Role::Encoder { part, .. } | Role::Decoder { part, .. } => part.pool,
            Role::Coarse(stage) => stage.encoder.pool,
        }
    }
}

/// What a run says of its lanes.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Happened<'a> {
    panics: &'a [BodyPanic],
    /// Bodies and units of streams that ran past their bounds, and the latter alone.
    hung: u64,
    stream_hangs: &'a [StreamHang],
    /// A bit each.
    pools_lost: u32,
}

impl<'a> From<&'a RunReport> for Happened<'a> {
    fn from(run: &'a RunReport) -> Self {
        let RunReport { panics, hung, stream_hangs, pools_lost, .. } = run;
        Self { panics, hung: *hung, stream_hangs, pools_lost: *pools_lost }
    }
}

/// A unit that did not come to its end on its stream.
pub(crate) fn of_stream(names: &Names<'_>, lanes: &[String], hang: &StreamHang) -> String {
    let StreamHang { lane, task, node, job } = *hang;
    format!(
        "job {job}: node {} did not come to its end on its stream within 10 times its WCET and 100 ms; {} is left; mend the \
         kernel",
        names.of(task, node.index()),
        lanes[lane]
    )
}

/// Jobs that were given up because a body of theirs failed.
#[derive(Debug)]
pub(crate) struct Faults {
    /// What each lane runs: task, job, node.
    running: Vec<Option<(usize, u64, usize)>>,
    /// Task and job, and the nodes of which one is at fault.
    jobs: Vec<(usize, u64, [Option<usize>; 2])>,
    /// Jobs of which nothing ran: what was to be submitted failed, or their pool is lost.
    idle: Vec<(usize, u64)>,
    more: u64,
}

impl Faults {
    /// None yet.
    pub(crate) fn new(lanes: usize) -> Self {
        let (jobs, idle) = (Vec::with_capacity(MOST), Vec::with_capacity(MOST));
        Self { running: vec![None; lanes], jobs, idle, more: 0 }
    }

    /// Follows the record.
    pub(crate) fn event(&mut self, event: &Event) {
        let (task, job) = (event.task.index(), event.job);
        match event.kind {
            EventKind::Started => self.run(event, Some((task, job, event.node.index()))),
            EventKind::Completed => self.run(event, None),
            EventKind::Shed(ShedReason::Fault) => {
                let ran = self.running.iter().flatten().filter(|(t, j, _)| (*t, *j) == (task, job));
                let mut nodes = ran.map(|(_, _, node)| *node);
                match [nodes.next(), nodes.next()] {
                    [None, _] if self.idle.len() < self.idle.capacity() => self.idle.push((task, job)),
                    ran @ [Some(_), _] if self.jobs.len() < self.jobs.capacity() => {
                        self.jobs.push((task, job, ran));
                    }
                    _ => self.more += 1,
                }
            }
            _ => {}
        }
    }

    fn run(&mut self, event: &Event, what: Option<(usize, u64, usize)>) {
        if let Some(lane) = self.running.get_mut(event.lane.index()) {
            *lane = what;
        }
    }

    /// One line for each.
    pub(crate) fn words(&self, names: &Names<'_>, said: &[Said], run: &Happened<'_>) -> Vec<String> {
        let panicked = |panic: &BodyPanic| {
            let message = panic.message.escape_debug();
            format!(
                "job {}: node {} panicked: {message}",
                panic.job,
                names.of(panic.task, panic.node.index())
            )
        };
        let panic_of =
            |task: usize, job: u64| run.panics.iter().find(|panic| (panic.task, panic.job) == (task, job));
        let told = |task: usize, job: u64| {
            let error_of = || said.iter().find(|(t, j, ..)| (*t, *j) == (task, job));
            panic_of(task, job).map(panicked).or_else(|| {
                let (_, _, node, error) = error_of()?;
                Some(format!("job {job}: node {}: {}", names.of(task, *node), error.told()))
            })
        };
        let is_lost = |task: usize, node: usize| run.pools_lost >> names.pool(task, node) & 1 != 0;
        // What ran on a device that is lost ended with it; and a stream that hangs is told by itself.
        let with_device = |task: usize, job: u64, ran: &[Option<usize>; 2]| {
            let hangs = run.stream_hangs.iter().any(|hang| (hang.task, hang.job) == (task, job));
            hangs || ran.iter().flatten().any(|node| is_lost(task, *node))
        };
        let silent = |(t, j, ran): &&(usize, u64, _)| told(*t, *j).is_none() && !with_device(*t, *j, ran);
        // A lane that is lost takes the words of its panics along.
        let hung = run.hung.saturating_sub(run.stream_hangs.len() as u64);
        let how = match hung {
            0 => "panicked",
            hung if self.jobs.iter().filter(silent).count() as u64 <= hung => {
                "did not return within its bound"
            }
            _ => "panicked or did not return within its bound",
        };
        let mut ended_with_device = 0;
        let mut words = Vec::new();
        for (task, job, ran) in &self.jobs {
            let nodes: Vec<String> = ran.iter().flatten().map(|node| names.of(*task, *node)).collect();
            let nodes = nodes.join(" or ");
            if let Some(told) = told(*task, *job) {
                words.push(told);
            } else if with_device(*task, *job, ran) {
                ended_with_device += 1;
            } else {
                words.push(format!("job {job}: the body of node {nodes} {how}; mend the body"));
            }
        }
        for (task, job) in &self.idle {
            match told(*task, *job) {
                Some(told) => words.push(told),
                None => ended_with_device += 1,
            }
        }
        if ended_with_device > 0 && run.pools_lost != 0 {
            words.push(format!(
                "{} jobs that needed what was lost were given up",
                ended_with_device + self.more
            ));
        } else if self.more > 0 {
            words.push(format!("{} more jobs failed", self.more));
        } else {
            // In jobs that had been given up for another reason.
            let untold = |panic: &&BodyPanic| {
                let known =
                    self.jobs.iter().map(|(task, job, _)| (*task, *job)).chain(self.idle.iter().copied());
                known.into_iter().all(|job| job != (panic.task, panic.job))
            };
            words.extend(run.panics.iter().filter(untold).map(panicked));
        }
        words
    }
}

#[cfg(test)]
mod tests;
