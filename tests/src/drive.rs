//! A host in virtual time that allocates nothing while it runs, so that what allocates is the scheduler.

use red_core::{
    Action, CommitError, Config, Dispatch, Empty, Event, Instant, Outcome, ReleaseError, Scheduler, TaskId,
    UnitId, Warning,
};
use red_sim::Lab;
use red_workload::build::{self, Plan};
use red_workload::model::{Arrival, Workload};

use crate::rng::Rng;

/// Lanes of all pools together, at most.
const LANES: usize = 32;
/// Events between two looks, at most: those of one call.
const EVENTS: usize = 4096;

/// Sees everything that happens, in its order.
pub trait Watch {
    /// A job was released; the next events are its own.
    fn released(&mut self, _scheduler: &Scheduler<Lab>, _task: usize, _index: u64, _now: u64) {}
    /// `poll` answered; `events` are those of this call.
    fn acted(&mut self, _scheduler: &Scheduler<Lab>, _action: &Action, _events: &[Event]) {}
    /// A report, a release or an edit came in; `events` are those of this call.
    fn told(&mut self, _scheduler: &Scheduler<Lab>, _events: &[Event]) {}
    /// A lane is about to report.
    fn completing(&mut self, _unit: UnitId, _now: u64) {}
    /// `poll` has nothing left to do at this instant.
    fn quiet(&mut self, _scheduler: &Scheduler<Lab>, _now: u64) {}
    /// A job ended.
    fn ended(&mut self, _outcome: &Outcome) {}
    /// A job will be late, as is known now.
    fn warned(&mut self, _warning: &Warning) {}
}

/// A watcher that does not look.
#[derive(Clone, Copy, Debug)]
pub struct Blind;

impl Watch for Blind {}

/// The host.
#[derive(Debug)]
pub struct Drive {
    /// What it drives.
    pub scheduler: Box<Scheduler<Lab>>,
    /// Its tasks, in the order of the file.
    pub tasks: Vec<TaskId>,
    plan: Plan<Lab>,
    applied: Vec<bool>,
    arrivals: Vec<Arrival>,
    next_release: Vec<Option<u64>>,
    next_index: Vec<u64>,
    running: [Option<(u64, UnitId)>; LANES],
    events: Vec<Event>,
    /// The instant that was looked at last.
    now: Option<u64>,
    /// Execution times, in percent of the WCET.
    percent: (u64, u64),
    rng: Rng,
    /// How late it is each time, in nanoseconds.
    late_ns: (u64, u64),
    /// Whether it takes warnings.
    listens: bool,
    /// Changes of graphs that were applied.
    pub edits: u32,
    /// Jobs given up, refused ones included.
    pub sheds: u32,
}

impl Drive {
    /// Admits a workload. Execution times are drawn between two shares of the WCET, in percent.
    pub fn new(workload: &Workload, config: Config, percent: (u64, u64), seed: u64) -> Self {
        let mut scheduler = Box::new(Scheduler::EMPTY);
        let (plan, tasks) =
            build::admit(&mut scheduler, workload, config).expect("random workloads are valid");
        Self {
            scheduler,
            tasks,
            applied: vec![false; plan.changes.len()],
            plan,
            arrivals: workload.tasks.iter().map(|task| task.arrival).collect(),
            next_release: workload.tasks.iter().map(|task| Some(task.offset_ns)).collect(),
            next_index: vec![0; workload.tasks.len()],
            running: [None; LANES],
            events: Vec::with_capacity(EVENTS),
            now: None,
            percent,
            rng: Rng::new(seed),
            late_ns: (0, 0),
            listens: true,
            edits: 0,
            sheds: 0,
        }
    }

    /// Makes it late each time by something in this range, in nanoseconds, as threads are: no instant is round, and while every
    /// lane runs a unit nobody looks at the clock. What came meanwhile is told before the report of the unit that ends.
    #[must_use]
    pub fn late_by(mut self, late_ns: (u64, u64)) -> Self {
        self.late_ns = late_ns;
        self
    }

    /// Makes it take no warning.
    #[must_use]
    pub fn deaf(mut self) -> Self {
        self.listens = false;
        self
    }

    /// Runs over [0, `horizon_ns`), and then lets what is in flight end without further releases.
    pub fn run(&mut self, horizon_ns: u64, watch: &mut impl Watch) {
        while let Some(due) = self.next_instant(horizon_ns) {
            let now = due + self.rng.within(self.late_ns.0, self.late_ns.1);
            let at = Instant::from_nanos(now);
            self.now = Some(now);
            if self.late_ns.1 > 0 {
                self.release_jobs(now, horizon_ns, watch);
            }
            self.report_lanes(now, watch);
            self.apply_changes(at, watch);
            self.release_jobs(now, horizon_ns, watch);
            while let Some(action) = self.scheduler.poll(at) {
                self.take_events();
                watch.acted(&self.scheduler, &action, &self.events);
                match action {
                    Action::Dispatch(started) => self.start(started, now),
                    Action::Ended(outcome) => self.end(&outcome, watch),
                    other => panic!("nobody asked for {other:?}"),
                }
            }
            self.take_warnings(watch);
            // Else a host that sleeps until then would never sleep.
            assert!(self.scheduler.poll_at().is_none_or(|next| next > at), "poll leaves nothing due");
            watch.quiet(&self.scheduler, now);
        }
    }

