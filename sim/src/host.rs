//! The host loop: events of one instant in their order, then dispatch, then the next instant.

use crate::Lab;
use crate::execution::Execution;
use crate::past::Past;
use crate::report::{Report, Row, Shed};
use crate::world::{Drawn, World};
use red_core::{
    Action, BestCase, CommitError, Config, Dispatch, Empty, Instant, JobId, Member, NodeId, Outcome,
    ReleaseError, Scheduler, ShedReason, TaskId, UnitId,
};
use red_workload::build::{self, BuildError, Change, Numbered, Plan};
use red_workload::metrics::{TaskLog, nodes::Executions};
use red_workload::model::{SyncGrid, Workload};
use red_workload::policy::Policy;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::fmt;

/// What to simulate.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Policy.
    pub policy: Policy,
    /// Simulated time.
    pub horizon_ns: u64,
    /// Seed of the execution times.
    pub seed: u64,
    /// Execution-time model.
    pub execution: Execution,
    /// Whether waiting nodes of a smaller key take lanes from running ones.
    pub preempt: bool,
    /// Whether to list every sub-job and every shed.
    pub schedule: bool,
}

/// A workload could not be simulated.
#[derive(Debug)]
pub enum SimError {
    /// It does not fit the executive.
    Build(BuildError),
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Build(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for SimError {}

/// Simulates a workload.
///
/// # Errors
/// [`SimError`]; files that `red_workload` accepted fail only on the number of sensor periods.
pub fn simulate(workload: &Workload, options: &Options) -> Result<Report, SimError> {
    let timed = options.execution.best_cases_of(workload);
    let config = Config { best_case: BestCase::Declared, ..options.policy.config() };
    let world = Drawn { workload, execution: options.execution, seed: options.seed };
    let mut host = Host::new(workload, &timed, config, options, &world).map_err(SimError::Build)?;
    host.run();
    Ok(host.report())
}

/// Simulates a workload in a world of the caller's, under a configuration that need not be a named one. Of `options`
/// the execution-time model has no meaning here; policy and seed are what the report is headed by, and the policy says
/// whether a `[sync]` grid holds.
///
/// # Errors
/// [`SimError`].
pub fn simulate_in(
    world: &dyn World,
    workload: &Workload,
    config: Config,
    options: &Options,
) -> Result<Report, SimError> {
    let mut host = Host::new(workload, workload, config, options, world).map_err(SimError::Build)?;
    host.run();
    Ok(host.report())
}

/// Simulates a workload whose releases and execution times are those of a run, and whose bodies fail where they did
/// in it; it had no `[sync]` grid, so this has none. `options` may have
/// another policy than that run. Its seed and execution-time model have no meaning here. With the report come the nodes, as `task.node`, that
/// took their WCET because the run never executed them.
///
/// # Errors
/// [`SimError`], where `workload` was changed to what the executive has no room for.
pub fn simulate_past(
    workload: &Workload,
    past: &Past,
    options: &Options,
) -> Result<(Report, Vec<String>), SimError> {
    let config = options.policy.config();
    let mut host = Host::new(workload, workload, config, options, past).map_err(SimError::Build)?;
    // A run has no grid.
    host.barrier = None;
    host.run();
    let row = |(task, node): &(usize, usize)| {
        format!("{}.{}", workload.tasks[*task].name, host.nodes[*task][*node].name)
    };
    let unknown = host.unknown.iter().map(row).collect();
    Ok((host.report(), unknown))
}

/// A unit that runs.
pub(crate) struct Running {
    unit: UnitId,
    started: u64,
    /// What it took before it was preempted.
    took: u64,
    /// Whether its body failed in the run that is taken over.
    fails: bool,
    /// Its members, and when each should end.
    due: Vec<(JobId, NodeId, Instant)>,
}

pub(crate) struct Host<'a> {
    pub(crate) workload: &'a Workload,
    pub(crate) options: &'a Options,
    pub(crate) horizon: Instant,
    pub(crate) scheduler: Box<Scheduler<Lab>>,
    pub(crate) tasks: Vec<TaskId>,
    pub(crate) nodes: Vec<Vec<Numbered>>,
    /// Changes to come, and those that wait for a version to drain.
    pub(crate) changes: VecDeque<Change>,
    pub(crate) waiting: VecDeque<Change>,
    /// Next release of each task.
    pub(crate) next_release: Vec<Option<u64>>,
    world: &'a dyn World,
    /// Nodes, by task and number, whose times are guesses.
    unknown: BTreeSet<(usize, usize)>,
    /// By (finish, lane): pools' lanes are numbered in file order.
    pub(crate) running: BTreeMap<(u64, usize), Running>,
    /// What is left of preempted sub-jobs, and what they took.
    pub(crate) suspended: HashMap<(JobId, NodeId), (u64, u64)>,
    pub(crate) barrier: Option<SyncGrid>,
    pub(crate) dispatch_at: Option<u64>,
    pub(crate) logs: Vec<TaskLog>,
    pub(crate) executions: Executions,
    pub(crate) rows: Vec<Row>,
    pub(crate) sheds: Vec<Shed>,
    pub(crate) busy: Vec<u64>,
    pub(crate) nodes_missed: u64,
    /// First lane of each pool.
    pub(crate) first_lane: Vec<usize>,
}

impl<'a> Host<'a> {
    fn new(
        workload: &'a Workload,
        timed: &Workload,
        config: Config,
        options: &'a Options,
        world: &'a dyn World,
    ) -> Result<Self, BuildError> {
        let mut scheduler: Box<Scheduler<Lab>> = Box::new(Scheduler::EMPTY);
        let config = Config { preempt: options.preempt, ..config };
        let (plan, tasks): (Plan<Lab>, _) = build::admit(&mut scheduler, timed, config)?;
        let mut first_lane = Vec::new();
        let mut lanes = 0;
        for pool in &workload.pools {
            first_lane.push(lanes);
            lanes += pool.lanes as usize;
        }
        let executions = Executions::new(0, &plan.nodes);
        Ok(Self {
            workload,
            options,
            horizon: Instant::from_nanos(options.horizon_ns),
            scheduler,
            tasks,
            nodes: plan.nodes,
            changes: plan.changes.into(),
            waiting: VecDeque::new(),
            next_release: (0..workload.tasks.len()).map(|task| world.release(task, 0)).collect(),
            world,
            unknown: BTreeSet::new(),
            running: BTreeMap::new(),
            suspended: HashMap::new(),
            barrier: workload.sync.filter(|_| options.policy.has_barrier()),
            dispatch_at: None,
            logs: vec![TaskLog::default(); workload.tasks.len()],
            executions,
            rows: Vec::new(),
            sheds: Vec::new(),
            busy: vec![0; workload.pools.len()],
            nodes_missed: 0,
            first_lane,
        })
    }

