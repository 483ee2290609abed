//! What a watcher knows of the jobs in flight: from the events alone, by the specification's formulas.

use std::collections::{BTreeMap, BTreeSet};

use red_core::{
    Action, Dag, Dispatch, Event, EventKind, Levels, Node, NodeId, Outcome, Role, Scheduler, UnitId,
};
use red_sim::Lab;
use red_workload::model::{Arrival, Task, Workload};

use crate::drive::Watch;

/// Weights, frame name, and who took the picture: a sensor by its period and number, or the job itself.
type FrameKey = (u16, u16, Result<(usize, u64), (usize, u64)>);

/// Dispatch order: key, release, task, job, node.
type Key = (i128, u64, usize, u64, usize);

struct Job {
    release: u64,
    deadline: u64,
    dag: Box<Dag<Lab>>,
    tails: Vec<u64>,
    running: BTreeSet<usize>,
    done: BTreeSet<usize>,
}

/// A unit on its lane, whether or not its jobs still want it.
struct OnLane {
    pool: usize,
    bytes: u64,
    encoder: Option<FrameKey>,
}

/// The newest graph of a task.
#[derive(Clone, Default)]
struct Newest {
    work: u64,
    /// Whether a job of it is late even alone.
    is_late_alone: bool,
}

/// The costs of all nodes together.
fn work(dag: &Dag<Lab>) -> u64 {
    dag.nodes().filter_map(|id| dag.node(id)).map(Node::cost).sum()
}

/// Judges a run under REDRT in which every node takes its WCET.
pub struct Model<'a> {
    workload: &'a Workload,
    /// Distinct sensor periods in their order.
    periods: Vec<u64>,
    jobs: BTreeMap<(usize, u64), Job>,
    lanes: BTreeMap<usize, OnLane>,
    /// When each task last released a job.
    released: Vec<Option<u64>>,
    newest: Vec<Newest>,
    /// Units started.
    pub dispatches: u32,
    /// Of them, those of several encoders.
    pub merges: u32,
}

impl<'a> Model<'a> {
    /// Nothing is in flight.
    pub fn new(workload: &'a Workload) -> Self {
        let mut periods = Vec::new();
        for sensor in &workload.sensors {
            if !periods.contains(&sensor.period_ns) {
                periods.push(sensor.period_ns);
            }
        }
        let (jobs, lanes) = (BTreeMap::new(), BTreeMap::new());
        let released = vec![None; workload.tasks.len()];
        let newest = vec![Newest::default(); workload.tasks.len()];
        Self { workload, periods, jobs, lanes, released, newest, dispatches: 0, merges: 0 }
    }

    /// Whether a lane may be left idle instead of starting the node: a job of a larger value, or one with a floor, has a node there that has
    /// not started, or is to be released before the node and what is above would end, or should have been; or any job, where the node's
    /// would be late at WCET on lanes of its own.
    fn awaits_rank(&self, (task, index, node): (usize, u64, usize), now: u64) -> bool {
        let tasks = &self.workload.tasks;
        let job = &self.jobs[&(task, index)];
        let end = now + job.node(node).cost();
        // A new graph says of the jobs of the old one, too, whether the task can be in time.
        let is_lost = self.is_late_alone(task, &job.dag) || self.newest[task].is_late_alone;
        let pool = job.node(node).pool();
        let is_above = |other: usize| {
            let Task { value, floor, .. } = &tasks[other];
            other != task && (is_lost || *value > tasks[task].value || floor.is_some())
        };
        let above = || self.jobs.iter().filter(|((task, _), _)| is_above(*task)).map(|(_, job)| job);
        let has_to_start = |job: &Job| {
            let open = job.dag.nodes().map(NodeId::index).filter(|node| !job.done.contains(node));
            open.filter(|node| !job.running.contains(node)).any(|node| job.node(node).pool() == pool)
        };
        // When each task releases next, again and again, and the work of one job.
        let next = || {
            (0..tasks.len()).filter(|other| is_above(*other)).filter_map(|other| {
                let (Arrival::Periodic { period_ns: gap } | Arrival::Sporadic { min_interarrival_ns: gap }) =
                    tasks[other].arrival
                else {
                    return None;
                };
                let at = self.released[other]? + gap;
                let is_expected = now < at + tasks[other].deadline_ns.max(gap / 8);
                is_expected.then_some((at, gap, self.newest[other].work))
            })
        };
        let lanes = u64::from(self.workload.pools[pool.index()].lanes);
        let in_flight: u64 = above().map(|job| work(&job.dag)).sum();
        let mut horizon = end;
        for _ in 0..6 {
            let jobs =
                |(at, gap, work): (u64, u64, u64)| work * horizon.saturating_sub(at).div_ceil(gap).min(16);
            horizon = end + lanes * (in_flight + next().map(jobs).sum::<u64>());
        }
        above().any(has_to_start) || next().any(|(at, ..)| at < horizon)
    }

