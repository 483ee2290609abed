//! Watches a run from under the scheduler's lock, and holds every event against the graphs of the workload.
//!
//! What it holds: a node starts after its predecessors (Lemma 1), once, on a free lane of its pool, in the order of keys
//! where the policy keeps them; it completes where it started; a job ends when all its nodes are done, or is given up,
//! once, and nothing of it starts afterwards. What the books hold is in `books.rs`.

mod books;
mod order;

use crate::counts::{Count, Counts};
use books::Books;
use order::{Graph, Rule, facts};
use red_core::{CommitError, Event, EventKind, Instant, JobId, Outcome, ReleaseError, Scheduler, TaskId};
use red_record::Recorder;
use red_rt::timeline::Host;
use red_workload::build::{self, Change};
use red_workload::model::Workload;
use red_workload::policy::Policy;
use std::collections::HashMap;

/// Capacities of a run: the limits of a workload file.
pub(crate) type Robot = red_core::Caps<16, 256, 64, 32, 32, 4, 4096>;

/// A job by its task and its number.
type Name = (usize, u64);

/// How far a node of a job is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Node {
    Waiting,
    Running(usize),
    Done,
}

/// A job in flight.
struct Job {
    version: usize,
    /// By number, `None` where the job's graph has no such node.
    nodes: Vec<Option<Node>>,
}

impl Job {
    fn is_done(&self, node: usize) -> bool {
        self.nodes.get(node) == Some(&Some(Node::Done))
    }
}

/// A lane and the unit that runs on it.
struct Lane {
    pool: usize,
    since: Instant,
    members: Vec<(Name, usize)>,
}

pub(crate) struct Judge {
    tasks: Vec<TaskId>,
    /// Graphs of each task, oldest first.
    graphs: Vec<Vec<Graph>>,
    /// How many edits of each task were applied.
    versions: Vec<usize>,
    rule: Rule,
    jobs: HashMap<Name, Job>,
    books: Books,
    lanes: Vec<Lane>,
    changes: Vec<Edit>,
    /// The task that goes, and when.
    removal: Option<(usize, Instant)>,
    now: Instant,
    /// A start is told twice: for the tests of who judges.
    pub(crate) planted: bool,
    pub(crate) counts: Counts,
    /// The first thing that should not have happened.
    pub(crate) wrong: Option<String>,
}

/// An edit on its way.
enum Edit {
    Ahead(Change),
    /// Made, and to be tried once more: its nodes are there, so that it has to be refused.
    Again(Change),
    Over,
}

impl Judge {
    /// For a workload that was built into `plan`. `scheduler` has its tasks, and is used up to find the graphs.
    pub(crate) fn new(
        mut scheduler: Box<Scheduler<Robot>>,
        workload: &Workload,
        plan: &build::Plan<Robot>,
        tasks: &[TaskId],
        policy: Policy,
    ) -> Self {
        let mut graphs: Vec<Vec<Graph>> = tasks.iter().map(|task| vec![facts(&scheduler, *task)]).collect();
        for change in &plan.changes {
            let task = tasks[change.task];
            let applied = build::apply(&mut scheduler, change, task, Instant::ZERO);
            assert_eq!(applied, Ok(()), "a checked change applies to a task without jobs");
            graphs[change.task].push(facts(&scheduler, task));
        }
        let pools = workload.pools.iter().enumerate();
        let pools = pools.flat_map(|(pool, of)| (0..of.lanes).map(move |_| pool));
        let lane = |pool| Lane { pool, since: Instant::ZERO, members: Vec::new() };
        Self {
            tasks: tasks.to_vec(),
            versions: vec![0; graphs.len()],
            graphs,
            rule: Rule::of(policy),
            jobs: HashMap::new(),
            books: Books::of(workload),
            lanes: pools.map(lane).collect(),
            changes: plan.changes.iter().cloned().map(Edit::Ahead).collect(),
            removal: None,
            now: Instant::ZERO,
            planted: false,
            counts: Counts::default(),
            wrong: None,
        }
    }

    /// The task goes at this instant, with the jobs that it has then.
    pub(crate) fn remove(&mut self, task: usize, at_ns: u64) {
        self.removal = Some((task, Instant::from_nanos(at_ns)));
    }

    /// After the run, all jobs having ended: whether each one did, and whether each of the `asked` releases was made.
    pub(crate) fn none_forgotten(&mut self, asked: u64) {
        let open = self.jobs.keys().next().map(|name| format!("{name:?} neither ended nor was given up"));
        let wrong = open.map_or_else(|| self.books.close(asked), Err);
        wrong.unwrap_or_else(|why| self.blame(why));
    }