    fn run(&mut self) {
        while let Some(now) = self.next_instant().filter(|t| *t < self.horizon) {
            self.complete_due(now);
            self.change_due(now);
            self.release_due(now);
            if self.may_dispatch(now) {
                self.dispatch(now);
            }
        }
        for running in std::mem::take(&mut self.running).into_values() {
            self.occupied(&running, self.horizon.as_nanos());
        }
    }

    fn next_instant(&self) -> Option<Instant> {
        let release = self.next_release.iter().flatten().min().copied();
        let completion = self.running.first_key_value().map(|((finish, _), _)| *finish);
        let change = self.changes.front().map(|c| c.at.as_nanos());
        let poll =
            if self.barrier.is_some() { None } else { self.scheduler.poll_at().map(Instant::as_nanos) };
        [release, completion, change, poll, self.dispatch_at]
            .into_iter()
            .flatten()
            .min()
            .map(Instant::from_nanos)
    }

    fn complete_due(&mut self, now: Instant) {
        while let Some(((finish, lane), _)) = self.running.first_key_value()
            && *finish == now.as_nanos()
        {
            let key = (*finish, *lane);
            if let Some(done) = self.running.remove(&key) {
                self.occupied(&done, now.as_nanos());
                // Only members whose jobs are still wanted can miss anything.
                let late = |m: &Member| {
                    done.due.iter().any(|(job, node, due)| (*job, *node) == (m.job, m.node) && *due < now)
                };
                self.nodes_missed += self.scheduler.members(done.unit).filter(late).count() as u64;
                let took = done.took + (now.as_nanos() - done.started);
                for member in self.scheduler.members(done.unit) {
                    self.executions.add(member.task.index(), member.node.index(), took);
                }
                // `Late` is the end of a unit whose jobs were given up: its lane is free again.
                let _lane_is_free = if done.fails {
                    self.scheduler.fail(done.unit, now)
                } else {
                    self.scheduler.complete(done.unit, now)
                };
                self.note_events();
            }
        }
        self.take_outcomes();
    }

    fn change_due(&mut self, now: Instant) {
        while self.changes.front().is_some_and(|c| c.at <= now) {
            self.waiting.extend(self.changes.pop_front());
        }
        // Changes of one task stay in their order; a busy one holds back only later ones of its own task.
        let mut busy = vec![false; self.tasks.len()];
        let waiting = std::mem::take(&mut self.waiting);
        for change in waiting {
            let task = change.task;
            if !busy[task] {
                let applied = build::apply(&mut self.scheduler, &change, self.tasks[task], now);
                debug_assert!(
                    matches!(applied, Ok(()) | Err(CommitError::Busy)),
                    "a checked file's edits apply: {applied:?}"
                );
                busy[task] = applied.is_err();
            }
            if busy[task] {
                self.waiting.push_back(change);
            }
        }
        self.note_events();
    }

