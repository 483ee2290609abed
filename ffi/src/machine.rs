//! A scheduler of any class.

use crate::action::{red_action, red_action_head, red_action_kind};
use crate::boundary::{Memory, Out, Room};
use crate::dag::open_dag;
use crate::event::{red_event, red_figures};
use crate::graph::AnyGraph;
use crate::guard::Guarded;
use crate::log::{Log, Logged, calls};
use crate::status::{flat, red_status, status};
use crate::values::{RED_NONE_64, red_dag};
use crate::warning::red_warning;
use red_core::{
    Action, Bytes, Capacity, Certificate, CompleteError, Config, Dag, Dispatch, Duration, Empty, Estimator,
    Instant, JobId, LaneId, Member, NodeId, Outcome, PoolError, PoolId, Scheduler, SensorError, SensorId,
    TaskId, Timing, Unit, UnitId,
};

/// Makes a call that changes the scheduler, on `calls`. What comes of it is best used there, too: the call is compiled twice, and
/// without a log nothing of one is in its way. That is why this is no function: a closure with two callers is not inlined.
macro_rules! call {
    ($host:expr, |$calls:ident| $call:expr) => {{
        let host = &mut *$host;
        let (log, scheduler) = (&mut host.log, &mut host.scheduler);
        match log.tape() {
            None => {
                let $calls = &mut calls(scheduler, None);
                $call
            }
            tape => apart(move || {
                let $calls = &mut calls(scheduler, tape);
                $call
            }),
        }
    }};
}

#[inline(never)]
fn apart<R>(call: impl FnOnce() -> R) -> R {
    call()
}

/// A scheduler, and what this library keeps beside it.
#[repr(C)] // Every call looks at the log: beside what it touches first.
pub(crate) struct Host<C: Capacity> {
    pub(crate) log: Log,
    pub(crate) scheduler: Scheduler<C>,
    /// Whether anything was set up, so that a log would not have it.
    pub(crate) is_begun: bool,
    /// Pools after the first that were added.
    more_pools: u32,
}

impl<C: Capacity> Host<C> {
    /// To be configured in its place: a scheduler of the largest class is larger than many stacks.
    pub(crate) const NEW: Self =
        Self { scheduler: Empty::EMPTY, log: Log::NONE, is_begun: false, more_pools: 0 };

    pub(crate) fn configure(&mut self, config: Config) {
        self.scheduler.configure(config);
    }

    /// A graph of this class.
    fn graph(graph: &AnyGraph) -> Result<&Dag<C>, red_status> {
        graph.any().downcast_ref::<Dag<C>>().ok_or(red_status::OtherClass)
    }
}

/// A scheduler in memory of C's.
pub(crate) type Shared<C> = Guarded<Host<C>>;

impl<C: Capacity> Shared<C> {
    /// A constant, so that it is made where it lies and not on the stack first.
    #[expect(clippy::declare_interior_mutable_const, reason = "each scheduler is one of its own")]
    pub(crate) const NEW: Self = Self::new(Host::NEW);
}

/// A scheduler behind a handle.
pub(crate) type AnyMachine = dyn Loop;
/// Its calls that are not of the loop.
pub(crate) type Rest = dyn Machine;

/// The other calls of a [`Scheduler`], whatever its capacity is.
pub(crate) trait Machine: Logged {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError>;
    fn dispatch_ahead(&mut self, pool: PoolId) -> bool;
    fn lose_pool(&mut self, pool: PoolId, now: Instant) -> bool;
    fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError>;
    fn add_task(&mut self, graph: &AnyGraph, timing: Timing) -> Result<TaskId, red_status>;
    fn remove_task(&mut self, task: TaskId, now: Instant) -> bool;
    /// Begun on the scheduler of handle `bits`.
    fn edit(&self, bits: u64, task: TaskId, memory: Memory, out: Out<red_dag>) -> Result<(), red_status>;
    /// On the scheduler of handle `bits`.
    fn commit(&mut self, bits: u64, graph: &AnyGraph, now: Instant) -> Result<Certificate, red_status>;
    fn certificate(&self, task: TaskId) -> Option<Certificate>;
    fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError>;
    fn take_outcome(&mut self) -> Option<Outcome>;
    fn take_warning(&mut self) -> Option<red_warning>;
    fn retire_lane(&mut self, lane: LaneId) -> bool;
    fn restore_lane(&mut self, lane: LaneId) -> bool;
    fn poll_at(&self) -> Option<Instant>;
    fn unit(&self, unit: UnitId) -> Option<Unit>;
    fn members(&self, unit: UnitId, each: &mut dyn FnMut(Member));
    fn waits_for(&self, unit: UnitId, each: &mut dyn FnMut(UnitId));
    fn job_id(&self, task: TaskId, index: u64) -> Option<JobId>;
    fn executions(&self, task: TaskId, node: NodeId) -> Option<Estimator>;
    fn pools(&self) -> u32;
    fn memory_used(&self, pool: PoolId) -> Bytes;
    fn config(&self) -> &Config;
    fn figures(&self) -> red_figures;
}