    fn blame(&mut self, what: String) {
        self.wrong.get_or_insert(what);
    }

    fn released(&mut self, name: Name) -> Result<(), String> {
        let version = self.versions[name.0];
        let nodes = self.graphs[name.0][version].iter().map(|there| there.as_ref().map(|_| Node::Waiting));
        let new = Job { version, nodes: nodes.collect() };
        self.counts[Count::Released] += 1;
        self.books.begins(name)?;
        let twice = self.jobs.insert(name, new).is_some();
        if twice { Err("a second time".to_owned()) } else { Ok(()) }
    }

    fn started(&mut self, event: &Event) -> Result<(), String> {
        let name = (event.task.index(), event.job);
        let (node, lane) = (event.node.index(), event.lane.index());
        self.expect_predecessors(name, node)?;
        self.expect_order(name, node)?;
        // Members whose jobs were given up meanwhile are reported as late, which is no event.
        let pool = self.graphs[name.0][self.jobs[&name].version][node].as_ref().map(|facts| facts.pool);
        let jobs = &self.jobs;
        let on = self.lanes.get_mut(lane).ok_or("there is no such lane")?;
        on.members.retain(|(name, _)| jobs.contains_key(name));
        if !on.members.is_empty() && on.since != event.at {
            return Err(format!("lane {lane} still runs {:?}", on.members));
        }
        if pool != Some(on.pool) {
            return Err(format!("on lane {lane} of another pool"));
        }
        on.since = event.at;
        on.members.push((name, node));
        self.counts[Count::SubJobs] += 1;
        self.set(name, node, Node::Running(lane));
        Ok(())
    }

    fn completed(&mut self, event: &Event) -> Result<(), String> {
        let name = (event.task.index(), event.job);
        let (node, lane) = (event.node.index(), event.lane.index());
        let job = self.jobs.get(&name).ok_or("no such job")?;
        let state = job.nodes.get(node).copied().flatten();
        if state != Some(Node::Running(lane)) {
            return Err(format!("it was {state:?} and not running on lane {lane}"));
        }
        let on = self.lanes.get_mut(lane).ok_or("there is no such lane")?;
        on.members.retain(|member| *member != (name, node));
        self.set(name, node, Node::Done);
        Ok(())
    }

    /// The node has not begun, its job is in flight, and all its predecessors are done.
    fn expect_predecessors(&self, name: Name, node: usize) -> Result<(), String> {
        let job = self.jobs.get(&name).ok_or("its job is not in flight")?;
        match job.nodes.get(node).copied().flatten() {
            Some(Node::Waiting) => {}
            Some(other) => return Err(format!("a second time: it was {other:?}")),
            None => return Err(format!("the job's graph, version {}, has no such node", job.version)),
        }
        let predecessors =
            self.graphs[name.0][job.version][node].iter().flat_map(|facts| &facts.predecessors);
        let open = predecessors.copied().find(|p| !job.is_done(*p));
        open.map_or(Ok(()), |open| Err(format!("before its predecessor {open}")))
    }

    fn set(&mut self, name: Name, node: usize, to: Node) {
        if let Some(place) = self.jobs.get_mut(&name).and_then(|job| job.nodes.get_mut(node)) {
            *place = Some(to);
        }
    }

    fn close(&mut self, event: &Event) -> Result<(), String> {
        let name = (event.task.index(), event.job);
        let job = self.jobs.remove(&name).ok_or("it is not in flight")?;
        let reason = if let EventKind::Shed(reason) = event.kind { Some(reason) } else { None };
        self.books.ends(name, reason);
        match job.nodes.iter().position(|state| state.is_some_and(|state| state != Node::Done)) {
            Some(node) if reason.is_none() => Err(format!("with node {node} {:?}", job.nodes[node])),
            _ => Ok(()),
        }
    }

    /// Removes the task whose time has come.
    fn remove_due(&mut self, scheduler: &mut Recorder<'_, Robot>, now: Instant) {
        let Some((task, _)) = self.removal.filter(|(_, at)| *at <= now) else { return };
        self.removal = None;
        self.books.remove(task);
        self.counts[Count::Removed] += u64::from(self.jobs.keys().any(|name| name.0 == task));
        if !scheduler.remove_task(self.tasks[task], now) {
            self.blame(format!("task {task} was not there to be removed"));
        }
    }

