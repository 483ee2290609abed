//! The same calls on the core itself: what is open has a twin that the library does not know.

use std::any::Any;

use red_core::*;
use red_ffi::{red_executions, red_figures, red_level, red_member, red_placed_node, red_status, red_warning};
use red_record::{Reader, Replay, replay};

use crate::planted::{Bug, has};
use crate::statuses::*;
use crate::values;

/// What a call on the core says in the words of the header.
pub(crate) type Answer<T> = Result<T, red_status>;

/// The classes of the header.
pub(crate) type Small = Caps<4, 16, 16, 4, 2, 1, 64>;
pub(crate) type Medium = Caps<8, 64, 32, 8, 4, 1, 256>;
pub(crate) type Large = Caps<16, 256, 64, 32, 32, 4, 1024>;

pub(crate) fn or(right: bool, status: red_status) -> Answer<()> {
    if right { Ok(()) } else { Err(status) }
}

/// A graph of any class.
pub(crate) trait AnyDag {
    fn any(&self) -> &dyn Any;
    fn add_node(&mut self, node: Node) -> Answer<u32>;
    fn add_edge(&mut self, from: NodeId, to: NodeId) -> Answer<()>;
    fn remove_node(&mut self, node: NodeId) -> Answer<()>;
    fn remove_edge(&mut self, from: NodeId, to: NodeId) -> Answer<()>;
    fn refine(&mut self, stage: NodeId, encoder: Node, decoders: &[Node]) -> Answer<u32>;
    fn node(&self, node: NodeId) -> Answer<Node>;
    fn successors(&self, node: NodeId) -> Answer<Vec<u32>>;
    fn nodes(&self) -> Vec<NodeId>;
    /// The task, and which of its graphs an edit was begun from.
    fn origin(&self) -> (TaskId, u32);
    /// Nodes, levels, work and critical path.
    fn summary(&self) -> (usize, usize, u64, u64);
    fn place(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8]) -> Vec<red_placed_node>;
    fn share(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8]) -> Vec<red_level>;
    fn prove(&self, limit: Duration, lanes: &[u8], budgets: &[Option<Bytes>]) -> Certificate;
}

/// A graph without nodes.
pub(crate) fn dag<C: Capacity>() -> Box<dyn AnyDag> {
    Box::new(Dag::<C>::new())
}

impl<C: Capacity> AnyDag for Dag<C> {
    fn any(&self) -> &dyn Any {
        self
    }

    fn add_node(&mut self, node: Node) -> Answer<u32> {
        or(node.pool().index() < C::POOLS, red_status::UnknownPool)?;
        Self::add_node(self, node).map(|id| id.index() as u32).map_err(node_error)
    }

    fn add_edge(&mut self, from: NodeId, to: NodeId) -> Answer<()> {
        Self::add_edge(self, from, to).map_err(edge_error)
    }

    fn remove_node(&mut self, node: NodeId) -> Answer<()> {
        or(Self::remove_node(self, node), red_status::UnknownNode)
    }

    fn remove_edge(&mut self, from: NodeId, to: NodeId) -> Answer<()> {
        or(Self::remove_edge(self, from, to), red_status::UnknownEdge)
    }

    fn refine(&mut self, stage: NodeId, encoder: Node, decoders: &[Node]) -> Answer<u32> {
        or(decoders.len() <= C::NODES, red_status::NodesFull)?;
        let has = |node: &Node| node.pool().index() < C::POOLS;
        or(has(&encoder) && decoders.iter().all(has), red_status::UnknownPool)?;
        let refined = refine(self, stage, encoder, decoders).map_err(refine_error)?;
        *self = refined.dag;
        Ok(refined.encoder.index() as u32)
    }

    fn node(&self, node: NodeId) -> Answer<Node> {
        Self::node(self, node).copied().ok_or(red_status::UnknownNode)
    }

    fn successors(&self, node: NodeId) -> Answer<Vec<u32>> {
        or(self.contains(node), red_status::UnknownNode)?;
        Ok(Self::successors(self, node).iter().map(|i| i as u32).collect())
    }

    fn nodes(&self) -> Vec<NodeId> {
        Self::nodes(self).collect()
    }