    fn next_instant(&self, horizon_ns: u64) -> Option<u64> {
        let release = self.next_release.iter().flatten().copied().filter(|t| *t < horizon_ns).min();
        let finish = self.running.iter().flatten().map(|(finish, _)| *finish).min();
        let changes = self.plan.changes.iter().zip(&self.applied).filter(|(_, applied)| !**applied);
        // A change that is due and waits is tried again whenever something else happens.
        let instants = changes.map(|(change, _)| change.at.as_nanos());
        let change = instants.filter(|t| Some(*t) > self.now && *t < horizon_ns).min();
        // Where threads are late, it is a lane without a unit that sleeps until then.
        let busy = self.running.iter().flatten().count();
        let nobody_sleeps = self.late_ns.1 > 0 && busy == self.scheduler.lanes();
        let poll = self.scheduler.poll_at().map(Instant::as_nanos);
        let asleep = [release, poll].map(|at| at.filter(|_| !nobody_sleeps));
        asleep.into_iter().chain([finish, change]).flatten().min()
    }

    fn report_lanes(&mut self, now: u64, watch: &mut impl Watch) {
        for lane in 0..LANES {
            let Some((_, unit)) = self.running[lane].filter(|(finish, _)| *finish <= now) else { continue };
            self.running[lane] = None;
            watch.completing(unit, now);
            // `Late` is the end of a unit whose jobs were given up: its lane is free again.
            let _lane_is_free = self.scheduler.complete(unit, Instant::from_nanos(now));
            self.take_events();
            watch.told(&self.scheduler, &self.events);
        }
        while let Some(outcome) = self.scheduler.take_outcome() {
            self.end(&outcome, watch);
        }
    }

    fn apply_changes(&mut self, now: Instant, watch: &mut impl Watch) {
        for i in 0..self.plan.changes.len() {
            let change = &self.plan.changes[i];
            let earlier = (0..i).any(|j| !self.applied[j] && self.plan.changes[j].task == change.task);
            if self.applied[i] || earlier || change.at > now {
                continue;
            }
            match build::apply(&mut self.scheduler, change, self.tasks[change.task], now) {
                Ok(()) => {
                    self.applied[i] = true;
                    self.edits += 1;
                }
                Err(CommitError::Busy) => {}
                Err(error) => panic!("a checked change applies: {error}"),
            }
            self.take_events();
            watch.told(&self.scheduler, &self.events);
        }
    }

    /// Releases what is due, in the order of instants and then of tasks.
    fn release_jobs(&mut self, now: u64, horizon_ns: u64, watch: &mut impl Watch) {
        let is_due = |due: &u64| *due <= now && *due < horizon_ns;
        loop {
            let dues = self.next_release.iter().enumerate();
            let next = dues.filter_map(|(task, due)| Some((due.filter(is_due)?, task))).min();
            let Some((due, task)) = next else { break };
            let index = self.next_index[task];
            self.next_index[task] += 1;
            self.next_release[task] = match self.arrivals[task] {
                Arrival::Periodic { period_ns } => Some(due + period_ns),
                Arrival::Sporadic { min_interarrival_ns } => Some(due + min_interarrival_ns),
                Arrival::Once => None,
            };
            let came = Instant::from_nanos(due.max(self.scheduler.now().as_nanos()).min(now));
            let taken = self.scheduler.release_at(self.tasks[task], Instant::from_nanos(due), None, came);
            self.take_warnings(watch);
            // The outcome of one whose place it took comes before the next release.
            while let Some(outcome) = self.scheduler.take_outcome() {
                self.end(&outcome, watch);
            }
            match taken {
                Ok(_) => watch.released(&self.scheduler, task, index, now),
                Err(ReleaseError::Full) => self.sheds += 1,
                Err(error) => panic!("an admitted task releases: {error}"),
            }
            self.take_events();
            watch.told(&self.scheduler, &self.events);
        }
    }

    fn start(&mut self, started: Dispatch, now: u64) {
        let members = self.scheduler.members(started.unit);
        let wcet =
            members.filter_map(|m| Some(self.scheduler.task_node(m.task, m.node)?.0.wcet().as_nanos())).max();
        let wcet = wcet.expect("a dispatched unit has a member");
        let took = u128::from(wcet) * u128::from(self.rng.within(self.percent.0, self.percent.1)) / 100;
        let finish = now.saturating_add(u64::try_from(took).unwrap_or(u64::MAX));
        let place = &mut self.running[started.lane.index()];
        assert_eq!(*place, None, "a lane runs one unit at a time");
        *place = Some((finish, started.unit));
    }

    fn take_warnings(&mut self, watch: &mut impl Watch) {
        while self.listens
            && let Some(warning) = self.scheduler.take_warning()
        {
            watch.warned(&warning);
        }
    }

    fn end(&mut self, outcome: &Outcome, watch: &mut impl Watch) {
        self.sheds += u32::from(outcome.shed.is_some());
        watch.ended(outcome);
    }

    fn take_events(&mut self) {
        self.events.clear();
        while let Some(event) = self.scheduler.take_event().copied() {
            assert!(self.events.len() < EVENTS, "one call makes no more events than the record holds");
            self.events.push(event);
        }
    }
}
