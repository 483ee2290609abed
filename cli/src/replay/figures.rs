//! What a replayed run was, in numbers, and what a simulation takes over from it.

use super::Opened;
use red_core::{Capacity, CompleteError, Event, EventKind, Instant, Member, Scheduler, UnitId};
use red_record::{Answer, Call, Entry, Started};
use red_sim::{Past, PoolMetrics, Report};
use red_workload::build::Numbered;
use red_workload::metrics::{TaskLog, TaskMetrics, nodes::Executions, summarise};
use red_workload::model::{Task, Workload};
use std::collections::HashMap;

/// Lanes of a scheduler at most.
const LANES: usize = 32;

/// Follows a replay, and keeps every release, execution and end.
pub(crate) struct Figures {
    pub(crate) past: Past,
    logs: Vec<TaskLog>,
    pub(crate) executions: Executions,
    deadlines_ns: Vec<u64>,
    nodes: Vec<Vec<Numbered>>,
    running: HashMap<UnitId, OnLane>,
    /// By lane.
    pub(crate) busy_ns: [u64; LANES],
    pub(crate) nodes_missed: u64,
    /// When the run ended.
    pub(crate) end: Instant,
    /// Whether jobs were in flight then.
    pub(crate) left_open: bool,
}

/// A unit on its lane.
struct OnLane {
    since: u64,
    /// Time since then in which nothing ran.
    stood: u64,
    members: Vec<Member>,
    /// Units that end before it starts.
    after: Vec<UnitId>,
}

impl Figures {
    /// Of a run without a workload: times of lanes, and nothing of tasks.
    pub(crate) fn of_lanes() -> Self {
        Self {
            past: Past::new(0),
            logs: Vec::new(),
            executions: Executions::default(),
            deadlines_ns: Vec::new(),
            nodes: Vec::new(),
            running: HashMap::new(),
            busy_ns: [0; LANES],
            nodes_missed: 0,
            end: Instant::ZERO,
            left_open: false,
        }
    }

    pub(crate) fn new(workload: &Workload, nodes: Vec<Vec<Numbered>>) -> Self {
        let tasks = &workload.tasks;
        Self {
            past: Past::new(tasks.len()),
            logs: vec![TaskLog::default(); tasks.len()],
            deadlines_ns: tasks.iter().map(|task| task.deadline_ns).collect(),
            executions: Executions::new(LANES, &nodes),
            nodes,
            ..Self::of_lanes()
        }
    }

    /// The next entry, which was as recorded, and what the scheduler recorded at it.
    pub(crate) fn watch<C: Capacity>(&mut self, scheduler: &Scheduler<C>, entry: &Entry, events: &[Event]) {
        if self.past.is_cut() {
            return;
        }
        let now = entry.now.as_nanos();
        if let Call::StoodStill(time) = entry.call {
            self.executions.stood_still(time, entry.now);
        }
        for event in events {
            self.executions.event(event);
            let log = self.logs.get_mut(event.task.index()).filter(|_| event.kind == EventKind::Warned);
            if let Some(log) = log {
                log.warned(event.job, event.at.as_nanos());
            }
        }
        match (entry.call, entry.answer) {
            (Call::Release { task, at, .. }, Answer::Released(answer)) => {
                let (task, at) = (task.index(), at.as_nanos());
                let due = at.saturating_add(self.deadlines_ns.get(task).copied().unwrap_or(0));
                self.past.released(task, at);
                if let Some(log) = self.logs.get_mut(task) {
                    if answer.is_ok() { log.released(at, due) } else { log.refused(at, due) }
                }
            }
            (_, Answer::Ended(outcome)) => {
                if let Some(log) = self.logs.get_mut(outcome.task.index()) {
                    log.ended(&outcome);
                }
            }
            (_, Answer::Started(Started { unit, .. }) | Answer::Ahead(Started { unit, .. })) => {
                let beside = self.running.keys().filter(|other| other.lane() == unit.lane()).copied();
                let after = scheduler.waits_for(unit).chain(beside).collect();
                let members = scheduler.members(unit).collect();
                self.running.insert(unit, OnLane { since: now, stood: 0, members, after });
            }
            (Call::Complete(unit), Answer::Reported(Ok(()) | Err(CompleteError::Late))) => {
                self.executed(unit, now);
            }
            (Call::Fail(unit), Answer::Reported(Ok(()) | Err(CompleteError::Late))) => {
                let Some((took, members)) = self.left(unit, now) else { return };
                for member in members {
                    if let Some(node) =
                        self.nodes.get(member.task.index()).and_then(|n| n.get(member.node.index()))
                    {
                        self.past.failed(member.task.index(), member.index, node, took);
                    }
                }
            }
            (Call::StoodStill(time), _) => {
                for running in self.running.values_mut() {
                    running.stood += time.as_nanos().min(now.saturating_sub(running.since));
                }
            }
            (_, Answer::Preempted(unit)) => drop(self.left(unit, now)),
            (Call::End, Answer::End(end)) => {
                self.end = entry.now;
                self.left_open = end.jobs_in_flight > 0;
            }
            _ => {}
        }
    }

