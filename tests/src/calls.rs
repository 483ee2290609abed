//! A host that calls in any order: late reports, double reports, names that nobody gave out, a clock that steps back or
//! leaps, places that are used again, edits that were begun long ago. What it may expect all the same is asserted
//! after every call.

mod call;
mod graphs;
mod watch;

use std::collections::BTreeSet;
use std::fmt::Debug;

use red_core::{
    Action, Admission, Bytes, Caps, CommitError, CompleteError, Config, Dag, Duration, Gate, Instant, JobId,
    LaneId, Late, NodeId, PoolId, ReleaseError, Scheduler, Shed, TaskId, Timing, UnitId,
};

pub use call::Call;
pub use graphs::Change;
use graphs::{apply, graph, shape};
use watch::Jobs;

/// Two tasks, three jobs and two lanes: small, so that places are used again soon.
pub type Small = Caps<2, 6, 3, 2, 1, 1, 64>;

const LANES: usize = 2;
const DEADLINE: Duration = Duration::from_millis(6);

/// What the scheduler may be configured to.
pub fn configurations() -> [Config; 11] {
    [
        Config::REDRT,
        Config::RED,
        Config::RED_IDA,
        Config::RED_FG,
        Config::EDF,
        Config { late: Late::AbortJob, shed: Shed::Never, ..Config::REDRT },
        Config { preempt: true, ..Config::REDRT },
        Config { preempt: true, gate: Gate::Level, ..Config::RED },
        Config { admission: Admission::Enforce, ..Config::REDRT },
        Config::REDRT.with_memory(Bytes(4)),
        Config::REDRT_LOOKAHEAD,
    ]
}

/// One scheduler that hears what a clock says, and one whose clock never goes back; both must answer the same.
#[derive(Debug)]
pub struct Host {
    raw: Scheduler<Small>,
    held: Scheduler<Small>,
    now: Instant,
    back: u64,
    tasks: [TaskId; 2],
    edit: Option<Dag<Small>>,
    live: Vec<UnitId>,
    dead: Vec<UnitId>,
    retired: [bool; LANES],
    old_tasks: Vec<TaskId>,
    released: BTreeSet<JobId>,
    ended: BTreeSet<JobId>,
    last_unit: u64,
    jobs: Jobs,
    /// One of the two does not hear of failures while its clock is behind.
    planted: bool,
}

impl Host {
    /// Two schedulers, and two tasks in each.
    ///
    /// # Panics
    /// As all calls: if something is not as it should be.
    pub fn new(config: Config) -> Self {
        let new = || Scheduler::new(config.with_lanes(LANES as u8));
        let mut host = Self {
            raw: new(),
            held: new(),
            now: Instant::from_nanos(10_000_000),
            back: 0,
            tasks: [TaskId::from_bits(0); 2],
            edit: None,
            live: Vec::new(),
            dead: Vec::new(),
            retired: [false; LANES],
            old_tasks: Vec::new(),
            released: BTreeSet::new(),
            ended: BTreeSet::new(),
            last_unit: 0,
            jobs: Jobs::default(),
            planted: false,
        };
        assert_eq!(host.tell_time(), 0);
        host.tasks = [host.add(), host.add()];
        host
    }

    /// The same with a bug, which is to be found.
    #[must_use]
    pub fn with_planted_bug(self) -> Self {
        Self { planted: true, ..self }
    }

