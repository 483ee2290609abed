//! Set-up and graph changes by calls. A graph does not fit an entry, so its parts come before the call that takes it.

use super::Recorder;
use crate::entry::{Answer, Call};
use red_core::{
    AddTaskError, Bytes, Capacity, Certificate, CommitError, Dag, Duration, Instant, PoolError, PoolId, Ppm,
    SensorError, SensorId, TaskId, Timing,
};

/// Words of 64 places each that hold every node.
const GROUPS: usize = 4;

/// The tape's part of these calls is O(1), and O(nodes + edges) with a graph: at most five entries for each of its nodes.
impl<C: Capacity> Recorder<'_, C> {
    /// [`Scheduler::add_pool`](red_core::Scheduler::add_pool). Errors: as there.
    pub fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
        let answer = self.scheduler.add_pool(lanes, memory);
        self.tell(None, Call::AddPool { lanes, memory }, Answer::Pool(answer));
        answer
    }

    /// [`Scheduler::dispatch_ahead`](red_core::Scheduler::dispatch_ahead).
    pub fn dispatch_ahead(&mut self, pool: PoolId) -> bool {
        let answer = self.scheduler.dispatch_ahead(pool);
        self.tell(None, Call::DispatchAhead(pool), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::observe_use`](red_core::Scheduler::observe_use).
    pub fn observe_use(&mut self, pool: PoolId, used: Ppm) -> bool {
        let answer = self.scheduler.observe_use(pool, used);
        self.tell(None, Call::ObserveUse(pool, used), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::lose_pool`](red_core::Scheduler::lose_pool).
    pub fn lose_pool(&mut self, pool: PoolId, now: Instant) -> bool {
        let answer = self.scheduler.lose_pool(pool, now);
        self.tell(Some(now), Call::LosePool(pool), Answer::Done(answer));
        answer
    }

    /// [`Scheduler::add_sensor`](red_core::Scheduler::add_sensor). Errors: as there.
    pub fn add_sensor(&mut self, period: Duration) -> Result<SensorId, SensorError> {
        let answer = self.scheduler.add_sensor(period);
        self.tell(None, Call::AddSensor(period), Answer::Sensor(answer));
        answer
    }

    /// [`Scheduler::add_task`](red_core::Scheduler::add_task). Errors: as there.
    pub fn add_task(&mut self, dag: &Dag<C>, timing: Timing) -> Result<TaskId, AddTaskError> {
        let answer = self.scheduler.add_task(dag, timing);
        let (deadline, period, value, floor) = timing.parts();
        self.tell_graph(None, dag);
        self.tell(None, Call::AddTask { deadline, period, value, floor }, Answer::Task(answer));
        answer
    }

    /// [`Scheduler::commit`](red_core::Scheduler::commit) of a graph from this scheduler's own
    /// [`edit`](red_core::Scheduler::edit), which only asks and so is no entry. Errors: as there.
    pub fn commit(&mut self, edit: &Dag<C>, now: Instant) -> Result<Certificate, CommitError> {
        let answer = self.scheduler.commit(edit, now);
        let (task, revision) = edit.origin();
        self.tell_graph(Some(now), edit);
        self.tell(Some(now), Call::Commit { task, revision }, Answer::Committed(answer));
        answer
    }

    /// Node by node with its edges, in the order of their places.
    fn tell_graph(&mut self, now: Option<Instant>, dag: &Dag<C>) {
        if self.tape.is_none() {
            return;
        }
        for place in dag.nodes() {
            let Some(node) = dag.node(place) else { continue };
            self.tell(now, Call::Node { place, node: *node }, Answer::Nothing);
            let mut groups = [0; GROUPS];
            dag.successors(place).each(|to| groups[to / 64 % GROUPS] |= 1 << (to % 64));
            for (group, to) in (0..).zip(groups).filter(|(_, to)| *to != 0) {
                self.tell(now, Call::Edges { from: place, group, to }, Answer::Nothing);
            }
        }
    }

    fn tell(&mut self, now: Option<Instant>, call: Call, answer: Answer) {
        if let Some(tape) = &mut self.tape {
            tape.starts().told(&call);
        }
        match now {
            Some(now) => self.put(now, call, answer),
            None => self.untimed(call, answer),
        }
    }
}
