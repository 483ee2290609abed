//! What happened once, for a simulation that takes it over: when jobs were released, how long nodes executed, and which
//! failed.

use crate::world::World;
use red_workload::build::{Numbered, Role};
use red_workload::model::{Part, Stage};
use std::collections::HashMap;

/// Releases, execution times and faults of a run.
///
/// A node that the run did not execute in a job takes its mean over all jobs. An encoder that never ran, because there
/// always was a result, takes the mean of all that have its weights and frame. What is left takes its WCET, and is told.
/// A stage that ran as one node gives each part the share that it has of the WCET.
#[derive(Clone, Debug, Default)]
pub struct Past {
    tasks: Vec<PastTask>,
    /// By the names of their weights, and then of their frames.
    encoders: HashMap<String, HashMap<String, Mean>>,
    /// Releases and ends of nodes in it, at most [`Past::LARGEST`].
    kept: usize,
    is_cut: bool,
}

#[derive(Clone, Debug, Default)]
struct PastTask {
    releases: Vec<u64>,
    /// By the names of nodes as refined stages have them.
    nodes: HashMap<String, Times>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: u64,
    count: u64,
}

impl Mean {
    const fn add(&mut self, took_ns: u64) {
        self.sum = self.sum.saturating_add(took_ns);
        self.count += 1;
    }

    const fn get(self) -> Option<u64> {
        self.sum.checked_div(self.count)
    }
}

#[derive(Clone, Debug, Default)]
struct Times {
    of_job: HashMap<u64, u64>,
    mean: Mean,
    /// How long it took until a body failed, or was given up. That says nothing about other jobs.
    failed: HashMap<u64, u64>,
}

impl Past {
    /// So many releases and ends of nodes are kept: somewhat more than a gigabyte.
    pub const LARGEST: usize = 1 << 24;

    /// Nothing yet, for so many tasks.
    #[must_use]
    pub fn new(tasks: usize) -> Self {
        Self { tasks: vec![PastTask::default(); tasks], ..Self::default() }
    }

    /// Whether there was more than is kept.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        self.is_cut
    }

    /// The task, if there is room for one more of what is kept.
    fn keeps(&mut self, task: usize) -> Option<&mut PastTask> {
        self.is_cut |= self.kept == Self::LARGEST;
        if self.is_cut {
            return None;
        }
        self.kept += 1;
        self.tasks.get_mut(task)
    }

    /// The next job of a task was released then.
    pub fn released(&mut self, task: usize, at_ns: u64) {
        if let Some(task) = self.keeps(task) {
            task.releases.push(at_ns);
        }
    }

    /// A node of a job executed for so long.
    pub fn executed(&mut self, task: usize, job: u64, node: &Numbered, took_ns: u64) {
        let Some(task) = self.keeps(task) else { return };
        let mut of_encoder = None;
        match &node.role {
            Role::Coarse(stage) => {
                let parts: Vec<_> = parts(&node.name, stage).collect();
                let whole: u128 = parts.iter().map(|(_, part)| u128::from(part.wcet_ns)).sum();
                let (mut wcet, mut given) = (0, 0);
                for (name, part) in parts {
                    wcet += u128::from(part.wcet_ns);
                    // Up to the end of this part, so that nothing is lost by rounding.
                    let until =
                        (u128::from(took_ns) * wcet).checked_div(whole).unwrap_or(u128::from(took_ns));
                    let until = u64::try_from(until).unwrap_or(took_ns);
                    task.executed(name, job, until - given);
                    of_encoder.get_or_insert((&stage.weights, &stage.frame, until));
                    given = until;
                }
            }
            Role::Encoder { weights, frame, .. } => {
                task.executed(node.name.clone(), job, took_ns);
                of_encoder = Some((weights, frame, took_ns));
            }
            Role::Plain(_) | Role::Decoder { .. } => task.executed(node.name.clone(), job, took_ns),
        }
        if let Some((weights, frame, took_ns)) = of_encoder {
            let of_weights = self.encoders.entry(weights.clone()).or_default();
            of_weights.entry(frame.clone()).or_default().add(took_ns);
        }
    }

    /// A node of a job failed after so long. Of a stage that ran as one node it is the first part that fails.
    pub fn failed(&mut self, task: usize, job: u64, node: &Numbered, took_ns: u64) {
        let Some(task) = self.keeps(task) else { return };
        let name = match &node.role {
            Role::Coarse(_) => format!("{}.encoder", node.name),
            _ => node.name.clone(),
        };
        task.nodes.entry(name).or_default().failed.insert(job, took_ns);
    }
}

impl World for Past {
    /// Whether it failed, or a part of it did.
    fn fails(&self, task: usize, job: u64, node: &Numbered) -> bool {
        let Some(task) = self.tasks.get(task) else { return false };
        match &node.role {
            Role::Coarse(stage) => parts(&node.name, stage).any(|(name, _)| task.failed(&name, job)),
            _ => task.failed(&node.name, job),
        }
    }

    fn release(&self, task: usize, job: usize) -> Option<u64> {
        self.tasks.get(task)?.releases.get(job).copied()
    }

    /// What is not known is its WCET.
    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        let Some(task) = self.tasks.get(task) else { return (0, false) };
        let of_encoder = |name: &str, weights: &str, frame: &str| {
            let mean = || self.encoders.get(weights)?.get(frame)?.get();
            task.time(name, job).or_else(mean)
        };
        let or_wcet = |time: Option<u64>, part: &Part| (time.unwrap_or(part.wcet_ns), time.is_some());
        match &node.role {
            Role::Plain(part) | Role::Decoder { part, .. } => or_wcet(task.time(&node.name, job), part),
            Role::Encoder { part, weights, frame } => or_wcet(of_encoder(&node.name, weights, frame), part),
            Role::Coarse(stage) => {
                let mut whole = (0_u64, true);
                for (i, (name, part)) in parts(&node.name, stage).enumerate() {
                    let time = match i {
                        0 => of_encoder(&name, &stage.weights, &stage.frame),
                        _ => task.time(&name, job),
                    };
                    let (time, is_known) = or_wcet(time, part);
                    whole = (whole.0.saturating_add(time), whole.1 && is_known);
                    if task.failed(&name, job) {
                        break;
                    }
                }
                whole
            }
        }
    }
}

impl PastTask {
    fn executed(&mut self, node: String, job: u64, took_ns: u64) {
        let times = self.nodes.entry(node).or_default();
        if times.of_job.insert(job, took_ns).is_none() {
            times.mean.add(took_ns);
        }
    }

    fn failed(&self, node: &str, job: u64) -> bool {
        self.nodes.get(node).is_some_and(|times| times.failed.contains_key(&job))
    }

    fn time(&self, node: &str, job: u64) -> Option<u64> {
        let times = self.nodes.get(node)?;
        let of_job = times.of_job.get(&job).or_else(|| times.failed.get(&job));
        of_job.copied().or_else(|| times.mean.get())
    }
}

/// The parts of a stage by the names that they have where it is refined, its encoder first.
fn parts<'a>(name: &'a str, stage: &'a Stage) -> impl Iterator<Item = (String, &'a Part)> {
    let decoders = stage.decoders.iter().map(move |(decoder, part)| (format!("{name}.{decoder}"), part));
    [(format!("{name}.encoder"), &stage.encoder)].into_iter().chain(decoders)
}

#[cfg(test)]
mod tests;
