//! Every public call of core and synchronizers under a name of its own, for capacities small and large. Nothing here
//! is run: `cargo xtask test symbols` looks at what the compiled calls can reach, and asks for an entry
//! `red_<capacity>_<Type>_<call>` of each public function that it reads in the sources.
#![cfg_attr(target_os = "none", no_std)]
#![allow(unsafe_code, reason = "names in an object file are a promise that nobody else has them")]

#[cfg(target_os = "none")]
mod bare;
mod planted;
mod sync;
mod values;

use red_core::{
    Action, Bytes, Capacity, Caps, Certificate, CommitError, CompleteError, Config, Counters, Dag,
    DeadlineRule, Duration, EdgeError, Estimator, Event, Instant, JobId, LaneId, LevelShare, Levels, Member,
    Node, NodeError, NodeId, NodeSet, Outcome, PoolError, PoolId, Ppm, RefineError, Refined, ReleaseError,
    Scheduler, SensorError, SensorId, SubDeadlines, TaskId, Timing, Unit, UnitId, Warning,
};

/// Functions with names in the object: `red_` and the given words.
macro_rules! entries {
    ($prefix:literal; $(fn $name:ident($($argument:ident: $t:ty),*) $(-> $out:ty)? $body:block)*) => { $(
        #[unsafe(export_name = concat!("red_", $prefix, "_", stringify!($name)))]
        fn $name($($argument: $t),*) $(-> $out)? $body
    )* };
}
pub(crate) use entries;

