//! A set of DAG tasks under the scheduler itself, in virtual time.

use super::sets::{Board, Task};
use crate::rng::Rng;
use red_core::{
    Action, Capacity, Config, Dispatch, Empty, Instant, JobId, NodeId, Outcome, Scheduler, TaskId, UnitId,
};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Longest periods of a run.
const PERIODS: u64 = 3;

/// What became of the jobs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Ends {
    /// Jobs released.
    pub(crate) jobs: u64,
    /// Jobs that ended late, were given up or found no place.
    pub(crate) missed: u64,
    /// When the last one ended, in nanoseconds.
    pub(crate) last_end: u64,
    /// Of each task: its longest response time, in nanoseconds, and jobs that missed.
    pub(crate) by_task: Vec<(u64, u64)>,
    /// Of each task, what became of its jobs.
    pub(crate) fates: Vec<Vec<Fate>>,
    /// What ran, in the order of starts; without preemption.
    pub(crate) spans: Vec<Span>,
}

/// How a job ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Fate {
    /// All its nodes ended by its deadline.
    pub(crate) on_time: bool,
    /// When it ended, was given up or found no place, in nanoseconds.
    pub(crate) at: u64,
}

/// A node that had a lane. Times are in nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    /// Its task.
    pub(crate) task: usize,
    /// The how-manieth job of its task.
    pub(crate) job: u64,
    /// Its number.
    pub(crate) node: usize,
    /// From when.
    pub(crate) start: u64,
    /// Until when.
    pub(crate) end: u64,
}

/// What is run.
#[derive(Clone, Copy)]
pub(crate) struct Case<'a> {
    /// The tasks.
    pub(crate) tasks: &'a [Task],
    /// Shortest execution time of a node, in percent of its cost.
    pub(crate) best_percent: u64,
    /// What happens.
    pub(crate) world: World<'a>,
}

/// When jobs are released, and how long their nodes take.
#[derive(Clone, Copy)]
pub(crate) struct World<'a> {
    /// Instants of release of each task, ascending, in nanoseconds.
    pub(crate) releases: &'a [Vec<u64>],
    /// Execution time of a node by task, job and number, in nanoseconds.
    pub(crate) time: &'a dyn Fn(usize, u64, usize) -> u64,
    /// Whether it ends with the first miss.
    pub(crate) until_miss: bool,
}

struct Host<'a, C: Capacity> {
    world: World<'a>,
    scheduler: Box<Scheduler<C>>,
    tasks: Vec<TaskId>,
    next: Vec<usize>,
    /// By (finish, lane).
    running: BTreeMap<(u64, usize), Unit>,
    /// What is left of preempted nodes.
    suspended: HashMap<(JobId, NodeId), u64>,
    ends: Ends,
}

#[derive(Clone, Copy)]
struct Unit {
    unit: UnitId,
    job: JobId,
    node: NodeId,
}

/// Runs a case; `None` where the tasks are more than the scheduler's capacity.
#[must_use]
pub(crate) fn drive(case: &Case<'_>, config: Config) -> Option<Ends> {
    let mut scheduler: Box<Scheduler<Board>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(config);
    let mut tasks = Vec::new();
    for task in case.tasks {
        tasks.push(scheduler.add_task(&task.graph.dag(case.best_percent)?, task.timing()).ok()?);
    }
    Some(play(case.world, scheduler, tasks))
}

/// Lets a world happen to the tasks of a scheduler.
#[must_use]
pub(crate) fn play<C: Capacity>(world: World<'_>, scheduler: Box<Scheduler<C>>, tasks: Vec<TaskId>) -> Ends {
    let next = vec![0; tasks.len()];
    let (running, suspended) = (BTreeMap::new(), HashMap::new());
    let fates = world.releases.iter().map(|releases| vec![Fate::default(); releases.len()]).collect();
    let ends = Ends { by_task: vec![(0, 0); tasks.len()], fates, ..Ends::default() };
    let mut host = Host { world, scheduler, tasks, next, running, suspended, ends };
    host.run();
    host.ends
}

