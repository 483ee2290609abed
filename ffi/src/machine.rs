//! A scheduler of any class.

use crate::action::{red_action, red_action_kind, red_outcome};
use crate::boundary::{Memory, Out};
use crate::dag::open_dag;
use crate::event::red_figures;
use crate::graph::AnyGraph;
use crate::status::{red_status, status};
use crate::values::red_dag;
use red_core::{
    Action, Bytes, Capacity, Certificate, CompleteError, Config, Dag, Dispatch, Duration, Empty, Estimator,
    Event, Instant, JobId, LaneId, Member, NodeId, Outcome, PoolError, PoolId, ReleaseError, Role, Scheduler,
    SensorError, SensorId, TaskId, Timing, Unit, UnitId,
};

/// A scheduler, and what this library keeps beside it.
pub(crate) struct Host<C: Capacity> {
    scheduler: Scheduler<C>,
    /// Pools after the first, and sensors, that were added.
    more_pools: u32,
    sensors: usize,
}

impl<C: Capacity> Host<C> {
    /// To be configured in its place: a scheduler of the largest class is larger than many stacks.
    pub(crate) const NEW: Self = Self { scheduler: Empty::EMPTY, more_pools: 0, sensors: 0 };

    pub(crate) fn configure(&mut self, config: Config) {
        self.scheduler.configure(config);
    }

    /// A graph of this class whose sensors are there.
    fn graph<'a>(&self, graph: &'a AnyGraph) -> Result<&'a Dag<C>, red_status> {
        let dag = graph.any().downcast_ref::<Dag<C>>().ok_or(red_status::OtherClass)?;
        let unknown = |id: NodeId| match dag.node(id).map(red_core::Node::role) {
            Some(Role::SharedEncoder(frame)) => {
                frame.sensor.is_some_and(|sensor| sensor.index() >= self.sensors)
            }
            _ => false,
        };
        if dag.nodes().any(unknown) { Err(red_status::UnknownSensor) } else { Ok(dag) }
    }
}

/// A scheduler behind a handle.
pub(crate) type AnyMachine = dyn Machine;

/// The calls of a [`Scheduler`], whatever its capacity is. Those of the loop write their answers where C wants them.
pub(crate) trait Machine {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError>;
    fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError>;
    fn add_task(&mut self, graph: &AnyGraph, timing: Timing) -> Result<TaskId, red_status>;
    fn remove_task(&mut self, task: TaskId, now: Instant) -> bool;
    fn edit(&self, task: TaskId, memory: Memory) -> Result<red_dag, red_status>;
    fn commit(&mut self, graph: &AnyGraph, now: Instant) -> Result<Certificate, red_status>;
    fn certificate(&self, task: TaskId) -> Option<Certificate>;
    fn release_at(
        &mut self,
        task: TaskId,
        release: Instant,
        capture: Option<u64>,
        now: Instant,
    ) -> Result<JobId, ReleaseError>;
    fn poll(&mut self, now: Instant, to: Out<red_action>);
    fn poll_on(&mut self, lane: LaneId, now: Instant, to: Out<red_action>);
    fn complete(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError>;
    fn complete_and_poll(&mut self, unit: UnitId, now: Instant, to: Out<red_action>) -> red_status;
    fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError>;
    fn take_outcome(&mut self) -> Option<Outcome>;
    fn take_event(&mut self) -> Option<&Event>;
    fn retire_lane(&mut self, lane: LaneId) -> bool;
    fn restore_lane(&mut self, lane: LaneId) -> bool;
    fn poll_at(&self) -> Option<Instant>;
    fn unit(&self, unit: UnitId) -> Option<Unit>;
    fn members(&self, unit: UnitId, each: &mut dyn FnMut(Member));
    fn job_id(&self, task: TaskId, index: u64) -> Option<JobId>;
    fn executions(&self, task: TaskId, node: NodeId) -> Option<&Estimator>;
    fn pools(&self) -> u32;
    fn memory_used(&self, pool: PoolId) -> Bytes;
    fn config(&self) -> &Config;
    fn figures(&self) -> red_figures;
}

/// An action as C has it.
#[inline(always)]
fn action(action: Option<Action>) -> red_action {
    let unit = |kind: red_action_kind, dispatch: Dispatch| red_action {
        kind: kind as u32,
        lane: dispatch.lane.index() as u32,
        unit: dispatch.unit.to_bits(),
        outcome: red_outcome::EMPTY,
    };
    match action {
        Some(Action::Dispatch(dispatch)) => unit(red_action_kind::Dispatch, dispatch),
        Some(Action::Preempt(dispatch)) => unit(red_action_kind::Preempt, dispatch),
        Some(Action::Ended(outcome)) => {
            red_action { kind: red_action_kind::Ended as u32, outcome: outcome.into(), ..red_action::EMPTY }
        }
        _ => red_action::EMPTY,
    }
}

impl<C: Capacity> Machine for Host<C> {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
        let pool = self.scheduler.add_pool(lanes, memory)?;
        self.more_pools += 1;
        Ok(pool)
    }

    fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError> {
        let sensor = self.scheduler.add_sensor(period)?;
        self.sensors = self.sensors.max(sensor.index() + 1);
        Ok(sensor)
    }

    fn add_task(&mut self, graph: &AnyGraph, timing: Timing) -> Result<TaskId, red_status> {
        Ok(self.scheduler.add_task(self.graph(graph)?, timing)?)
    }

    fn remove_task(&mut self, task: TaskId, now: Instant) -> bool {
        self.scheduler.remove_task(task, now)
    }

    fn edit(&self, task: TaskId, memory: Memory) -> Result<red_dag, red_status> {
        open_dag(&memory.room_for()?, self.scheduler.edit(task).ok_or(red_status::UnknownTask)?)
    }

    fn commit(&mut self, graph: &AnyGraph, now: Instant) -> Result<Certificate, red_status> {
        Ok(self.scheduler.commit(self.graph(graph)?, now)?)
    }

    fn certificate(&self, task: TaskId) -> Option<Certificate> {
        self.scheduler.certificate(task)
    }

    fn release_at(
        &mut self,
        task: TaskId,
        release: Instant,
        capture: Option<u64>,
        now: Instant,
    ) -> Result<JobId, ReleaseError> {
        self.scheduler.release_at(task, release, capture, now)
    }

    fn poll(&mut self, now: Instant, to: Out<red_action>) {
        to.put(action(self.scheduler.poll(now)));
    }

    fn poll_on(&mut self, lane: LaneId, now: Instant, to: Out<red_action>) {
        to.put(action(self.scheduler.poll_on(lane, now)));
    }

    fn complete(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        self.scheduler.complete(unit, now)
    }

    fn complete_and_poll(&mut self, unit: UnitId, now: Instant, to: Out<red_action>) -> red_status {
        status(self.scheduler.complete_and_poll(unit, now), |next| to.put(action(next)))
    }

    fn fail(&mut self, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
        self.scheduler.fail(unit, now)
    }

    fn take_outcome(&mut self) -> Option<Outcome> {
        self.scheduler.take_outcome()
    }

    fn take_event(&mut self) -> Option<&Event> {
        self.scheduler.take_event()
    }

    fn retire_lane(&mut self, lane: LaneId) -> bool {
        self.scheduler.retire_lane(lane)
    }

    fn restore_lane(&mut self, lane: LaneId) -> bool {
        self.scheduler.restore_lane(lane)
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

    fn job_id(&self, task: TaskId, index: u64) -> Option<JobId> {
        self.scheduler.job_id(task, index)
    }

    fn executions(&self, task: TaskId, node: NodeId) -> Option<&Estimator> {
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
        let (now, so_far) = (&self.scheduler, self.scheduler.counters());
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
}