    /// Makes one call, and checks what must hold whatever it was.
    ///
    /// # Panics
    /// If something is not as it should be.
    pub fn call(&mut self, call: Call) {
        match call {
            Call::Wait(us) => self.go_to(self.now.saturating_add(Duration::from_micros(us))),
            Call::Leap(bits) => self.go_to(self.now.saturating_add(Duration::from_nanos(1 << (bits % 63)))),
            Call::StepBack(us) => {
                self.back = us.clamp(1, 5_000) * 1_000;
                assert_eq!(self.tell_time(), 1);
            }
            Call::Release(task) => self.release(task % 2, None, self.now),
            Call::Capture(task, capture, ago) => {
                let release = Instant::from_nanos(self.now.as_nanos().saturating_sub(ago * 1_000));
                self.release(task % 2, Some(capture % 3), release);
            }
            Call::Complete(which) => self.report(which, Scheduler::complete),
            Call::CompleteAndPoll(which) => self.report_and_poll(which),
            Call::Fail(which) => self.report(which, Scheduler::fail),
            Call::Again(which) => self.report_again(which),
            Call::Stranger(bits) => self.be_a_stranger(bits),
            Call::Remove(task) => self.remove(task % 2),
            Call::Edit(task, change) => self.change(task % 2, change),
            Call::Commit => self.commit(),
            Call::Retire(lane) => self.retire(lane),
            Call::Restore(lane) => self.restore(lane),
            Call::Take => {
                let outcome = self.both(|s, _| s.take_outcome());
                outcome.into_iter().for_each(|outcome| self.end(Action::Ended(outcome)));
            }
            Call::Poll => self.poll(),
            Call::PollOn(lane) => {
                let action = self.both(|s, now| s.poll_on(LaneId::new(lane), now));
                action.into_iter().for_each(|action| self.act(action));
            }
        }
        self.check();
    }

    /// Lets everything end: nothing is forgotten, and nothing is left.
    ///
    /// # Panics
    /// If something is not as it should be.
    pub fn finish(mut self) {
        (0..LANES as u8).for_each(|lane| self.call(Call::Restore(lane)));
        // Each round reports a unit. Time stands still, so that nothing is given up.
        for _ in 0..100 {
            self.call(Call::Poll);
            if self.live.is_empty() && self.raw.jobs_in_flight() == 0 {
                break;
            }
            self.call(Call::Complete(0));
        }
        assert_eq!(self.raw.jobs_in_flight(), 0, "a job never ends");
        assert_eq!(self.raw.memory_used(PoolId::new(0)), Bytes(0));
        assert_eq!(self.released, self.ended);
    }

    /// Calls both, the raw one at a time that may be before the last.
    fn both<T: PartialEq + Debug>(&mut self, mut f: impl FnMut(&mut Scheduler<Small>, Instant) -> T) -> T {
        let raw = f(&mut self.raw, Instant::from_nanos(self.now.as_nanos().saturating_sub(self.back)));
        let held = f(&mut self.held, self.now);
        assert_eq!(raw, held, "a clock that stepped back made a difference");
        while let Some(event) = self.raw.take_event() {
            assert_eq!(Some(event), self.held.take_event());
            self.jobs.see(event, &self.held);
        }
        assert_eq!(self.held.take_event(), None);
        assert_eq!(self.raw.events_dropped(), 0, "one call makes no more events than the record holds");
        raw
    }

    /// Tells both what time it is, with a handle that nobody has; how many steps back the raw one counts for it.
    fn tell_time(&mut self) -> u64 {
        let before = self.raw.counters().clock_steps_back;
        let refused = self.both(|s, now| s.complete(UnitId::from_bits(0), now));
        assert_eq!(refused, Err(CompleteError::NotRunning));
        assert_eq!(self.held.counters().clock_steps_back, 0);
        self.raw.counters().clock_steps_back - before
    }

    fn go_to(&mut self, now: Instant) {
        (self.now, self.back) = (now, 0);
        assert_eq!(self.tell_time(), 0);
    }

    fn add(&mut self) -> TaskId {
        let timing = Timing::new(DEADLINE).floor(1, 3);
        self.both(|s, _| s.add_task(&graph(), timing).expect("there is room"))
    }

    fn release(&mut self, task: usize, capture: Option<u64>, release: Instant) {
        let id = self.tasks[task];
        let due = release.checked_add(DEADLINE).filter(|due| due.as_nanos() <= i64::MAX as u64);
        match self.both(|s, now| s.release_at(id, release, capture, now)) {
            Ok(job) => {
                assert!(self.released.insert(job), "{job:?} was another job's name");
                assert!(due.is_some());
            }
            // Beside the table there is room for one outcome of a job whose place was taken.
            Err(ReleaseError::Full) => assert!(matches!(self.released.len() - self.ended.len(), 3 | 4)),
            Err(error) => assert!(error == ReleaseError::Overflow && due.is_none(), "{error}"),
        }
    }