/// All calls that are generic over the capacity.
macro_rules! calls {
    ($module:ident, $prefix:literal, $caps:ty) => {
        #[expect(non_snake_case, reason = "an entry is the name of a type and that of its call")]
        mod $module {
            use super::*;
            type C = $caps;
            type S = Scheduler<C>;
            type Row<T> = <C as Capacity>::Nodes<T>;

            entries! { $prefix;
                fn Scheduler_new(config: Config) -> S { S::new(config) }
                fn Scheduler_configure(s: &mut S, config: Config) { s.configure(config) }
                fn Scheduler_add_pool(s: &mut S, lanes: u8, memory: Option<Bytes>) -> Result<PoolId, PoolError> {
                    s.add_pool(lanes, memory)
                }
                fn Scheduler_dispatch_ahead(s: &mut S, pool: PoolId) -> bool { s.dispatch_ahead(pool) }
                fn Scheduler_lose_pool(s: &mut S, pool: PoolId, now: Instant) -> bool { s.lose_pool(pool, now) }
                fn Scheduler_observe_use(s: &mut S, pool: PoolId, used: Ppm) -> bool { s.observe_use(pool, used) }
                fn Scheduler_pool_of(s: &S, lane: LaneId) -> Option<PoolId> { s.pool_of(lane) }
                fn Scheduler_waits_for(s: &S, unit: UnitId) -> Option<UnitId> { s.waits_for(unit).last() }
                fn Scheduler_add_sensor(s: &mut S, period: Duration) -> Result<SensorId, SensorError> {
                    s.add_sensor(period)
                }
                fn Scheduler_memory_used(s: &S, pool: PoolId) -> Bytes { s.memory_used(pool) }
                fn Scheduler_add_task(s: &mut S, dag: &Dag<C>, timing: Timing) -> Option<TaskId> {
                    s.add_task(dag, timing).ok()
                }
                fn Scheduler_remove_task(s: &mut S, task: TaskId, now: Instant) -> bool { s.remove_task(task, now) }
                fn Scheduler_certificate(s: &S, task: TaskId) -> Option<Certificate> { s.certificate(task) }
                fn Scheduler_task_node(s: &S, task: TaskId, node: NodeId) -> Option<(&Node, Estimator)> {
                    s.task_node(task, node)
                }
                fn Scheduler_edit(s: &S, task: TaskId) -> Option<Dag<C>> { s.edit(task) }
                fn Scheduler_commit(s: &mut S, edit: &Dag<C>, now: Instant) -> Result<Certificate, CommitError> {
                    s.commit(edit, now)
                }
                fn Scheduler_release(s: &mut S, task: TaskId, now: Instant) -> Result<JobId, ReleaseError> {
                    s.release(task, now)
                }
                fn Scheduler_release_at(
                    s: &mut S, task: TaskId, release: Instant, capture: Option<u64>, now: Instant
                ) -> Result<JobId, ReleaseError> {
                    s.release_at(task, release, capture, now)
                }
                fn Scheduler_complete(s: &mut S, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
                    s.complete(unit, now)
                }
                fn Scheduler_fail(s: &mut S, unit: UnitId, now: Instant) -> Result<(), CompleteError> {
                    s.fail(unit, now)
                }
                fn Scheduler_complete_and_poll(
                    s: &mut S, unit: UnitId, now: Instant
                ) -> Result<Option<Action>, CompleteError> {
                    s.complete_and_poll(unit, now)
                }
                fn Scheduler_poll(s: &mut S, now: Instant) -> Option<Action> { s.poll(now) }
                fn Scheduler_poll_on(s: &mut S, lane: LaneId, now: Instant) -> Option<Action> { s.poll_on(lane, now) }
                fn Scheduler_poll_at(s: &S) -> Option<Instant> { s.poll_at() }
                fn Scheduler_can_dispatch(s: &S) -> bool { s.can_dispatch() }
                fn Scheduler_unit(s: &S, unit: UnitId) -> Option<Unit> { s.unit(unit) }
                fn Scheduler_members(s: &S, unit: UnitId) -> Option<Member> { s.members(unit).last() }
                fn Scheduler_retire_lane(s: &mut S, lane: LaneId) -> bool { s.retire_lane(lane) }
                fn Scheduler_restore_lane(s: &mut S, lane: LaneId) -> bool { s.restore_lane(lane) }
                fn Scheduler_job_id(s: &S, task: TaskId, index: u64) -> Option<JobId> { s.job_id(task, index) }
                fn Scheduler_stood_still(s: &mut S, time: Duration, now: Instant) { s.stood_still(time, now) }
                fn Scheduler_take_warning(s: &mut S) -> Option<Warning> { s.take_warning() }
                fn Scheduler_take_outcome(s: &mut S) -> Option<Outcome> { s.take_outcome() }
                fn Scheduler_take_event(s: &mut S) -> Option<&Event> { s.take_event() }
                fn Scheduler_counters(s: &S) -> Counters { s.counters() }
                fn Scheduler_ready_sub_jobs(s: &S) -> usize { s.ready_sub_jobs() }
                fn Scheduler_running_units(s: &S) -> usize { s.running_units() }
                fn Scheduler_config(s: &S) -> &Config { s.config() }
                fn Scheduler_lanes(s: &S) -> usize { s.lanes() }
                fn Scheduler_jobs_in_flight(s: &S) -> usize { s.jobs_in_flight() }
                fn Scheduler_events_dropped(s: &S) -> u64 { s.events_dropped() }
                fn Scheduler_now(s: &S) -> Instant { s.now() }

                fn Dag_new() -> Dag<C> { Dag::new() }
                fn Dag_work(dag: &Dag<C>) -> u64 { dag.work() }
                fn Dag_add_node(dag: &mut Dag<C>, node: Node) -> Result<NodeId, NodeError> { dag.add_node(node) }
                fn Dag_add_edge(dag: &mut Dag<C>, from: NodeId, to: NodeId) -> Result<(), EdgeError> {
                    dag.add_edge(from, to)
                }
                fn Dag_remove_edge(dag: &mut Dag<C>, from: NodeId, to: NodeId) -> bool { dag.remove_edge(from, to) }
                fn Dag_remove_node(dag: &mut Dag<C>, node: NodeId) -> bool { dag.remove_node(node) }
                fn Dag_contains(dag: &Dag<C>, node: NodeId) -> bool { dag.contains(node) }
                fn Dag_node(dag: &Dag<C>, node: NodeId) -> Option<&Node> { dag.node(node) }
                fn Dag_nodes(dag: &Dag<C>) -> Option<NodeId> { dag.nodes().last() }
                fn Dag_successors(dag: &Dag<C>, node: NodeId) -> NodeSet<C> { dag.successors(node) }
                fn Dag_len(dag: &Dag<C>) -> usize { dag.len() }
                fn Dag_origin(dag: &Dag<C>) -> (TaskId, u32) { dag.origin() }
                fn Dag_is_empty(dag: &Dag<C>) -> bool { dag.is_empty() }
                fn refine(
                    dag: &Dag<C>, stage: NodeId, encoder: Node, decoders: &[Node]
                ) -> Result<Refined<C>, RefineError> {
                    red_core::refine(dag, stage, encoder, decoders)
                }

                fn NodeSet_insert(set: &mut NodeSet<C>, i: usize) { set.insert(i) }
                fn NodeSet_remove(set: &mut NodeSet<C>, i: usize) { set.remove(i) }
                fn NodeSet_contains(set: &NodeSet<C>, i: usize) -> bool { set.contains(i) }
                fn NodeSet_is_empty(set: &NodeSet<C>) -> bool { set.is_empty() }
                fn NodeSet_len(set: &NodeSet<C>) -> usize { set.len() }
                fn NodeSet_first_in(set: &NodeSet<C>, mask: &NodeSet<C>) -> Option<usize> { set.first_in(mask) }
                fn NodeSet_and(set: &NodeSet<C>, other: &NodeSet<C>) -> NodeSet<C> { set.and(other) }
                fn NodeSet_without(set: &NodeSet<C>, other: &NodeSet<C>) -> NodeSet<C> { set.without(other) }
                fn NodeSet_extend(set: &mut NodeSet<C>, other: &NodeSet<C>) { set.extend(other) }
                fn NodeSet_each(set: &NodeSet<C>, f: fn(usize)) { set.each(f) }
                fn NodeSet_iter(set: &NodeSet<C>) -> Option<usize> { set.iter().last() }

                fn Levels_of(dag: &Dag<C>) -> Levels<'_, C> { Levels::of(dag) }
                fn Levels_count(levels: &Levels<'_, C>) -> usize { levels.count() }
                fn Levels_height(levels: &Levels<'_, C>, node: NodeId) -> usize { levels.height(node) }
                fn Levels_tail(levels: &Levels<'_, C>, node: NodeId) -> u64 { levels.tail(node) }
                fn Levels_critical_path(levels: &Levels<'_, C>) -> u64 { levels.critical_path() }
                fn SubDeadlines_assign(
                    levels: &Levels<'_, C>, rule: DeadlineRule, deadline: Duration, lanes: &[u8]
                ) -> SubDeadlines<C> {
                    SubDeadlines::assign(levels, rule, deadline, lanes)
                }
                fn SubDeadlines_sub_deadline(due: &SubDeadlines<C>, node: NodeId) -> i64 { due.sub_deadline(node) }
                fn SubDeadlines_key(due: &SubDeadlines<C>, node: NodeId) -> i64 { due.key(node) }
                fn shares(
                    levels: &Levels<'_, C>, rule: DeadlineRule, deadline: Duration, lanes: &[u8]
                ) -> Row<LevelShare> {
                    red_core::shares(levels, rule, deadline, lanes)
                }
                fn response_time(
                    levels: &Levels<'_, C>, limit: Duration, lanes: &[u8], budgets: &[Option<Bytes>]
                ) -> Certificate {
                    red_core::response_time(levels, limit, lanes, budgets)
                }
            }
        }
    };
}

calls!(small, "small", Caps<4, 16, 16>);
calls!(large, "large", Caps<16, 256, 64, 32, 32, 4, 1024>);
// No power of two anywhere: places are clamped there, not masked.
calls!(odd, "odd", Caps<3, 90, 5, 3, 3, 2, 7>);
