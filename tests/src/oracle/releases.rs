//! Releases and graph edits.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::rc::Rc;

use red_workload::model::{Arrival, Event, Node, Task};

use super::band;
use super::job::{self, Job, State};
use super::{JOBS_IN_FLIGHT, Policy, Reason, Sim, WINDOW, keys};
use crate::graph::{Graph, edited};

/// The graph versions of a task and its next release.
pub(super) struct TaskState {
    nodes: Vec<Node>,
    pub(super) graph: Rc<Graph>,
    /// Counts the edits applied so far.
    version: usize,
    /// Edits that wait until the older version has no job left.
    pending: Vec<Vec<Event>>,
    /// Events of this task before this instant, and at it, have been taken.
    taken: Option<u64>,
    released: u64,
    /// Of each node of the newest graph by name: the version that it came with, and how often it executed alone.
    executions: BTreeMap<String, (usize, u32)>,
}

impl TaskState {
    pub(super) fn new(task: &Task, policy: Policy) -> Self {
        let graph = Rc::new(Graph::of(&task.nodes, policy.refines()));
        let mut new = Self {
            nodes: task.nodes.clone(),
            graph,
            version: 0,
            pending: Vec::new(),
            taken: None,
            released: 0,
            executions: BTreeMap::new(),
        };
        new.count_new_ones();
        new
    }

    fn count_new_ones(&mut self) {
        for node in &self.graph.nodes {
            self.executions.entry(node.name.clone()).or_insert((self.version, 0));
        }
    }

    /// A node of a version of the graph executed alone.
    pub(super) fn executed(&mut self, version: usize, node: &str) {
        if let Some((_, count)) = self.executions.get_mut(node).filter(|(since, _)| version >= *since) {
            *count += 1;
        }
    }

    /// Whether each node of the newest graph has executed alone often enough to tell how long it takes.
    pub(super) fn is_known(&self) -> bool {
        self.executions.values().all(|&(_, count)| count >= WINDOW)
    }
}

