//! What the rows say about each job: which graph it had, what ran when, how it ended.

use std::collections::HashMap;
use std::rc::Rc;

use red_workload::model::{Arrival, Event, Workload};

use super::ensure;
use crate::graph::{Graph, Role, edited};
use crate::oracle::{Policy, Reason, Row, ShedRow};

/// Weights, frame name, and the capture: a sensor's instant, or task and job.
pub(super) type FrameKey = (String, String, Result<u64, (usize, u64)>);

/// One execution or cache hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub(super) lane: Option<u32>,
    pub(super) start: u64,
    pub(super) finish: u64,
}

pub(super) struct JobFacts {
    pub(super) task: usize,
    pub(super) index: u64,
    pub(super) release: u64,
    pub(super) graph: Rc<Graph>,
    pub(super) heights: Vec<usize>,
    /// Runs of each node by start; more than one only after an eviction.
    pub(super) runs: Vec<Vec<Run>>,
    pub(super) shed: Option<(u64, Reason)>,
    /// When the last node ended, if all did within the horizon.
    pub(super) end: Option<u64>,
}

pub(super) struct Facts<'a> {
    pub(super) workload: &'a Workload,
    pub(super) policy: Policy,
    pub(super) horizon: u64,
    pub(super) jobs: Vec<JobFacts>,
}

impl<'a> Facts<'a> {
    /// Matches every row and shed with a released job and a node of its graph.
    pub(super) fn gather(
        workload: &'a Workload,
        policy: Policy,
        horizon: u64,
        rows: &[Row],
        sheds: &[ShedRow],
    ) -> Result<Self, String> {
        let mut by_job: HashMap<(&str, u64), Vec<&Row>> = HashMap::new();
        for row in rows {
            by_job.entry((&row.task, row.job)).or_default().push(row);
        }
        let mut shed_at: HashMap<(&str, u64), (u64, Reason)> = HashMap::new();
        for shed in sheds {
            let twice = shed_at.insert((&shed.task, shed.job), (shed.at_ns, shed.reason));
            ensure(twice.is_none(), || format!("shed twice: {shed:?}"))?;
        }
        let mut facts = Self { workload, policy, horizon, jobs: Vec::new() };
        for task in 0..workload.tasks.len() {
            let mut versions = Versions::new(workload, policy, task);
            let first = facts.jobs.len();
            for (index, release) in releases(workload, task, horizon) {
                let name = (workload.tasks[task].name.as_str(), index);
                let graph = versions.at(release, &facts.jobs[first..]);
                let runs = by_job.remove(&name).unwrap_or_default();
                let job = facts.job(task, index, release, graph, &runs, shed_at.remove(&name))?;
                facts.jobs.push(job);
            }
        }
        ensure(by_job.is_empty(), || format!("rows of jobs that were not released: {:?}", by_job.keys()))?;
        ensure(shed_at.is_empty(), || format!("sheds of jobs that were not released: {:?}", shed_at.keys()))?;
        Ok(facts)
    }

    fn job(
        &self,
        task: usize,
        index: u64,
        release: u64,
        graph: Rc<Graph>,
        rows: &[&Row],
        shed: Option<(u64, Reason)>,
    ) -> Result<JobFacts, String> {
        let mut runs = vec![Vec::new(); graph.nodes.len()];
        for row in rows {
            let found = graph.nodes.iter().position(|node| node.name == row.node);
            let node = found.ok_or_else(|| format!("no such node in the job's graph: {row:?}"))?;
            let pool = &self.workload.pools[graph.nodes[node].pool];
            ensure(pool.name == row.pool, || format!("not the node's pool: {row:?}"))?;
            ensure(row.lane.is_none_or(|lane| lane < pool.lanes), || format!("no such lane: {row:?}"))?;
            ensure(row.start_ns < self.horizon, || format!("starts at or after the horizon: {row:?}"))?;
            runs[node].push(Run { lane: row.lane, start: row.start_ns, finish: row.finish_ns });
        }
        let ended = |runs: &Vec<Run>| runs.iter().map(|run| run.finish).min().filter(|&at| at < self.horizon);
        let ends: Option<Vec<u64>> = runs.iter().map(ended).collect();
        let end = ends.filter(|_| shed.is_none()).and_then(|ends| ends.into_iter().max());
        let heights = graph.heights(|_| true);
        Ok(JobFacts { task, index, release, graph, heights, runs, shed, end })
    }

    /// Whether evictions may have reset nodes, so that the first run of a node need not count.
    pub(super) fn may_evict(&self) -> bool {
        self.policy.caches() && self.workload.pools.iter().any(|pool| pool.memory_bytes.is_some())
    }

    pub(super) fn name(&self, job: &JobFacts) -> String {
        format!("job {} of {}", job.index, self.workload.tasks[job.task].name)
    }