    /// Makes an edit, or has it refused; what becomes of it then, `None` if it has to wait.
    fn make(
        &mut self,
        scheduler: &mut Recorder<'_, Robot>,
        number: u32,
        edit: &Edit,
        now: Instant,
    ) -> Option<Edit> {
        let (Edit::Ahead(change) | Edit::Again(change)) = edit else { return None };
        let task = self.tasks[change.task];
        let apply = |scheduler: &mut Scheduler<Robot>| build::apply(scheduler, change, task, now);
        let answer = scheduler.edit(number, now, apply);
        let is_gone = self.books.is_removed(change.task);
        match (edit, answer) {
            (Edit::Ahead(_), Ok(())) if !is_gone => {
                let adds = change.steps.iter().any(|step| !step.added.is_empty());
                return Some(if adds { Edit::Again(change.clone()) } else { Edit::Over });
            }
            (Edit::Ahead(_), Err(CommitError::Busy)) if !is_gone => {
                self.counts[Count::EditsBusy] += 1;
                return None;
            }
            (_, Err(CommitError::UnknownTask)) if is_gone => self.counts[Count::EditsRefused] += 1,
            (Edit::Again(_), Err(CommitError::Conflict)) if !is_gone => self.counts[Count::EditsRefused] += 1,
            (_, other) => {
                let again = if matches!(edit, Edit::Again(_)) { ", made before," } else { "" };
                self.blame(format!("edit {number}{again} is answered with {other:?}"));
            }
        }
        Some(Edit::Over)
    }
}

impl Host<Robot> for Judge {
    fn next_at(&self) -> Option<u64> {
        let edits = self.changes.iter().filter_map(|edit| match edit {
            Edit::Ahead(change) => Some(change.at),
            Edit::Again(_) | Edit::Over => None,
        });
        let all = edits.chain(self.removal.map(|(_, at)| at));
        all.filter(|at| *at > self.now).min().map(Instant::as_nanos)
    }

    fn due(&mut self, scheduler: &mut Recorder<'_, Robot>, now: Instant) {
        if now < self.now {
            self.blame(format!("time went from {:?} back to {now:?}", self.now));
        }
        self.now = now;
        self.remove_due(scheduler, now);
        let mut held = [false; 16];
        for number in 0..self.changes.len() {
            let task = match &self.changes[number] {
                Edit::Ahead(change) if change.at <= now => change.task,
                Edit::Again(change) => change.task,
                Edit::Ahead(_) | Edit::Over => continue,
            };
            if held[task] {
                continue;
            }
            let edit = std::mem::replace(&mut self.changes[number], Edit::Over);
            match self.make(scheduler, number as u32, &edit, now) {
                Some(next) => self.changes[number] = next,
                None => {
                    held[task] = true;
                    self.changes[number] = edit;
                }
            }
        }
    }

    fn released(&mut self, task: usize, release: Instant, taken: Result<JobId, ReleaseError>) {
        self.books.released(task, release, taken);
    }

    fn ended(&mut self, outcome: &Outcome) {
        self.books.outcome(outcome).unwrap_or_else(|why| self.blame(format!("{outcome:?}: {why}")));
    }

    fn event(&mut self, event: &Event) {
        let name = (event.task.index(), event.job);
        let found = match event.kind {
            EventKind::Released => self.released(name),
            EventKind::Refused => {
                self.counts[Count::Refused] += 1;
                self.books.refused(name)
            }
            EventKind::Started if std::mem::take(&mut self.planted) => {
                self.started(event).and_then(|()| self.started(event))
            }
            EventKind::Started => self.started(event),
            EventKind::Completed => self.completed(event),
            EventKind::Hit => {
                self.counts[Count::Hits] += 1;
                let ready = self.expect_predecessors(name, event.node.index());
                self.set(name, event.node.index(), Node::Done);
                ready
            }
            EventKind::Ended => self.close(event),
            EventKind::Shed(_) => {
                self.counts[Count::GivenUp] += 1;
                self.close(event)
            }
            EventKind::Edited => {
                self.versions[name.0] += 1;
                self.counts[Count::EditsMade] += 1;
                let known = self.versions[name.0] < self.graphs[name.0].len();
                if known { Ok(()) } else { Err("once more than there are edits".to_owned()) }
            }
            EventKind::Evicted | EventKind::Preempted => Err("nobody asked for that".to_owned()),
            _ => Ok(()),
        };
        if let Err(why) = found {
            self.blame(format!("{:?} of task {} job {} {:?}: {why}", event.kind, name.0, name.1, event.node));
        }
    }
}

#[cfg(test)]
mod tests;