    /// Whether a job of a task with such a graph is late at WCET even on lanes of its own.
    fn is_late_alone(&self, task: usize, dag: &Dag<Lab>) -> bool {
        let levels = Levels::of(dag);
        let cost = |id: NodeId| dag.node(id).map_or(0, Node::cost);
        let share = |pool: usize| {
            let here = dag.nodes().filter(|id| dag.node(*id).is_some_and(|node| node.pool().index() == pool));
            here.map(cost).sum::<u64>().div_ceil(self.workload.pools[pool].lanes.into())
        };
        let paths = dag.nodes().map(|id| cost(id) + levels.tail(id));
        let least = (0..self.workload.pools.len()).map(share).chain(paths).max();
        least > Some(self.workload.tasks[task].deadline_ns)
    }

    fn has_newest(&mut self, task: usize, dag: &Dag<Lab>) {
        self.newest[task] = Newest { work: work(dag), is_late_alone: self.is_late_alone(task, dag) };
    }

    /// Nodes that could start: precedence holds, and no running unit computes their frame.
    fn ready(&self) -> impl Iterator<Item = (usize, u64, usize)> + Clone + '_ {
        self.jobs.iter().flat_map(move |((task, index), job)| {
            let open = job.dag.nodes().map(NodeId::index).filter(|node| job.is_ready(*node));
            let free = open.filter(|node| {
                let key = self.frame_key(*task, *index, *node);
                key.is_none() || self.lanes.values().all(|lane| lane.encoder != key)
            });
            free.map(|node| (*task, *index, node)).collect::<Vec<_>>()
        })
    }

    fn key(&self, (task, index, node): (usize, u64, usize)) -> Key {
        let job = &self.jobs[&(task, index)];
        (job.latest_finish(node) - i128::from(job.node(node).cost()), job.release, task, index, node)
    }

    fn frame_key(&self, task: usize, index: u64, node: usize) -> Option<FrameKey> {
        let job = &self.jobs[&(task, index)];
        let Role::SharedEncoder(frame) = job.node(node).role() else { return None };
        let capture = match frame.sensor {
            Some(sensor) => Ok((sensor.index(), job.release / self.periods[sensor.index()])),
            None => Err((task, index)),
        };
        Some((frame.weights, frame.frame, capture))
    }

    fn is_limited(&self, pool: usize) -> bool {
        self.workload.pools[pool].memory_bytes.is_some()
    }

    fn started(&mut self, scheduler: &Scheduler<Lab>, started: &Dispatch, evicted: bool) {
        self.dispatches += 1;
        let unit = scheduler.unit(started.unit).expect("it was dispatched just now");
        let (now, pool) = (unit.started.as_nanos(), unit.pool.index());
        let place = |m: red_core::Member| (m.task.index(), m.index, m.node.index());
        let first = place(unit.first);
        let members: Vec<_> = scheduler.members(started.unit).map(place).collect();
        assert!(members.contains(&first));
        for member in &members {
            let job = &self.jobs[&(member.0, member.1)];
            assert!(job.is_ready(member.2), "{member:?} starts before a predecessor ended, or twice");
            assert_eq!(job.node(member.2).pool().index(), pool, "{member:?} runs in a foreign pool");
        }
        // In a pool with a budget a node that fits may overtake; an eviction changes what is ready.
        if !self.is_limited(pool) && !evicted {
            // Under pressure ranks go before the keys of different jobs.
            let own = self.ready().filter(|n| (n.0, n.1) == (first.0, first.1));
            let waiting = own.filter(|n| self.jobs[&(n.0, n.1)].node(n.2).pool().index() == pool);
            // Others go before one that waits for a higher rank.
            let waiting = waiting.filter(|node| *node == first || !self.awaits_rank(*node, now));
            let least = waiting.map(|node| self.key(node)).min();
            assert_eq!(Some(self.key(first)), least, "at {now} ns in pool {pool}");
        }
        let cost = |m: &(usize, u64, usize)| self.jobs[&(m.0, m.1)].node(m.2).cost();
        let longest = members.iter().map(cost).max().unwrap_or(0);
        for member in members.iter().filter(|member| cost(member) < longest) {
            let ends = i128::from(now) + i128::from(longest);
            let latest = self.jobs[&(member.0, member.1)].latest_finish(member.2);
            assert!(ends <= latest, "merging costs {member:?} its deadline: it ends at {ends}, not {latest}");
        }
        self.merges += u32::from(members.len() > 1);
        let bytes = members.iter().map(|m| self.jobs[&(m.0, m.1)].node(m.2).footprint().0).max().unwrap_or(0);
        let encoder = self.frame_key(first.0, first.1, first.2);
        assert!(members.iter().all(|m| members.len() == 1 || self.frame_key(m.0, m.1, m.2) == encoder));
        let before = self.lanes.insert(started.lane.index(), OnLane { pool, bytes, encoder });
        assert!(before.is_none(), "the lane was busy");
    }

    fn apply(&mut self, events: &[Event]) {
        for event in events {
            let place = (event.task.index(), event.job);
            let node = event.node.index();
            let Some(job) = self.jobs.get_mut(&place) else { continue };
            match event.kind {
                EventKind::Started => assert!(job.running.insert(node), "{event:?} twice"),
                EventKind::Completed => {
                    assert!(job.running.remove(&node), "{event:?} without a start");
                    job.done.insert(node);
                }
                EventKind::Hit => assert!(job.is_ready(node) && job.done.insert(node), "{event:?} too early"),
                EventKind::Evicted => assert!(job.done.remove(&node), "{event:?} of what was not there"),
                EventKind::Ended => {
                    assert_eq!(job.done.len(), job.dag.len(), "{event:?} with nodes left");
                    self.jobs.remove(&place);
                }
                EventKind::Shed(_) => {
                    self.jobs.remove(&place);
                }
                EventKind::Overran => panic!("{event:?}, though every node takes its WCET"),
                _ => {}
            }
        }
    }

    fn check_memory(&self, scheduler: &Scheduler<Lab>) {
        for (pool, limits) in self.workload.pools.iter().enumerate() {
            let Some(budget) = limits.memory_bytes else { continue };
            let running: u64 =
                self.lanes.values().filter(|lane| lane.pool == pool).map(|lane| lane.bytes).sum();
            let used = scheduler.memory_used(red_core::PoolId::new(pool as u8)).0;
            assert!(running <= used && used <= budget, "running {running}, used {used}, budget {budget}");
        }
    }

    /// After the last job: nothing is left behind.
    pub fn finish(&self, scheduler: &Scheduler<Lab>) {
        assert!(self.jobs.is_empty() && self.lanes.is_empty(), "something never ended");
        for pool in 0..self.workload.pools.len() {
            assert_eq!(
                scheduler.memory_used(red_core::PoolId::new(pool as u8)).0,
                0,
                "memory of pool {pool}"
            );
        }
    }
}

