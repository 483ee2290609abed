//! What a replayed run was, in numbers, and what a simulation takes over from it.

use super::Opened;
use crate::session::Robot;
use red_core::{Action, CompleteError, Instant, Member, Scheduler, UnitId};
use red_record::{Answer, Call, Entry};
use red_sim::{Past, PoolMetrics, Report};
use red_workload::build::Numbered;
use red_workload::metrics::{TaskLog, summarise};
use red_workload::model::Workload;
use std::collections::{HashMap, VecDeque};

/// More than are shown before a difference.
const NAMES: usize = 64;

/// Follows a replay.
pub(super) struct Recorded {
    pub(super) past: Past,
    logs: Vec<TaskLog>,
    deadlines_ns: Vec<u64>,
    tasks: Vec<String>,
    nodes: Vec<Vec<Numbered>>,
    /// Units that run: since when, on which lane, and their members.
    running: HashMap<UnitId, (u64, Vec<Member>)>,
    /// Names of the units that started last.
    names: VecDeque<(UnitId, String)>,
    /// By lane.
    busy_ns: [u64; 32],
    nodes_missed: u64,
    end: Instant,
}

impl Recorded {
    pub(super) fn new(opened: &Opened) -> Self {
        let tasks = &opened.workload.tasks;
        Self {
            past: Past::new(tasks.len()),
            logs: vec![TaskLog::default(); tasks.len()],
            deadlines_ns: tasks.iter().map(|task| task.deadline_ns).collect(),
            nodes: opened.plan.nodes.clone(),
            running: HashMap::new(),
            names: VecDeque::new(),
            tasks: tasks.iter().map(|task| task.name.clone()).collect(),
            busy_ns: [0; 32],
            nodes_missed: 0,
            end: Instant::ZERO,
        }
    }

    /// The next entry, which was as recorded.
    pub(super) fn watch(&mut self, scheduler: &Scheduler<Robot>, entry: &Entry) {
        let now = entry.now.as_nanos();
        self.end = self.end.max(entry.now);
        match (entry.call, entry.answer) {
            (Call::Release { task, at, .. }, Answer::Released(answer)) => {
                let (task, at) = (task.index(), at.as_nanos());
                let due = at.saturating_add(self.deadlines_ns.get(task).copied().unwrap_or(0));
                self.past.released(task, at);
                if let Some(log) = self.logs.get_mut(task) {
                    if answer.is_ok() { log.released(at, due) } else { log.refused(at, due) }
                }
            }
            (_, Answer::Polled(Some(Action::Ended(outcome))) | Answer::Outcome(Some(outcome))) => {
                if let Some(log) = self.logs.get_mut(outcome.task.index()) {
                    log.ended(&outcome);
                }
            }
            (_, Answer::Polled(Some(Action::Dispatch(started)))) => {
                let members = scheduler.members(started.unit).collect();
                if let Some(name) = self.name_of(started.unit, scheduler) {
                    self.names.truncate(NAMES - 1);
                    self.names.push_front((started.unit, name));
                }
                self.running.insert(started.unit, (now, members));
            }
            (Call::Complete(unit), Answer::Reported(Ok(()) | Err(CompleteError::Late))) => {
                self.done(unit, now);
            }
            _ => {}
        }
    }

    /// Task, job and node of a unit that runs, or did a while ago.
    pub(super) fn name_of(&self, unit: UnitId, scheduler: &Scheduler<Robot>) -> Option<String> {
        if let Some((_, name)) = self.names.iter().find(|(named, _)| *named == unit) {
            return Some(name.clone());
        }
        let member = scheduler.unit(unit)?.first;
        let task = member.task.index();
        let node = self.nodes.get(task)?.get(member.node.index())?;
        Some(format!("{}/{}/{}", self.tasks.get(task)?, member.index, node.name))
    }

    fn done(&mut self, unit: UnitId, now: u64) {
        let Some((since, members)) = self.running.remove(&unit) else { return };
        let took = now.saturating_sub(since);
        self.busy_ns[unit.lane().index() % 32] += took;
        for member in members {
            self.nodes_missed += u64::from(now > member.sub_deadline.as_nanos());
            let task = member.task.index();
            if let Some(node) = self.nodes.get(task).and_then(|nodes| nodes.get(member.node.index())) {
                self.past.executed(task, member.index, node, took);
            }
        }
    }

    /// The run as `run --json` has it, as far as the scheduler knows.
    pub(super) fn report(&self, opened: &Opened, until: Instant) -> Report {
        let Workload { tasks, pools, .. } = &opened.workload;
        let end = self.end.max(until);
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
            tasks: tasks.iter().zip(&self.logs).map(|(t, log)| summarise(&t.name, log, until, end)).collect(),
            nodes_missed: self.nodes_missed,
            units_dispatched: counters.units,
            encoder_runs_saved: counters.encoder_runs_saved,
            schedule: None,
            sheds: None,
        }
    }
}