    fn origin(&self) -> (TaskId, u32) {
        Self::origin(self)
    }

    fn summary(&self) -> (usize, usize, u64, u64) {
        let levels = Levels::of(self);
        (self.len(), levels.count(), self.work(), levels.critical_path())
    }

    fn place(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8]) -> Vec<red_placed_node> {
        let levels = Levels::of(self);
        let due = SubDeadlines::assign(&levels, rule, deadline, lanes);
        let of = |node| red_placed_node {
            node: NodeId::index(node) as u32,
            height: levels.height(node) as u32,
            tail_ns: levels.tail(node),
            sub_deadline_ns: due.sub_deadline(node),
            key_ns: due.key(node),
        };
        self.nodes().map(of).collect()
    }

    fn share(&self, rule: DeadlineRule, deadline: Duration, lanes: &[u8]) -> Vec<red_level> {
        let levels = Levels::of(self);
        let shares = shares(&levels, rule, deadline, lanes);
        let of = |l: &LevelShare| red_level {
            cost_ns: l.cost,
            graham_ns: l.graham,
            share_ns: l.share,
            end_ns: l.end,
        };
        shares.as_ref().iter().take(levels.count()).map(of).collect()
    }

    fn prove(&self, limit: Duration, lanes: &[u8], budgets: &[Option<Bytes>]) -> Certificate {
        response_time(&Levels::of(self), limit, lanes, budgets)
    }
}

/// A scheduler of any class.
pub(crate) trait Twin {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Answer<u32>;
    fn dispatch_ahead(&mut self, pool: u32) -> Answer<()>;
    fn lose_pool(&mut self, pool: u32, now: Instant) -> Answer<()>;
    fn add_sensor(&mut self, period: Duration) -> Answer<u32>;
    fn add_task(&mut self, dag: &dyn AnyDag, timing: Timing) -> Answer<u32>;
    fn remove_task(&mut self, task: u32, now: Instant) -> Answer<()>;
    fn edit(&self, task: u32) -> Answer<Box<dyn AnyDag>>;
    fn commit(&mut self, dag: &dyn AnyDag, now: Instant) -> Answer<Certificate>;
    fn certificate(&self, task: u32) -> Answer<Certificate>;
    fn release(&mut self, task: u32, at: Instant, capture: Option<u64>, now: Instant) -> Answer<u32>;
    fn poll(&mut self, now: Instant) -> Option<Action>;
    fn poll_on(&mut self, lane: u8, now: Instant) -> Answer<Option<Action>>;
    fn complete(&mut self, unit: u64, now: Instant) -> Answer<()>;
    fn complete_and_poll(&mut self, unit: u64, now: Instant) -> Answer<Option<Action>>;
    fn fail(&mut self, unit: u64, now: Instant) -> Answer<()>;
    fn take_outcome(&mut self) -> Option<Outcome>;
    fn take_warning(&mut self) -> Option<red_warning>;
    fn take_event(&mut self) -> Option<Event>;
    fn retire(&mut self, lane: u8) -> Answer<()>;
    fn restore(&mut self, lane: u8) -> Answer<()>;
    fn poll_at(&self) -> Option<Instant>;
    fn unit(&self, unit: u64) -> Answer<Unit>;
    fn members(&self, unit: u64) -> Answer<Vec<red_member>>;
    fn waits_for(&self, unit: u64) -> Answer<Vec<u64>>;
    fn job(&self, task: u32, index: u64) -> Answer<u32>;
    fn executions(&self, task: u32, node: NodeId) -> Answer<red_executions>;
    fn memory_used(&self, pool: u32) -> Answer<u64>;
    fn config(&self) -> Config;
    fn figures(&self) -> red_figures;
    /// Whether a graph is of its class.
    fn takes(&self, dag: &dyn AnyDag) -> Answer<()>;
    /// Whether nothing has happened that a log would not have.
    fn is_new(&self) -> bool;
    /// A log of all its calls is fed to another one, which answers the same.
    fn replays(&self, log: &[u8]);
}

struct Host<C: Capacity> {
    core: Scheduler<C>,
    pools: u32,
    is_set_up: bool,
}

