//! Watches a run from under the scheduler's lock, and holds every event against the graphs of the workload.
//!
//! What it holds: a node starts after its predecessors (Lemma 1), once, on a free lane; it completes where it started; a
//! job ends when all its nodes are done, or is given up, once, and nothing of it starts afterwards.

use red_core::{CommitError, Event, EventKind, Instant, Outcome, Scheduler, TaskId};
use red_record::Recorder;
use red_rt::timeline::Host;
use red_workload::build::{self, Change};
use std::collections::HashMap;

/// Capacities of a run: the limits of a workload file.
pub(crate) type Robot = red_core::Caps<16, 256, 64, 32, 32, 4, 4096>;

/// Predecessors of each node, `None` where there is no such node.
type Graph = Vec<Option<Vec<usize>>>;

/// Task, job and node.
type SubJob = (usize, u64, usize);

/// How far a node of a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Node {
    Waiting,
    Running(usize),
    Done,
}

struct Job {
    version: usize,
    nodes: HashMap<usize, Node>,
    ended: bool,
}

/// What was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) jobs: u64,
    pub(crate) given_up: u64,
    pub(crate) sub_jobs: u64,
    pub(crate) hits: u64,
    pub(crate) edits: u64,
}

pub(crate) struct Judge {
    tasks: Vec<TaskId>,
    /// Graphs of each task, oldest first.
    graphs: Vec<Vec<Graph>>,
    /// How many edits of each task were applied.
    versions: Vec<usize>,
    jobs: HashMap<(usize, u64), Job>,
    /// When the unit on each lane started, and its members.
    lanes: Vec<(Instant, Vec<SubJob>)>,
    changes: Vec<Option<Change>>,
    now: Instant,
    pub(crate) seen: Seen,
    /// The first thing that should not have happened.
    pub(crate) wrong: Option<String>,
}

impl Judge {
    /// For a workload that was built into `plan`. `scheduler` has its tasks, and is used up to find the graphs.
    pub(crate) fn new(
        mut scheduler: Box<Scheduler<Robot>>,
        plan: &build::Plan<Robot>,
        tasks: &[TaskId],
        lanes: usize,
    ) -> Self {
        let mut graphs: Vec<Vec<Graph>> = tasks.iter().map(|task| vec![graph(&scheduler, *task)]).collect();
        for change in &plan.changes {
            let task = tasks[change.task];
            let applied = build::apply(&mut scheduler, change, task, Instant::ZERO);
            assert_eq!(applied, Ok(()), "a checked change applies to a task without jobs");
            graphs[change.task].push(graph(&scheduler, task));
        }
        Self {
            tasks: tasks.to_vec(),
            versions: vec![0; graphs.len()],
            graphs,
            jobs: HashMap::new(),
            lanes: vec![(Instant::ZERO, Vec::new()); lanes],
            changes: plan.changes.iter().cloned().map(Some).collect(),
            now: Instant::ZERO,
            seen: Seen::default(),
            wrong: None,
        }
    }

    /// After the run, all jobs having ended: whether each one did.
    pub(crate) fn none_forgotten(&mut self) {
        let open = self.jobs.iter().find(|(_, job)| !job.ended).map(|(name, _)| *name);
        if let Some(name) = open {
            self.blame(format!("{name:?} was released and neither ended nor was given up"));
        }
    }

    fn blame(&mut self, what: String) {
        self.wrong.get_or_insert(what);
    }

    fn started(&mut self, event: &Event) -> Result<(), String> {
        let name = (event.task.index(), event.job);
        let (node, lane) = (event.node.index(), event.lane.index());
        self.expect_predecessors(name, node)?;
        // Members whose jobs were given up meanwhile are reported as late, which is no event.
        let jobs = &self.jobs;
        let (since, members) = self.lanes.get_mut(lane).ok_or("there is no such lane")?;
        members.retain(|(task, job, _)| jobs.get(&(*task, *job)).is_some_and(|job| !job.ended));
        if !members.is_empty() && *since != event.at {
            return Err(format!("lane {lane} still runs {members:?}"));
        }
        *since = event.at;
        members.push((name.0, name.1, node));
        self.seen.sub_jobs += 1;
        self.set(name, node, Node::Running(lane));
        Ok(())
    }

    fn completed(&mut self, event: &Event) -> Result<(), String> {
        let name = (event.task.index(), event.job);
        let (node, lane) = (event.node.index(), event.lane.index());
        let job = self.jobs.get(&name).ok_or("no such job")?;
        if job.nodes.get(&node) != Some(&Node::Running(lane)) {
            return Err(format!("it was {:?} and not running on lane {lane}", job.nodes.get(&node)));
        }
        let (_, members) = self.lanes.get_mut(lane).ok_or("there is no such lane")?;
        members.retain(|member| *member != (name.0, name.1, node));
        self.set(name, node, Node::Done);
        Ok(())
    }