impl<C: Capacity> Host<'_, C> {
    fn run(&mut self) {
        while let Some(now) = self.next_instant() {
            self.complete(now);
            self.release(now);
            let at = Instant::from_nanos(now);
            while let Some(action) = self.scheduler.poll(at) {
                match action {
                    Action::Dispatch(started) => self.start(started, now),
                    Action::Preempt(stopped) => self.stop(stopped, now),
                    Action::Ended(outcome) => self.ended(&outcome),
                    _ => {}
                }
            }
            if self.world.until_miss && self.ends.missed > 0 {
                return;
            }
        }
    }

    fn next_release(&self, task: usize) -> Option<u64> {
        self.world.releases[task].get(self.next[task]).copied()
    }

    fn next_instant(&self) -> Option<u64> {
        let release = (0..self.tasks.len()).filter_map(|task| self.next_release(task)).min();
        let finish = self.running.first_key_value().map(|((finish, _), _)| *finish);
        let poll = self.scheduler.poll_at().map(Instant::as_nanos);
        [release, finish, poll].into_iter().flatten().min()
    }

    fn complete(&mut self, now: u64) {
        while let Some(entry) = self.running.first_entry().filter(|entry| entry.key().0 == now) {
            let done = entry.remove();
            // `Late` is the end of a unit whose job was given up: its lane is free again.
            let _lane_is_free = self.scheduler.complete(done.unit, Instant::from_nanos(now));
        }
        while let Some(outcome) = self.scheduler.take_outcome() {
            self.ended(&outcome);
        }
    }

    fn release(&mut self, now: u64) {
        for task in 0..self.tasks.len() {
            while self.next_release(task) == Some(now) {
                let job = self.next[task];
                self.next[task] += 1;
                self.ends.jobs += 1;
                if self.scheduler.release(self.tasks[task], Instant::from_nanos(now)).is_err() {
                    self.ends.missed += 1;
                    self.ends.by_task[task].1 += 1;
                    self.ends.fates[task][job].at = now;
                }
                // One that was displaced is taken before the next release.
                while let Some(outcome) = self.scheduler.take_outcome() {
                    self.ended(&outcome);
                }
            }
        }
    }

    fn start(&mut self, started: Dispatch, now: u64) {
        let Some(first) = self.scheduler.members(started.unit).next() else { return };
        let time = self
            .suspended
            .remove(&(first.job, first.node))
            .unwrap_or_else(|| (self.world.time)(first.task.index(), first.index, first.node.index()));
        let unit = Unit { unit: started.unit, job: first.job, node: first.node };
        self.running.insert((now + time, started.lane.index()), unit);
        let (task, job, node) = (first.task.index(), first.index, first.node.index());
        self.ends.spans.push(Span { task, job, node, start: now, end: now + time });
    }

    fn stop(&mut self, stopped: Dispatch, now: u64) {
        let lane = stopped.lane.index();
        let key = self.running.keys().find(|(_, l)| *l == lane).copied();
        if let Some((key, unit)) = key.and_then(|key| Some((key, self.running.remove(&key)?))) {
            self.suspended.insert((unit.job, unit.node), key.0 - now);
        }
    }

    fn ended(&mut self, outcome: &Outcome) {
        let missed = u64::from(!outcome.on_time());
        self.ends.missed += missed;
        let (longest, misses) = &mut self.ends.by_task[outcome.task.index()];
        *misses += missed;
        let fate = Fate { on_time: outcome.on_time(), at: outcome.at.as_nanos() };
        self.ends.fates[outcome.task.index()][outcome.index as usize] = fate;
        if outcome.shed.is_none() {
            *longest = (*longest).max(outcome.at.since(outcome.release).as_nanos());
        }
        self.ends.last_end = self.ends.last_end.max(outcome.at.as_nanos());
        if outcome.shed.is_some() {
            self.suspended.retain(|(job, _), _| *job != outcome.job);
        }
    }
}

/// Periodic releases from offsets within the first period on, over three of the longest periods, at most so many jobs in all.
#[must_use]
pub(crate) fn releases(tasks: &[Task], rng: &mut Rng, most: usize) -> Vec<Vec<u64>> {
    let longest = tasks.iter().map(|task| task.period_ns).max().unwrap_or(0);
    let mut instants = BTreeSet::new();
    for (nth, task) in tasks.iter().enumerate() {
        let offset = rng.within(0, task.period_ns - 1);
        let jobs = (PERIODS * longest).div_ceil(task.period_ns).min(most as u64);
        instants.extend((0..jobs).map(|job| (offset + job * task.period_ns, nth)));
    }
    let mut releases = vec![Vec::new(); tasks.len()];
    for (at, nth) in instants.into_iter().take(most) {
        releases[nth].push(at);
    }
    releases
}