pub(crate) fn scheduler<C: Capacity>(config: Config) -> Box<dyn Twin> {
    Box::new(Host { core: Scheduler::<C>::new(config), pools: 1, is_set_up: false })
}

impl<C: Capacity> Host<C> {
    /// A graph of this class.
    fn graph(dag: &dyn AnyDag) -> Answer<&Dag<C>> {
        dag.any().downcast_ref::<Dag<C>>().ok_or(red_status::OtherClass)
    }

    fn pool(&self, pool: u32) -> Answer<PoolId> {
        or(pool < self.pools, red_status::UnknownPool).map(|()| PoolId::new(pool as u8))
    }
}

impl<C: Capacity> Twin for Host<C> {
    fn add_pool(&mut self, lanes: u8, memory: Option<Bytes>) -> Answer<u32> {
        let added = self.core.add_pool(lanes, memory).map_err(pool_error)?;
        self.pools += 1;
        self.is_set_up = true;
        Ok(added.index() as u32)
    }

    fn dispatch_ahead(&mut self, pool: u32) -> Answer<()> {
        let is_ahead = self.core.dispatch_ahead(self.pool(pool)?);
        self.is_set_up |= is_ahead;
        or(is_ahead, red_status::NotAhead)
    }

    fn lose_pool(&mut self, pool: u32, now: Instant) -> Answer<()> {
        self.pool(pool).map(|pool| self.is_set_up = self.core.lose_pool(pool, now))
    }

    fn add_sensor(&mut self, period: Duration) -> Answer<u32> {
        let added = self.core.add_sensor(period).map_err(sensor_error)?;
        self.is_set_up = true;
        Ok(added.index() as u32)
    }

    fn add_task(&mut self, dag: &dyn AnyDag, timing: Timing) -> Answer<u32> {
        let dag = Self::graph(dag)?;
        let added = self.core.add_task(dag, timing).map_err(task_error)?;
        self.is_set_up = true;
        Ok(added.to_bits())
    }

    fn remove_task(&mut self, task: u32, now: Instant) -> Answer<()> {
        or(self.core.remove_task(TaskId::from_bits(task), now), red_status::UnknownTask)
    }

    fn edit(&self, task: u32) -> Answer<Box<dyn AnyDag>> {
        let edit = self.core.edit(TaskId::from_bits(task)).ok_or(red_status::UnknownTask)?;
        Ok(Box::new(edit))
    }

    fn commit(&mut self, dag: &dyn AnyDag, now: Instant) -> Answer<Certificate> {
        let dag = Self::graph(dag)?;
        self.core.commit(dag, now).map_err(commit_error)
    }

    fn certificate(&self, task: u32) -> Answer<Certificate> {
        self.core.certificate(TaskId::from_bits(task)).ok_or(red_status::UnknownTask)
    }

    fn release(&mut self, task: u32, at: Instant, capture: Option<u64>, now: Instant) -> Answer<u32> {
        let released = self.core.release_at(TaskId::from_bits(task), at, capture, now);
        released.map(JobId::to_bits).map_err(release_error)
    }

    fn poll(&mut self, now: Instant) -> Option<Action> {
        self.core.poll(now)
    }

    fn poll_on(&mut self, lane: u8, now: Instant) -> Answer<Option<Action>> {
        or(usize::from(lane) < self.core.lanes(), red_status::UnknownLane)?;
        Ok(self.core.poll_on(LaneId::new(lane), now))
    }

    fn complete(&mut self, unit: u64, now: Instant) -> Answer<()> {
        self.core.complete(UnitId::from_bits(unit), now).map_err(complete_error)
    }

    fn complete_and_poll(&mut self, unit: u64, now: Instant) -> Answer<Option<Action>> {
        self.core.complete_and_poll(UnitId::from_bits(unit), now).map_err(complete_error)
    }

    fn fail(&mut self, unit: u64, now: Instant) -> Answer<()> {
        self.core.fail(UnitId::from_bits(unit), now).map_err(complete_error)
    }

    fn take_outcome(&mut self) -> Option<Outcome> {
        self.core.take_outcome()
    }

    fn take_warning(&mut self) -> Option<red_warning> {
        let warning = self.core.take_warning()?;
        Some(values::of_warning(&warning, self.core.now().as_nanos()))
    }