    /// A unit left its lane: how long it had that, and its members.
    fn left(&mut self, unit: UnitId, now: u64) -> Option<(u64, Vec<Member>)> {
        let OnLane { since, stood, members, .. } = self.running.remove(&unit)?;
        self.running
            .values_mut()
            .filter(|other| other.after.contains(&unit))
            .for_each(|other| (other.since, other.stood) = (now, 0));
        let took = now.saturating_sub(since);
        self.busy_ns[unit.lane().index() % LANES] += took;
        Some((took.saturating_sub(stood), members))
    }

    fn executed(&mut self, unit: UnitId, now: u64) {
        // Its end told of theirs.
        while let Some(before) = self.before(unit) {
            self.executed_alone(before, now);
        }
        self.executed_alone(unit, now);
    }

    /// A unit that runs and ended before this one.
    fn before(&self, unit: UnitId) -> Option<UnitId> {
        let after = &self.running.get(&unit)?.after;
        after.iter().find(|before| self.running.contains_key(before)).copied()
    }

    fn executed_alone(&mut self, unit: UnitId, now: u64) {
        let Some((took, members)) = self.left(unit, now) else { return };
        for member in members {
            self.nodes_missed += u64::from(now > member.sub_deadline.as_nanos());
            let task = member.task.index();
            if let Some(node) = self.nodes.get(task).and_then(|nodes| nodes.get(member.node.index())) {
                self.past.executed(task, member.index, node, took);
            }
        }
    }

    /// How the jobs of each task ended; `None` if the log is too long to tell.
    pub(crate) fn tasks(&self, opened: &Opened) -> Option<Vec<TaskMetrics>> {
        let until = self.end.min(Instant::from_nanos(opened.log.header().duration_ns));
        (!self.past.is_cut()).then(|| self.of_tasks(&opened.workload.tasks, until))
    }

    /// Tasks with the jobs that were released before `until`.
    fn of_tasks(&self, tasks: &[Task], until: Instant) -> Vec<TaskMetrics> {
        let tasks = tasks.iter().zip(&self.logs).enumerate();
        let of_task = |(number, (task, log)): (usize, (&Task, _))| TaskMetrics {
            nodes: self.executions.of(number),
            ..summarise(task, log, until, self.end)
        };
        tasks.map(of_task).collect()
    }

    /// The run as `run --json` has it, as far as the scheduler knows: jobs that were released before `until`.
    pub(crate) fn report(&self, opened: &Opened, until: Instant) -> Report {
        let Workload { tasks, pools, .. } = &opened.workload;
        let mut lanes = self.busy_ns.iter();
        let pools = pools.iter().map(|pool| PoolMetrics {
            name: pool.name.clone(),
            lanes: pool.lanes,
            busy_ns: lanes.by_ref().take(pool.lanes as usize).sum(),
        });
        let counters = opened.scheduler.counters();
        Report {
            policy: opened.policy.name(),
            seed: 0,
            horizon_ns: until.as_nanos(),
            pools: pools.collect(),
            tasks: self.of_tasks(tasks, until),
            nodes_missed: self.nodes_missed,
            units_dispatched: counters.units,
            encoder_runs_saved: counters.encoder_runs_saved,
            schedule: None,
            sheds: None,
            jobs: Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests;