    fn report(
        &mut self,
        which: usize,
        say: fn(&mut Scheduler<Small>, UnitId, Instant) -> Result<(), CompleteError>,
    ) {
        let Some(unit) = self.take_live(which) else { return };
        if self.planted && self.back > 0 {
            let _unheard = say(&mut self.held, unit, self.now);
            return;
        }
        let answer = self.both(|s, now| say(s, unit, now));
        assert!(matches!(answer, Ok(()) | Err(CompleteError::Late)), "{answer:?}");
    }

    fn report_and_poll(&mut self, which: usize) {
        let Some(unit) = self.take_live(which) else { return };
        match self.both(|s, now| s.complete_and_poll(unit, now)) {
            Ok(action) => action.into_iter().for_each(|action| self.act(action)),
            Err(error) => assert_eq!(error, CompleteError::Late),
        }
    }

    fn report_again(&mut self, which: usize) {
        if self.dead.is_empty() {
            return;
        }
        let unit = self.dead[which % self.dead.len()];
        let before = self.seen();
        for say in [Scheduler::complete, Scheduler::fail] {
            assert_eq!(self.both(|s, now| say(s, unit, now)), Err(CompleteError::Stale));
        }
        assert!(self.raw.unit(unit).is_none() && self.raw.members(unit).next().is_none());
        assert_eq!(self.seen(), before);
    }

    /// Names from nowhere: refused, and nothing changes.
    fn be_a_stranger(&mut self, bits: u64) {
        let (unit, task) = (UnitId::from_bits(bits), TaskId::from_bits(bits as u32));
        let before = self.seen();
        if !self.live.contains(&unit) {
            let refused = |answer| matches!(answer, Err(CompleteError::Stale | CompleteError::NotRunning));
            assert!(refused(self.both(|s, now| s.complete(unit, now))));
            assert!(refused(self.both(|s, now| s.fail(unit, now))));
            assert!(self.raw.unit(unit).is_none() && self.raw.members(unit).next().is_none());
        }
        if !self.tasks.contains(&task) {
            assert_eq!(self.both(|s, now| s.release(task, now)), Err(ReleaseError::UnknownTask));
            assert!(!self.both(|s, now| s.remove_task(task, now)));
            assert!(self.raw.edit(task).is_none() && self.raw.certificate(task).is_none());
            assert!(self.raw.job_id(task, bits).is_none());
        }
        let (node, pool) = (NodeId::new(bits as u8), PoolId::new(bits as u8));
        let known = self.raw.edit(self.tasks[0]).is_some_and(|dag| dag.contains(node));
        assert!(!known || self.raw.task_node(self.tasks[0], node).is_some());
        assert!(pool == PoolId::new(0) || self.raw.memory_used(pool) == Bytes(0));
        assert_eq!(self.seen(), before);
    }

    fn remove(&mut self, task: usize) {
        let old = self.tasks[task];
        assert!(self.both(|s, now| s.remove_task(old, now)));
        assert!(!self.both(|s, now| s.remove_task(old, now)));
        self.old_tasks.push(old);
        self.tasks[task] = self.add();
        assert!(!self.old_tasks.contains(&self.tasks[task]));
        assert_eq!(self.both(|s, now| s.release(old, now)), Err(ReleaseError::UnknownTask));
        assert!(self.raw.edit(old).is_none() && self.raw.task_node(old, NodeId::new(0)).is_none());
    }

    fn change(&mut self, task: usize, change: Change) {
        let id = self.tasks[task];
        let mut dag = self.edit.take().unwrap_or_else(|| self.raw.edit(id).expect("the task is there"));
        apply(&mut dag, change);
        self.edit = Some(dag);
    }