/// The calls of the loop, which are made for every node: one jump from the function of the header, and nothing between
/// that and the scheduler.
pub(crate) trait Loop {
    fn rest(&self) -> &Guarded<Rest>;
    extern "C" fn release_at(
        &self,
        task: u32,
        release_ns: u64,
        capture: u64,
        now_ns: u64,
        job: *mut u32,
    ) -> red_status;
    extern "C" fn poll(&self, now_ns: u64, action: *mut red_action) -> red_status;
    extern "C" fn poll_on(&self, lane: u32, now_ns: u64, action: *mut red_action) -> red_status;
    extern "C" fn complete(&self, unit: u64, now_ns: u64) -> red_status;
    extern "C" fn complete_and_poll(&self, unit: u64, now_ns: u64, action: *mut red_action) -> red_status;
    extern "C" fn take_events(&self, events: *mut red_event, room: usize, count: *mut usize) -> red_status;
}

/// Writes an action where C wants it. The outcome is written where there is one.
#[inline(always)]
fn put(action: Option<Action>, to: Out<red_action>) {
    let unit = |kind: red_action_kind, dispatch: Dispatch| {
        // The lane that the unit has in its name, so that there is one number to write and not two.
        let (lane, unit) = (dispatch.unit.lane().index() as u32, dispatch.unit.to_bits());
        to.head().put(red_action_head { kind: kind as u32, lane, unit });
    };
    match action {
        Some(Action::Dispatch(dispatch)) => unit(red_action_kind::Dispatch, dispatch),
        Some(Action::Ahead(dispatch)) => unit(red_action_kind::Ahead, dispatch),
        Some(Action::Preempt(dispatch)) => unit(red_action_kind::Preempt, dispatch),
        Some(Action::Ended(outcome)) => {
            to.put(red_action {
                kind: red_action_kind::Ended as u32,
                outcome: outcome.into(),
                ..red_action::EMPTY
            });
        }
        _ => to.head().put(red_action_head::EMPTY),
    }
}

impl<C: Capacity> Loop for Shared<C> {
    fn rest(&self) -> &Guarded<Rest> {
        self
    }

    extern "C" fn release_at(
        &self,
        task: u32,
        release_ns: u64,
        capture: u64,
        now_ns: u64,
        job: *mut u32,
    ) -> red_status {
        flat(self.enter().and_then(|mut host| {
            let out = Out::of(job)?;
            let capture = (capture != RED_NONE_64).then_some(capture);
            let (release, now) = (Instant::from_nanos(release_ns), Instant::from_nanos(now_ns));
            let task = TaskId::from_bits(task);
            let put = |id: JobId| out.put(id.to_bits());
            Ok(call!(host, |calls| status(calls.release_at(task, release, capture, now), put)))
        }))
    }

    extern "C" fn poll(&self, now_ns: u64, action: *mut red_action) -> red_status {
        flat(self.enter().and_then(|mut host| {
            let out = Out::of(action)?;
            call!(host, |calls| put(calls.poll(Instant::from_nanos(now_ns)), out));
            Ok(red_status::Ok)
        }))
    }

    extern "C" fn poll_on(&self, lane: u32, now_ns: u64, action: *mut red_action) -> red_status {
        flat(self.enter().and_then(|mut host| {
            let out = Out::of(action)?;
            if lane as usize >= host.scheduler.lanes() {
                return Err(red_status::UnknownLane);
            }
            let lane = LaneId::new(lane as u8);
            call!(host, |calls| put(calls.poll_on(lane, Instant::from_nanos(now_ns)), out));
            Ok(red_status::Ok)
        }))
    }

    extern "C" fn complete(&self, unit: u64, now_ns: u64) -> red_status {
        flat(self.enter().map(|mut host| {
            let (unit, now) = (UnitId::from_bits(unit), Instant::from_nanos(now_ns));
            call!(host, |calls| status(calls.complete(unit, now), drop))
        }))
    }

    extern "C" fn complete_and_poll(&self, unit: u64, now_ns: u64, action: *mut red_action) -> red_status {
        flat(self.enter().and_then(|mut host| {
            let out = Out::of(action)?;
            let (unit, now) = (UnitId::from_bits(unit), Instant::from_nanos(now_ns));
            Ok(call!(host, |calls| status(calls.complete_and_poll(unit, now), |next| put(next, out))))
        }))
    }

    extern "C" fn take_events(&self, events: *mut red_event, room: usize, count: *mut usize) -> red_status {
        flat(self.enter().and_then(|mut host| {
            Room::of(events, room, count)?
                .take(|| call!(host, |calls| calls.take_event().map(red_event::from)));
            Ok(red_status::Ok)
        }))
    }
}

