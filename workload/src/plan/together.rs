//! A workload as those see it who prove things of all its tasks together.

use super::admission::{Versions, apply};
use super::period_ns;
use crate::build::{self, BuildError};
use crate::model::{PoolKind, Task, Workload};
use red_certificate::{self as certificate, Cluster, Graph, Set};
use red_core::{Capacity, Dag, Frame, NodeId, Role};
use std::collections::{BTreeMap, BTreeSet};

/// The set of tasks and clusters that a workload is.
pub(super) fn set<C: Capacity>(
    workload: &Workload,
    built: &build::Plan<C>,
    versions: &[Versions],
) -> Result<Set, BuildError> {
    let mut shared = Shared::default();
    let mut tasks = Vec::new();
    for (i, task) in workload.tasks.iter().enumerate() {
        let mut dag = built.dags[i];
        let mut graphs = vec![graph(&dag, &built.nodes[i])];
        shared.note(i, &dag);
        for step in built.changes.iter().filter(|change| change.task == i).flat_map(|change| &change.steps) {
            apply(step, &mut dag, task)?;
            shared.note(i, &dag);
            let next = graph(&dag, &built.nodes[i]);
            if !graphs.contains(&next) {
                graphs.push(next);
            }
        }
        tasks.push(certificate::Task {
            name: task.name.clone(),
            deadline_ns: task.deadline_ns,
            period_ns: period_ns(task),
            waits: false,
            frames: Vec::new(),
            versions: graphs,
        });
    }
    let waiting = waiting(workload, versions, &tasks);
    for (i, task) in tasks.iter_mut().enumerate() {
        task.waits = shared.is_uneven(i) || workload_pools(task).any(|pool| waiting[pool]);
        task.frames = shared.between_jobs(i);
    }
    let cluster = |pool: &crate::model::Pool| Cluster {
        pool: pool.undivided().to_owned(),
        name: pool.cluster().to_owned(),
        lanes: pool.lanes,
    };
    let clusters = workload.pools.iter().map(cluster).collect();
    Ok(Set { most_jobs: C::JOBS as u64, clusters, tasks })
}

fn workload_pools(task: &certificate::Task) -> impl Iterator<Item = usize> + '_ {
    task.versions.iter().flat_map(|graph| &graph.nodes).map(|node| node.cluster)
}

fn graph<C: Capacity>(dag: &Dag<C>, numbered: &[build::Numbered]) -> Graph {
    let ids: Vec<NodeId> = dag.nodes().collect();
    let at = |id: usize| ids.iter().position(|other| other.index() == id);
    let node = |id: &NodeId| {
        let node = dag.node(*id)?;
        let name = numbered.get(id.index())?.name.clone();
        Some(certificate::Node { name, cost_ns: node.cost(), cluster: node.pool().index() })
    };
    let edges = ids.iter().enumerate().flat_map(|(from, id)| {
        dag.successors(*id).iter().filter_map(at).map(move |to| (from, to)).collect::<Vec<_>>()
    });
    Graph { nodes: ids.iter().filter_map(node).collect(), edges: edges.collect() }
}

/// Weights and frame.
type Shareable = (u16, u16);

/// Which encoder results are shared, and what computing them costs.
#[derive(Default)]
struct Shared {
    costs: BTreeMap<Shareable, BTreeSet<u64>>,
    by_task: Vec<BTreeMap<Shareable, bool>>,
}

impl Shared {
    fn note<C: Capacity>(&mut self, task: usize, dag: &Dag<C>) {
        if self.by_task.len() <= task {
            self.by_task.push(BTreeMap::new());
        }
        for node in dag.nodes().filter_map(|id| dag.node(id)) {
            if let Role::SharedEncoder(Frame { weights, frame, sensor }) = node.role() {
                self.costs.entry((weights, frame)).or_default().insert(node.cost());
                self.by_task[task].insert((weights, frame), sensor.is_some());
            }
        }
    }

    /// Whether a node of the task may wait for a result longer than it would take to compute it.
    fn is_uneven(&self, task: usize) -> bool {
        self.by_task[task].keys().any(|result| self.costs[result].len() > 1)
    }

    /// Names of results that other jobs may take: those of frames with a sensor.
    fn between_jobs(&self, task: usize) -> Vec<String> {
        let between = self.by_task[task].iter().filter(|(_, between)| **between);
        between.map(|((weights, frame), _)| format!("{weights}/{frame}")).collect()
    }
}

/// By pool: whether a ready node may have to wait there for something else than a lane.
fn waiting(workload: &Workload, versions: &[Versions], tasks: &[certificate::Task]) -> Vec<bool> {
    let of_pool = |pool: usize| {
        // Lanes that order work by themselves may be given a node before its turn.
        let is_ahead = workload.pools[pool].kind == PoolKind::Cuda;
        let users: Vec<usize> =
            (0..tasks.len()).filter(|i| workload_pools(&tasks[*i]).any(|used| used == pool)).collect();
        is_ahead
            || workload.pools[pool].memory_bytes.is_some() && !fits_memory(workload, pool, &users, versions)
    };
    (0..workload.pools.len()).map(of_pool).collect()
}

/// Whether no node of these tasks can have to wait for memory in a pool with a budget.
fn fits_memory(workload: &Workload, pool: usize, users: &[usize], versions: &[Versions]) -> bool {
    if let [only] = users {
        // One job at a time.
        return versions[*only].iter().all(|version| version.proof.memory_holds && version.proof.fits);
    }
    let Some(budget) = workload.pools[pool].memory_bytes else { return true };
    let mut footprints = Vec::new();
    let mut results: u128 = 0;
    for task in users.iter().map(|i| &workload.tasks[*i]) {
        let added = workload.events.iter().filter(|event| workload.tasks[event.task].name == task.name);
        let nodes = task.nodes.iter().chain(added.flat_map(|event| &event.add));
        for (name, part) in nodes.flat_map(|node| node.parts()).filter(|(_, part)| part.pool == pool) {
            let bytes = u128::from(part.memory_bytes);
            footprints.push(bytes);
            results += if name.ends_with(".encoder") { bytes * jobs_at_once(task) } else { 0 };
        }
    }
    footprints.sort_unstable_by(|a, b| b.cmp(a));
    let running: u128 = footprints.iter().take(workload.pools[pool].lanes as usize).sum();
    running + results <= u128::from(budget)
}

/// Jobs of a task in flight at once, at most, where each is in time.
fn jobs_at_once(task: &Task) -> u128 {
    period_ns(task).map_or(1, |period| u128::from(task.deadline_ns.div_ceil(period)))
}