    /// The node has not begun, its job is in flight, and all its predecessors are done.
    fn expect_predecessors(&self, name: (usize, u64), node: usize) -> Result<(), String> {
        let job = self.jobs.get(&name).ok_or("no such job")?;
        if job.ended {
            return Err("its job has ended".to_owned());
        }
        match job.nodes.get(&node) {
            Some(Node::Waiting) => {}
            Some(other) => return Err(format!("a second time: it was {other:?}")),
            None => return Err(format!("the job's graph, version {}, has no such node", job.version)),
        }
        let predecessors = self.graphs[name.0][job.version][node].iter().flatten();
        let open = predecessors.copied().find(|p| job.nodes.get(p) != Some(&Node::Done));
        open.map_or(Ok(()), |open| Err(format!("before its predecessor {open}")))
    }

    fn set(&mut self, name: (usize, u64), node: usize, to: Node) {
        if let Some(place) = self.jobs.get_mut(&name).and_then(|job| job.nodes.get_mut(&node)) {
            *place = to;
        }
    }

    fn close(&mut self, name: (usize, u64), whole: bool) -> Result<(), String> {
        let job = self.jobs.get_mut(&name).ok_or("no such job")?;
        if std::mem::replace(&mut job.ended, true) {
            return Err("a second time".to_owned());
        }
        match job.nodes.iter().find(|(_, state)| **state != Node::Done) {
            Some((node, state)) if whole => Err(format!("with node {node} {state:?}")),
            _ => Ok(()),
        }
    }
}

fn graph(scheduler: &Scheduler<Robot>, task: TaskId) -> Graph {
    let dag = scheduler.edit(task).expect("the task is there");
    let mut graph: Graph = vec![None; 256];
    for node in dag.nodes() {
        graph[node.index()].get_or_insert_default();
        for successor in dag.successors(node).iter() {
            graph[successor].get_or_insert_default().push(node.index());
        }
    }
    graph
}

impl Host<Robot> for Judge {
    fn next_at(&self) -> Option<u64> {
        let later = self.changes.iter().flatten().map(|change| change.at).filter(|at| *at > self.now);
        later.min().map(Instant::as_nanos)
    }

    fn due(&mut self, scheduler: &mut Recorder<'_, Robot>, now: Instant) {
        if now < self.now {
            self.blame(format!("time went from {:?} back to {now:?}", self.now));
        }
        self.now = now;
        let mut held = [false; 16];
        for (number, place) in (0..).zip(&mut self.changes) {
            let Some(change) = place.as_ref().filter(|change| change.at <= now) else { continue };
            if held[change.task] {
                continue;
            }
            let task = self.tasks[change.task];
            let apply = |scheduler: &mut Scheduler<Robot>| build::apply(scheduler, change, task, now);
            match scheduler.edit(number, now, apply) {
                Ok(()) => *place = None,
                Err(CommitError::Busy) => held[change.task] = true,
                Err(error) => {
                    self.wrong.get_or_insert(format!("edit {number} is refused: {error}"));
                    *place = None;
                }
            }
        }
    }

    fn released(&mut self, _task: usize, _release: Instant, _taken: bool) {}

    fn ended(&mut self, outcome: &Outcome) {
        if outcome.shed.is_none() && outcome.at < outcome.release {
            self.blame(format!("ended before its release: {outcome:?}"));
        }
    }

    fn event(&mut self, event: &Event) {
        let (task, job) = (event.task.index(), event.job);
        let found = match event.kind {
            EventKind::Released => {
                let version = self.versions[task];
                let nodes = self.graphs[task][version].iter().enumerate();
                let nodes = nodes.filter_map(|(node, there)| there.as_ref().map(|_| (node, Node::Waiting)));
                let new = Job { version, nodes: nodes.collect(), ended: false };
                self.seen.jobs += 1;
                let twice = self.jobs.insert((task, job), new).is_some();
                if twice { Err("a second time".to_owned()) } else { Ok(()) }
            }
            EventKind::Started => self.started(event),
            EventKind::Completed => self.completed(event),
            EventKind::Hit => {
                self.seen.hits += 1;
                let ready = self.expect_predecessors((task, job), event.node.index());
                self.set((task, job), event.node.index(), Node::Done);
                ready
            }
            EventKind::Ended => self.close((task, job), true),
            EventKind::Shed(_) => {
                self.seen.given_up += 1;
                self.close((task, job), false)
            }
            EventKind::Edited => {
                self.versions[task] += 1;
                self.seen.edits += 1;
                Ok(())
            }
            EventKind::Evicted | EventKind::Preempted => Err("nobody asked for that".to_owned()),
            _ => Ok(()),
        };
        if let Err(why) = found {
            self.blame(format!("{:?} of task {task} job {job} {:?}: {why}", event.kind, event.node));
        }
    }
}

#[cfg(test)]
mod tests;