/// A lane of this number; whether it exists is for the scheduler to say.
pub(crate) fn lane_id(number: u32) -> Result<LaneId, red_status> {
    u8::try_from(number).map(LaneId::new).map_err(|_| red_status::UnknownLane)
}

impl<C: Capacity> Machine for Host<C> {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
        let pool = call!(self, |calls| calls.add_pool(lanes, memory))?;
        self.is_begun = true;
        self.more_pools += 1;
        Ok(pool)
    }

    fn dispatch_ahead(&mut self, pool: PoolId) -> bool {
        let is_ahead = call!(self, |calls| calls.dispatch_ahead(pool));
        self.is_begun |= is_ahead;
        is_ahead
    }

    fn lose_pool(&mut self, pool: PoolId, now: Instant) -> bool {
        let is_lost = call!(self, |calls| calls.lose_pool(pool, now));
        self.is_begun |= is_lost;
        is_lost
    }

    fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError> {
        let sensor = call!(self, |calls| calls.add_sensor(period))?;
        self.is_begun = true;
        Ok(sensor)
    }

    fn add_task(&mut self, graph: &AnyGraph, timing: Timing) -> Result<TaskId, red_status> {
        let dag = Self::graph(graph)?;
        let task = call!(self, |calls| calls.add_task(dag, timing))?;
        self.is_begun = true;
        Ok(task)
    }

    fn remove_task(&mut self, task: TaskId, now: Instant) -> bool {
        call!(self, |calls| calls.remove_task(task, now))
    }

    fn edit(&self, bits: u64, task: TaskId, memory: Memory, out: Out<red_dag>) -> Result<(), red_status> {
        open_dag(&memory.room_for()?, self.scheduler.edit(task).ok_or(red_status::UnknownTask)?, bits, out)
    }

    fn commit(&mut self, bits: u64, graph: &AnyGraph, now: Instant) -> Result<Certificate, red_status> {
        let dag = Self::graph(graph)?;
        graph.may_change(bits)?;
        Ok(call!(self, |calls| calls.commit(dag, now))?)
    }

    fn certificate(&self, task: TaskId) -> Option<Certificate> {
        self.scheduler.certificate(task)
    }

    fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        call!(self, |calls| calls.fail(unit, now))
    }

    fn take_outcome(&mut self) -> Option<Outcome> {
        call!(self, |calls| calls.take_outcome())
    }

    fn take_warning(&mut self) -> Option<red_warning> {
        let warning = self.scheduler.take_warning()?;
        Some(red_warning::of(&warning, self.scheduler.now()))
    }

    fn retire_lane(&mut self, lane: LaneId) -> bool {
        let is_retired = call!(self, |calls| calls.retire_lane(lane));
        self.is_begun |= is_retired;
        is_retired
    }

    fn restore_lane(&mut self, lane: LaneId) -> bool {
        call!(self, |calls| calls.restore_lane(lane))
    }

    fn poll_at(&self) -> Option<Instant> {
        self.scheduler.poll_at()
    }

    fn unit(&self, unit: UnitId) -> Option<Unit> {
        self.scheduler.unit(unit)
    }

    fn members(&self, unit: UnitId, each: &mut dyn FnMut(Member)) {
        self.scheduler.members(unit).for_each(each);
    }

    fn waits_for(&self, unit: UnitId, each: &mut dyn FnMut(UnitId)) {
        self.scheduler.waits_for(unit).for_each(each);
    }

    fn job_id(&self, task: TaskId, index: u64) -> Option<JobId> {
        self.scheduler.job_id(task, index)
    }

    fn executions(&self, task: TaskId, node: NodeId) -> Option<Estimator> {
        self.scheduler.task_node(task, node).map(|(_, executions)| executions)
    }

    fn pools(&self) -> u32 {
        1 + self.more_pools
    }

    fn memory_used(&self, pool: PoolId) -> Bytes {
        self.scheduler.memory_used(pool)
    }

    fn config(&self) -> &Config {
        self.scheduler.config()
    }

    fn figures(&self) -> red_figures {
        figures(&self.scheduler)
    }
}

/// What a scheduler says of itself.
pub(crate) fn figures<C: Capacity>(now: &Scheduler<C>) -> red_figures {
    let so_far = now.counters();
    red_figures {
        units: so_far.units,
        encoder_runs_saved: so_far.encoder_runs_saved,
        overruns: so_far.overruns,
        clock_steps_back: so_far.clock_steps_back,
        late_completions: so_far.late_completions,
        evictions: so_far.evictions,
        events_dropped: now.events_dropped(),
        lanes: now.lanes() as u32,
        jobs_in_flight: now.jobs_in_flight() as u32,
        ready: now.ready_sub_jobs() as u32,
        running: now.running_units() as u32,
        can_dispatch: now.can_dispatch().into(),
        ..red_figures::EMPTY
    }
}