    fn release_due(&mut self, now: Instant) {
        for (i, task) in self.workload.tasks.iter().enumerate() {
            if self.next_release[i] != Some(now.as_nanos()) {
                continue;
            }
            let deadline = now.as_nanos().saturating_add(task.deadline_ns);
            // One that took another's place leaves an outcome, which the next may not overwrite.
            self.take_outcomes();
            match self.scheduler.release(self.tasks[i], now) {
                Ok(_) => self.logs[i].released(now.as_nanos(), deadline),
                Err(ReleaseError::Full) => {
                    let job = self.logs[i].jobs().len() as u64;
                    self.logs[i].refused(now.as_nanos(), deadline);
                    self.shed(i, job, now.as_nanos(), ShedReason::Full);
                }
                // Beyond the end of time: no release of this task comes any more.
                Err(_) => {
                    self.next_release[i] = None;
                    continue;
                }
            }
            // Of one instant, they come one after the other.
            let next = self.world.release(i, self.logs[i].jobs().len());
            self.next_release[i] = next.map(|at| at.max(now.as_nanos()));
        }
        self.note_events();
    }

    /// Under a barrier grid: whether this instant is one of dispatch. Events in between ask for the next one.
    fn may_dispatch(&mut self, now: Instant) -> bool {
        let Some(grid) = self.barrier else { return true };
        if self.dispatch_at == Some(now.as_nanos()) {
            self.dispatch_at = None;
            return true;
        }
        if self.dispatch_at.is_none() && self.scheduler.can_dispatch() {
            self.dispatch_at =
                now.as_nanos().div_ceil(grid.grid_ns).saturating_mul(grid.grid_ns).checked_add(grid.cost_ns);
        }
        false
    }

    fn dispatch(&mut self, now: Instant) {
        while let Some(action) = self.scheduler.poll(now) {
            match action {
                Action::Dispatch(started) => self.start(started, now),
                Action::Preempt(stopped) => self.stop(stopped, now),
                Action::Ended(outcome) => self.ended(&outcome),
                _ => {}
            }
        }
        while let Some(warning) = self.scheduler.take_warning() {
            self.logs[warning.task.index()].warned(warning.index, now.as_nanos());
        }
        // Else time would stand still here, and a host that sleeps until then would never sleep.
        debug_assert!(self.scheduler.poll_at().is_none_or(|next| next > now), "poll leaves nothing due");
        self.note_events();
    }

    fn start(&mut self, started: Dispatch, now: Instant) {
        let Some(unit) = self.scheduler.unit(started.unit) else { return };
        let members = self.scheduler.members(started.unit);
        let due = members.map(|m| (m.job, m.node, m.sub_deadline)).collect();
        let (cost, took) = self.suspended.remove(&(unit.first.job, unit.first.node)).unwrap_or_else(|| {
            let draw = |m: Member| {
                let (task, number) = (m.task.index(), m.node.index());
                let node = &self.nodes[task][number];
                let (time, is_known) = self.world.time(task, m.index, node);
                if !is_known {
                    self.unknown.insert((task, number));
                }
                time
            };
            (self.scheduler.members(started.unit).map(draw).max().unwrap_or(0), 0)
        });
        let finish = now.as_nanos().saturating_add(cost);
        let failed = |m: Member| {
            self.world.fails(m.task.index(), m.index, &self.nodes[m.task.index()][m.node.index()])
        };
        let fails = self.scheduler.members(started.unit).any(failed);
        let running = Running { unit: started.unit, started: now.as_nanos(), took, fails, due };
        self.running.insert((finish, started.lane.index()), running);
        self.note_rows(finish);
    }

    fn stop(&mut self, stopped: Dispatch, now: Instant) {
        let lane = stopped.lane.index();
        let key = self.running.iter().find(|((_, l), _)| *l == lane).map(|(key, _)| *key);
        if let Some(running) = key.and_then(|key| self.running.remove(&key)) {
            self.occupied(&running, now.as_nanos());
            let left = key.map_or(0, |(finish, _)| finish - now.as_nanos());
            let took = running.took + (now.as_nanos() - running.started);
            // The row of the sub-job that lost its lane ends here; it gets another when it goes on.
            self.note_preempted(now.as_nanos(), (left, took));
        }
    }

    fn occupied(&mut self, running: &Running, until: u64) {
        let lane = running.unit.lane().index();
        let pool = self.pool_of(lane);
        self.busy[pool] += until - running.started;
    }

    pub(crate) fn pool_of(&self, lane: usize) -> usize {
        self.first_lane.partition_point(|first| *first <= lane) - 1
    }

    fn take_outcomes(&mut self) {
        while let Some(outcome) = self.scheduler.take_outcome() {
            self.ended(&outcome);
        }
    }

    fn ended(&mut self, outcome: &Outcome) {
        let task = outcome.task.index();
        self.logs[task].ended(outcome);
        if let Some(reason) = outcome.shed {
            self.shed(task, outcome.index, outcome.at.as_nanos(), reason);
        }
    }

    fn shed(&mut self, task: usize, job: u64, at_ns: u64, reason: ShedReason) {
        if self.options.schedule {
            let task = self.workload.tasks[task].name.clone();
            self.sheds.push(Shed { task, job, at_ns, reason: reason.name() });
        }
    }
}