    fn take_event(&mut self) -> Option<Event> {
        self.core.take_event().copied()
    }

    fn retire(&mut self, lane: u8) -> Answer<()> {
        let is_retired = self.core.retire_lane(LaneId::new(lane));
        self.is_set_up |= is_retired;
        or(is_retired, red_status::UnknownLane)
    }

    fn restore(&mut self, lane: u8) -> Answer<()> {
        or(self.core.restore_lane(LaneId::new(lane)), red_status::UnknownLane)
    }

    fn poll_at(&self) -> Option<Instant> {
        self.core.poll_at()
    }

    fn unit(&self, unit: u64) -> Answer<Unit> {
        self.core.unit(UnitId::from_bits(unit)).ok_or(red_status::NotRunning)
    }

    fn members(&self, unit: u64) -> Answer<Vec<red_member>> {
        let members = self.core.members(UnitId::from_bits(unit));
        let members: Vec<_> = members.map(|member| crate::values::of_member(&member)).collect();
        if members.is_empty() { Err(red_status::NotRunning) } else { Ok(members) }
    }

    fn waits_for(&self, unit: u64) -> Answer<Vec<u64>> {
        self.unit(unit).map(|_| self.core.waits_for(UnitId::from_bits(unit)).map(UnitId::to_bits).collect())
    }

    fn job(&self, task: u32, index: u64) -> Answer<u32> {
        let job = self.core.job_id(TaskId::from_bits(task), index);
        job.map(JobId::to_bits).ok_or(red_status::UnknownJob)
    }

    fn executions(&self, task: u32, node: NodeId) -> Answer<red_executions> {
        let seen = self.core.task_node(TaskId::from_bits(task), node).ok_or(red_status::UnknownNode)?.1;
        let or_none = |ns: Option<u64>| ns.unwrap_or(red_ffi::RED_NONE_64);
        Ok(red_executions {
            mean_ns: or_none(seen.mean().map(CostEstimate::as_nanos)),
            minimum_ns: or_none(seen.minimum().map(Duration::as_nanos)),
            maximum_ns: or_none(seen.maximum().map(Duration::as_nanos)),
            ..Empty::EMPTY
        })
    }

    fn memory_used(&self, pool: u32) -> Answer<u64> {
        self.pool(pool).map(|pool| self.core.memory_used(pool).0)
    }

    fn config(&self) -> Config {
        *self.core.config()
    }

    fn figures(&self) -> red_figures {
        let so_far = self.core.counters();
        red_figures {
            units: so_far.units,
            encoder_runs_saved: so_far.encoder_runs_saved,
            overruns: so_far.overruns,
            clock_steps_back: so_far.clock_steps_back,
            late_completions: so_far.late_completions,
            evictions: so_far.evictions,
            events_dropped: self.core.events_dropped(),
            lanes: self.core.lanes() as u32,
            jobs_in_flight: self.core.jobs_in_flight() as u32,
            ready: self.core.ready_sub_jobs() as u32,
            running: self.core.running_units() as u32,
            can_dispatch: self.core.can_dispatch().into(),
            ..Empty::EMPTY
        }
    }

    fn takes(&self, dag: &dyn AnyDag) -> Answer<()> {
        Self::graph(dag).map(drop)
    }

    fn is_new(&self) -> bool {
        !self.is_set_up && self.core.now() == Instant::ZERO
    }

    fn replays(&self, log: &[u8]) {
        let mut log = Reader::new(log).unwrap_or_else(|why| panic!("a log that cannot be read: {why}"));
        let mut other = Scheduler::<C>::new(*self.core.config());
        if has(Bug::Log) {
            other.retire_lane(LaneId::new(0));
        }
        let by_number = |_: &mut _, _, _| Err(CommitError::UnknownTask);
        match replay(&mut log, &mut other, by_number, |_, _| {}) {
            Ok(Replay { difference: None, .. }) => {}
            Ok(Replay { difference: Some(found), .. }) => panic!("a log that does not replay: {found:?}"),
            Err(why) => panic!("a log that does not replay: {why}"),
        }
    }
}