impl Sim<'_> {
    /// When the task releases next.
    pub(super) fn next_release(&self, task: usize) -> Option<u64> {
        let index = self.tasks[task].released;
        let gap = if index == 0 { 0 } else { self.gap(task)? };
        index.checked_mul(gap)?.checked_add(self.workload.tasks[task].offset_ns)
    }

    /// From one release of a task to the next, if there is more than one.
    pub(super) fn gap(&self, task: usize) -> Option<u64> {
        match self.workload.tasks[task].arrival {
            Arrival::Periodic { period_ns } => Some(period_ns),
            Arrival::Sporadic { min_interarrival_ns } => Some(min_interarrival_ns),
            Arrival::Once => None,
        }
    }

    /// When the next job of a task that has released one is due for release, and its graph as things are.
    pub(super) fn expected_release(&self, task: usize) -> Option<(u64, Rc<Graph>)> {
        let state = &self.tasks[task];
        let at = self.next_release(task).filter(|_| state.released > 0)?;
        Some((at, Rc::clone(&state.graph)))
    }

    /// Index of the next job of a task.
    pub(super) fn next_index(&self, task: usize) -> u64 {
        self.tasks[task].released
    }

    /// Takes the events of this instant and applies what need not wait: a task holds two versions. Whether any was applied.
    pub(super) fn edit(&mut self, now: u64) -> bool {
        let mut any = false;
        for task in 0..self.tasks.len() {
            let state = &mut self.tasks[task];
            if state.taken.is_none_or(|taken| taken < now) {
                let events = self.workload.events.iter();
                let due: Vec<Event> =
                    events.filter(|event| event.task == task && event.at_ns == now).cloned().collect();
                if !due.is_empty() {
                    state.pending.push(due);
                }
                state.taken = Some(now);
            }
            while !self.tasks[task].pending.is_empty() && !self.older_version_has_jobs(task) {
                let state = &mut self.tasks[task];
                let events = state.pending.remove(0);
                state.nodes = edited(&state.nodes, &events.iter().collect::<Vec<_>>());
                state.graph = Rc::new(Graph::of(&state.nodes, self.policy.refines()));
                state.version += 1;
                let gone = |name: &str| {
                    let node = name.split_once('.').map_or(name, |(node, _)| node);
                    events.iter().any(|event| event.remove.iter().any(|removed| removed == node))
                };
                state.executions.retain(|name, _| !gone(name));
                state.count_new_ones();
                any = true;
            }
        }
        any
    }

    fn older_version_has_jobs(&self, task: usize) -> bool {
        self.jobs.iter().any(|job| job.task == task && job.version != self.tasks[task].version)
    }

    /// Releases the jobs of this instant, tasks in file order. Whether any was accepted.
    pub(super) fn release(&mut self, now: u64) -> bool {
        let mut any = false;
        for task in 0..self.tasks.len() {
            if self.next_release(task) != Some(now) {
                continue;
            }
            let index = self.tasks[task].released;
            self.tasks[task].released += 1;
            let job = self.new_job(task, index, now);
            self.outcome.release(&job);
            if self.jobs.len() < JOBS_IN_FLIGHT || self.replace_one(&job, now) {
                self.jobs.push(job);
                self.settle(now);
                any = true;
            } else {
                self.outcome.shed(&job, now, Reason::Full);
            }
        }
        any
    }

    /// Gives up a job whose place a new one takes (8.7), if there is one. What only that one needed is gone before the new one
    /// is there.
    fn replace_one(&mut self, new: &Job, now: u64) -> bool {
        let goes = self.who_gives_way(new, now).filter(|_| self.policy.is_ours());
        if let Some((task, index)) = goes {
            self.give_up(task, index, now, Reason::Full);
            self.drop_unused();
        }
        goes.is_some()
    }

    /// The least of the task that has the most jobs of the lowest rank, if that is below; else the newest of the equals' task that has
    /// the most jobs, if it has two more.
    fn who_gives_way(&self, new: &Job, now: u64) -> Option<(usize, u64)> {
        let own = self.rank(new, &[], now);
        let least = self.jobs.iter().map(|job| self.rank(job, &[], now)).min()?;
        let count = |task: usize| self.jobs.iter().filter(|job| job.task == task).count();
        if least < own {
            let lowest = self.jobs.iter().filter(|job| self.rank(job, &[], now) == least);
            let goes = lowest.min_by_key(|job| (Reverse(count(job.task)), self.standing(job, &[], now)))?;
            return Some((goes.task, goes.index));
        }
        let mut equals: Vec<&Job> =
            self.jobs.iter().filter(|job| !job.started && self.rank(job, &[], now) == own).collect();
        equals.sort_by_key(|job| (count(job.task), job.index, job.task));
        let newest = equals.pop().filter(|job| count(job.task) >= count(new.task) + 2)?;
        Some((newest.task, newest.index))
    }

    pub(super) fn new_job(&self, task: usize, index: u64, now: u64) -> Job {
        let graph = Rc::clone(&self.tasks[task].graph);
        let deadline = self.workload.tasks[task].deadline_ns;
        let due = i128::from(now) + i128::from(deadline);
        let tails = graph.tails(&graph.costs());
        Job {
            task,
            index,
            release: now,
            due,
            version: self.tasks[task].version,
            heights: graph.heights(|_| true),
            state: vec![State::Waiting; graph.nodes.len()],
            started: false,
            fortune: if self.policy.is_ours() { self.fortune(task, &[]) } else { 0 },
            band: band::NEW,
            keys: keys::at_release(self.policy, &graph, now, deadline),
            latest_finish: tails.iter().map(|&tail| due - i128::from(tail)).collect(),
            frames: job::frames(self.workload, &graph, task, index, now),
            graph,
        }
    }
}