impl Job {
    fn node(&self, node: usize) -> &Node {
        self.dag.node(NodeId::new(node as u8)).expect("a node of this version")
    }

    fn is_ready(&self, node: usize) -> bool {
        let ended =
            |other: NodeId| !self.dag.successors(other).contains(node) || self.done.contains(&other.index());
        !self.running.contains(&node) && !self.done.contains(&node) && self.dag.nodes().all(ended)
    }

    /// a + D - tail.
    fn latest_finish(&self, node: usize) -> i128 {
        i128::from(self.deadline) - i128::from(self.tails[node])
    }
}

impl Watch for Model<'_> {
    fn released(&mut self, scheduler: &Scheduler<Lab>, task: usize, index: u64, now: u64) {
        let id = red_core::TaskId::from_bits(task as u32);
        let dag = Box::new(scheduler.edit(id).expect("admitted"));
        self.has_newest(task, &dag);
        let levels = Levels::of(&dag);
        let tails = (0..=u8::MAX).map(|node| levels.tail(NodeId::new(node))).collect();
        let deadline = now + self.workload.tasks[task].deadline_ns;
        self.released[task] = Some(now);
        let (running, done) = (BTreeSet::new(), BTreeSet::new());
        self.jobs.insert((task, index), Job { release: now, deadline, dag, tails, running, done });
    }

    fn acted(&mut self, scheduler: &Scheduler<Lab>, action: &Action, events: &[Event]) {
        if let Action::Dispatch(started) = action {
            let evicted = events.iter().any(|event| event.kind == EventKind::Evicted);
            if evicted {
                let (first, rest): (Vec<Event>, Vec<Event>) =
                    events.iter().partition(|event| event.kind == EventKind::Evicted);
                self.apply(&first);
                self.started(scheduler, started, evicted);
                self.apply(&rest);
            } else {
                self.started(scheduler, started, evicted);
                self.apply(events);
            }
        } else {
            self.apply(events);
        }
        self.check_memory(scheduler);
    }

    fn told(&mut self, scheduler: &Scheduler<Lab>, events: &[Event]) {
        for edited in events.iter().filter(|event| event.kind == EventKind::Edited) {
            let dag = scheduler.edit(edited.task).expect("admitted");
            self.has_newest(edited.task.index(), &dag);
        }
        self.apply(events);
        self.check_memory(scheduler);
    }

    fn completing(&mut self, unit: UnitId, _now: u64) {
        assert!(self.lanes.remove(&unit.lane().index()).is_some());
    }

    fn quiet(&mut self, scheduler: &Scheduler<Lab>, now: u64) {
        for (pool, limits) in
            self.workload.pools.iter().enumerate().filter(|(pool, _)| !self.is_limited(*pool))
        {
            let busy = self.lanes.values().filter(|lane| lane.pool == pool).count();
            let mut waiting =
                self.ready().filter(|n| self.jobs[&(n.0, n.1)].node(n.2).pool().index() == pool);
            let idle = busy < limits.lanes as usize;
            let is_held = waiting.clone().any(|node| self.awaits_rank(node, now));
            assert!(
                !idle || is_held || waiting.next().is_none(),
                "a lane of pool {pool} idles at {now} ns while a node waits"
            );
        }
        assert_eq!(scheduler.running_units(), self.lanes.len());
        assert_eq!(scheduler.jobs_in_flight(), self.jobs.len());
    }

    fn ended(&mut self, outcome: &Outcome) {
        assert!(
            !self.jobs.contains_key(&(outcome.task.index(), outcome.index)),
            "{outcome:?} is still in flight"
        );
    }
}

/// Whether some window of `k` consecutive jobs lost more than `k - m`.
pub fn is_violated(dropped: &[u64], m: u32, k: u32) -> bool {
    let (k, spare) = (u64::from(k), (k - m) as usize);
    dropped
        .iter()
        .any(|first| dropped.iter().filter(|job| (*first..*first + k).contains(job)).count() > spare)
}