    /// A commit is taken whole or refused whole.
    fn commit(&mut self) {
        let Some(edit) = self.edit.take() else { return };
        let shapes =
            |host: &Self| host.tasks.map(|task| shape(&host.raw.edit(task).expect("the task is there")));
        let before = shapes(self);
        let answer = self.both(|s, now| s.commit(&edit, now));
        let changed = shapes(self).into_iter().zip(before).filter(|(new, old)| new != old);
        let changed: Vec<_> = changed.map(|(new, _)| new).collect();
        match answer {
            Ok(_) => assert!(changed.is_empty() || changed == [shape(&edit)]),
            Err(error) => {
                assert!(changed.is_empty(), "{error}, and yet the graph is another");
                let may_be =
                    matches!(error, CommitError::UnknownTask | CommitError::Conflict | CommitError::Busy);
                assert!(may_be || error != CommitError::Empty || edit.is_empty());
            }
        }
    }

    fn retire(&mut self, lane: u8) {
        let idle = usize::from(lane) < LANES && self.live.iter().all(|unit| unit.lane() != LaneId::new(lane));
        assert_eq!(self.both(|s, _| s.retire_lane(LaneId::new(lane))), idle);
        if idle {
            self.retired[usize::from(lane)] = true;
        }
    }

    fn restore(&mut self, lane: u8) {
        let was = self.retired.get_mut(usize::from(lane)).is_some_and(std::mem::take);
        assert_eq!(self.both(|s, _| s.restore_lane(LaneId::new(lane))), was);
    }

    fn poll(&mut self) {
        while let Some(action) = self.both(|s, now| s.poll(now)) {
            self.act(action);
        }
        let due = self.held.poll_at();
        assert!(due.is_none_or(|at| at > self.now), "a host that sleeps until {due:?} never sleeps");
        // A head that does not fit into memory leaves a lane idle.
        let limited = self.raw.config().memory.is_some();
        let usable = self.retired.iter().filter(|retired| !**retired).count();
        let idles = self.live.len() < usable && self.raw.ready_sub_jobs() > 0;
        // So does one that waits for another sub-job, until an instant that is told or what runs ends.
        let may_wait = self.raw.config().gate == Gate::Lookahead || self.raw.config().shed == Shed::Hopeless;
        let waits = may_wait && (due.is_some() || !self.live.is_empty());
        assert!(limited || waits || !idles, "a lane idles beside a ready sub-job");
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Dispatch(started) => {
                let sequence = started.unit.to_bits() >> 16;
                assert!(sequence > self.last_unit, "{started:?} was another unit's handle");
                self.last_unit = sequence;
                assert!(self.live.iter().all(|unit| unit.lane() != started.lane));
                assert!(!self.retired[started.lane.index()], "{started:?} on a lane that is lost");
                let unit = self.raw.unit(started.unit).expect("it runs");
                assert_eq!(unit.lane, started.lane);
                self.live.push(started.unit);
            }
            Action::Preempt(stopped) => {
                assert!(self.raw.config().preempt);
                let at = self.live.iter().position(|unit| *unit == stopped.unit).expect("it ran");
                self.dead.push(self.live.swap_remove(at));
            }
            ended => self.end(ended),
        }
    }

    fn end(&mut self, action: Action) {
        let Action::Ended(outcome) = action else { panic!("nobody asked for {action:?}") };
        assert!(self.ended.insert(outcome.job), "{outcome:?} twice");
        assert!((outcome.release..=self.now).contains(&outcome.at));
        assert!(self.released.contains(&outcome.job));
    }

    fn take_live(&mut self, which: usize) -> Option<UnitId> {
        let at = which.checked_rem(self.live.len())?;
        let unit = self.live.swap_remove(at);
        self.dead.push(unit);
        Some(unit)
    }

    fn seen(&self) -> [usize; 3] {
        [self.raw.jobs_in_flight(), self.raw.ready_sub_jobs(), self.raw.running_units()]
    }

    fn check(&self) {
        assert_eq!(self.raw.running_units(), self.live.len(), "units that run, and those that the host has");
        assert_eq!(self.raw.jobs_in_flight(), self.jobs.in_flight());
        let budget = self.raw.config().memory.unwrap_or(Bytes(0));
        assert!(self.raw.memory_used(PoolId::new(0)) <= budget, "more memory than there is");
        assert!(self.ended.is_subset(&self.released));
    }
}