    /// Frame of an encoder or decoder.
    pub(super) fn frame(&self, job: &JobFacts, node: usize) -> Option<FrameKey> {
        let (weights, frame) = job.graph.nodes[node].stage.clone()?;
        let sensor = self.workload.sensors.iter().find(|sensor| sensor.name == frame);
        let capture = sensor.map(|sensor| job.release - job.release % sensor.period_ns);
        Some((weights, frame, capture.ok_or((job.task, job.index))))
    }
}

impl JobFacts {
    /// When the node was first done; `None` if that never happened.
    pub(super) fn done(&self, node: usize) -> Option<u64> {
        self.runs[node].iter().map(|run| run.finish).min()
    }

    /// When the node could start: its predecessors done, and under a level gate every lower level.
    pub(super) fn ready(&self, node: usize, gated: bool) -> Option<u64> {
        let lower = (0..self.runs.len()).filter(|&other| gated && self.heights[other] < self.heights[node]);
        let before = self.graph.nodes[node].preds.iter().copied().chain(lower);
        before.map(|other| self.done(other)).try_fold(self.release, |ready, done| Some(ready.max(done?)))
    }

    /// Whether the job was out of flight when the releases of `instant` were applied. What ends at an instant
    /// precedes them, unless it took no time there; sheds follow them, and a job that another takes the place of is there
    /// until then.
    pub(super) fn gone_before_releases(&self, instant: u64) -> bool {
        let in_no_time = |run: &Run| run.lane.is_some() && run.start == instant && run.finish == instant;
        match (self.shed, self.end) {
            (Some((at, _)), _) => at < instant,
            (None, Some(end)) => {
                end < instant || end == instant && !self.runs.iter().flatten().any(in_no_time)
            }
            (None, None) => false,
        }
    }
}

fn releases(workload: &Workload, task: usize, horizon: u64) -> Vec<(u64, u64)> {
    let task = &workload.tasks[task];
    let gap = match task.arrival {
        Arrival::Periodic { period_ns } => Some(period_ns),
        Arrival::Sporadic { min_interarrival_ns } => Some(min_interarrival_ns),
        Arrival::Once => None,
    };
    let instants = std::iter::successors(Some(task.offset_ns), |last| last.checked_add(gap?));
    (0..).zip(instants.take_while(|&instant| instant < horizon)).collect()
}

/// The versions of one task's graph, in order.
struct Versions {
    graphs: Vec<(u64, Rc<Graph>)>,
    current: usize,
    /// Version of each job released so far.
    held: Vec<usize>,
}

impl Versions {
    fn new(workload: &Workload, policy: Policy, task: usize) -> Self {
        let mut nodes = workload.tasks[task].nodes.clone();
        let mut graphs = vec![(0, Rc::new(Graph::of(&nodes, policy.refines())))];
        let events: Vec<&Event> = workload.events.iter().filter(|event| event.task == task).collect();
        for group in events.chunk_by(|a, b| a.at_ns == b.at_ns) {
            nodes = edited(&nodes, group);
            graphs.push((group[0].at_ns, Rc::new(Graph::of(&nodes, policy.refines()))));
        }
        Self { graphs, current: 0, held: Vec::new() }
    }

    /// The graph of the next release. A version is applied once no job of an older one than the current is
    /// left.
    fn at(&mut self, release: u64, earlier: &[JobFacts]) -> Rc<Graph> {
        let older_left = |current: usize, held: &[usize]| {
            let jobs = earlier.iter().zip(held);
            jobs.into_iter().any(|(job, &version)| version < current && !job.gone_before_releases(release))
        };
        while self.graphs.get(self.current + 1).is_some_and(|(at, _)| *at <= release)
            && !older_left(self.current, &self.held)
        {
            self.current += 1;
        }
        self.held.push(self.current);
        Rc::clone(&self.graphs[self.current].1)
    }
}

/// Precedence, level gates, release and shed instants of every run.
pub(super) fn check(facts: &Facts<'_>) -> Result<(), String> {
    let gated = facts.policy.gates_levels();
    for job in &facts.jobs {
        for (node, runs) in job.runs.iter().enumerate() {
            let name = || format!("{} of {}", job.graph.nodes[node].name, facts.name(job));
            let role = job.graph.nodes[node].role;
            let may_repeat = facts.may_evict() && role == Role::Encoder;
            ensure(runs.len() <= 1 || may_repeat, || format!("{} starts twice", name()))?;
            for run in runs {
                let ready = job.ready(node, gated);
                ensure(ready.is_some_and(|at| at <= run.start), || {
                    format!("{} starts at {} but is ready at {ready:?}", name(), run.start)
                })?;
                ensure(job.shed.is_none_or(|(at, _)| run.start <= at), || {
                    format!("{} starts after its shed", name())
                })?;
            }
        }
    }
    Ok(())
}
