//! The verdict: every test of every task and pool, for the graphs as written and after each event.

use super::level_capacity::LevelCapacity;
use super::period_ns;
use super::utilisation::{Demand, slack};
use crate::build::{self, BuildError, Step};
use crate::model::{Task, Workload};
use red_certificate as certificate;
use red_core::{Bound, Bytes, Capacity, Dag, Duration, Frame, Levels, Role, response_time};
use serde::Serialize;
use std::cmp::Ordering;
use std::collections::BTreeMap;

/// Whether a workload fits, and how tightly.
#[derive(Clone, Debug, Serialize)]
pub struct Admission {
    /// Every test says yes.
    pub fits: bool,
    /// What that is worth.
    pub guarantee: Guarantee,
    /// The test with the least relative margin.
    pub binding: String,
    /// Its margin, negative by what is missing: of the limit for a response time, of lane time per second for a
    /// utilisation, of the deadline in a simulation.
    pub margin_ns: i128,
}

/// What a verdict is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guarantee {
    /// Proved for every release offset and every execution time up to the WCET, under the default policy.
    Analytic,
    /// Every test says yes, and a simulation showed no miss.
    Empirical,
    /// Neither.
    BestEffort,
}

/// The bounds of one task alone on its pools.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// For the graph as written.
    #[serde(flatten)]
    pub base: Proof,
    /// Whether Graham's bound of every level is within the level's share. Not needed to fit.
    pub levels_fit: bool,
    /// The paper's condition (ii), W <= rho * D. Necessary, and not sufficient.
    pub paper_condition: bool,
    /// For the graph after each instant with events.
    pub changes: Vec<Proof>,
}

/// A bound on the response time of a job that has its pools to itself, with the numbers that it follows from.
#[derive(Clone, Debug, Serialize)]
pub struct Proof {
    /// From when on.
    pub at_ns: u64,
    /// `graham`, `long-path` or `several-pools`.
    pub bound: &'static str,
    /// Disjoint paths that the bound takes apart, the critical path included.
    pub paths: u8,
    /// Lanes of the task's pool; the most where it uses several.
    pub lanes: u8,
    /// Sum of all costs.
    pub work_ns: u64,
    /// Cost of the longest path.
    pub critical_path_ns: u64,
    /// The bound.
    pub response_ns: u64,
    /// min(deadline, period).
    pub limit_ns: u64,
    /// Limit less bound.
    pub margin_ns: i128,
    /// Whether the bound is within the limit.
    pub fits: bool,
    /// Whether no ready node can have to wait for memory; else the bound is not sufficient.
    pub memory_holds: bool,
    /// Whether encoders whose results may be shared cost the same. Else a node may wait for a result longer than
    /// it would have executed, which no bound covers.
    #[serde(skip)]
    pub shares_evenly: bool,
}

impl Certificate {
    pub(super) fn of(versions: &Versions, capacity: &LevelCapacity) -> Self {
        Self {
            base: versions.base.proof.clone(),
            levels_fit: capacity.levels_fit,
            paper_condition: capacity.paper_condition,
            changes: versions.changes.iter().map(|version| version.proof.clone()).collect(),
        }
    }

    /// The largest bound over all versions of the graph, in nanoseconds.
    #[must_use]
    pub fn largest_response_ns(&self) -> u64 {
        self.changes.iter().map(|proof| proof.response_ns).fold(self.base.response_ns, u64::max)
    }
}

impl Proof {
    fn of<C: Capacity>(
        dag: &Dag<C>,
        at_ns: u64,
        limit: Duration,
        lanes: &[u8],
        budgets: &[Option<Bytes>],
    ) -> Self {
        let proof = response_time(&Levels::of(dag), limit, lanes, budgets);
        let (bound, paths) = match proof.bound {
            Bound::LongPath { paths } => ("long-path", paths + 1),
            Bound::SeveralPools => ("several-pools", 1),
            _ => ("graham", 1),
        };
        Self {
            at_ns,
            bound,
            paths,
            lanes: proof.lanes,
            work_ns: proof.work.as_nanos(),
            critical_path_ns: proof.critical_path.as_nanos(),
            response_ns: proof.response.as_nanos(),
            limit_ns: limit.as_nanos(),
            margin_ns: i128::from(limit.as_nanos()) - i128::from(proof.response.as_nanos()),
            fits: proof.fits(),
            memory_holds: proof.memory_holds,
            shares_evenly: shares_evenly(dag),
        }
    }
}

/// Lanes and budgets by pool.
pub(super) struct Pools {
    pub(super) lanes: Vec<u8>,
    budgets: Vec<Option<Bytes>>,
}

impl Pools {
    pub(super) fn of(workload: &Workload) -> Self {
        let pools = || workload.pools.iter();
        Self {
            lanes: pools().map(|pool| u8::try_from(pool.lanes).unwrap_or(u8::MAX)).collect(),
            budgets: pools().map(|pool| pool.memory_bytes.map(Bytes)).collect(),
        }
    }
}

/// A task's graph as written and after each instant with events.
pub(super) struct Versions {
    pub(super) base: Version,
    changes: Vec<Version>,
}

impl Versions {
    pub(super) fn iter(&self) -> impl Iterator<Item = &Version> {
        [&self.base].into_iter().chain(&self.changes)
    }

    /// The version of jobs released at this instant; `None` is before every event.
    fn at(&self, instant: Option<u64>) -> &Version {
        let holds = |version: &&Version| instant.is_some_and(|at_ns| version.proof.at_ns <= at_ns);
        self.changes.iter().rev().find(holds).unwrap_or(&self.base)
    }
}

/// What the tests need to know of one version of a task's graph.
pub(super) struct Version {
    pub(super) proof: Proof,
    /// Work by pool, in nanoseconds.
    work_ns: Vec<u64>,
}

impl Version {
    fn of<C: Capacity>(dag: &Dag<C>, at_ns: u64, task: &Task, pools: &Pools) -> Self {
        let limit = period_ns(task).map_or(task.deadline_ns, |period| period.min(task.deadline_ns));
        let mut work_ns = vec![0; pools.lanes.len()];
        for node in dag.nodes().filter_map(|id| dag.node(id)) {
            work_ns[node.pool().index()] += node.cost();
        }
        Self {
            proof: Proof::of(dag, at_ns, Duration::from_nanos(limit), &pools.lanes, &pools.budgets),
            work_ns,
        }
    }
}

/// [`Proof::shares_evenly`].
fn shares_evenly<C: Capacity>(dag: &Dag<C>) -> bool {
    let mut costs: BTreeMap<(u16, u16), u64> = BTreeMap::new();
    frames(dag).all(|(frame, cost)| *costs.entry(key(frame)).or_insert(cost) == cost)
}

/// Encoders: the frame of each, and its cost.
fn frames<C: Capacity>(dag: &Dag<C>) -> impl Iterator<Item = (Frame, u64)> + '_ {
    dag.nodes().filter_map(|id| dag.node(id)).filter_map(|node| match node.role() {
        Role::SharedEncoder(frame) => Some((frame, node.cost())),
        _ => None,
    })
}

const fn key(frame: Frame) -> (u16, u16) {
    (frame.weights, frame.frame)
}

/// The versions of every task's graph, in file order.
pub(super) fn versions<C: Capacity>(
    workload: &Workload,
    built: &build::Plan<C>,
    pools: &Pools,
) -> Result<Vec<Versions>, BuildError> {
    let of_task = |(i, task): (usize, &Task)| {
        let mut dag = built.dags[i];
        let mut versions = Versions { base: Version::of(&dag, 0, task, pools), changes: Vec::new() };
        for change in built.changes.iter().filter(|change| change.task == i) {
            for step in &change.steps {
                apply(step, &mut dag, task)?;
            }
            versions.changes.push(Version::of(&dag, change.at.as_nanos(), task, pools));
        }
        Ok(versions)
    };
    workload.tasks.iter().enumerate().map(of_task).collect()
}

pub(super) fn apply<C: Capacity>(step: &Step, dag: &mut Dag<C>, task: &Task) -> Result<(), BuildError> {
    for node in &step.removed {
        dag.remove_node(*node);
    }
    for (_, node) in &step.added {
        dag.add_node(*node).map_err(|e| BuildError::Node(task.name.clone(), e))?;
    }
    for (from, to) in &step.edges {
        dag.add_edge(*from, *to).map_err(|e| BuildError::Edge(task.name.clone(), e))?;
    }
    Ok(())
}

/// One test and by how much it passes.
struct Test {
    what: String,
    at_ns: Option<u64>,
    margin: i128,
    /// What the margin is a part of.
    limit: u64,
}

impl Test {
    /// By share of the limit: tests of different units compare.
    fn tightness(&self, other: &Self) -> Ordering {
        // Centuries of work in a period of nanoseconds go beyond 128 bits, and are then as bad as can be.
        let share = |a: &Self, b: &Self| a.margin.saturating_mul(b.limit.max(1).into());
        share(self, other).cmp(&share(other, self))
    }
}

/// Applies every test.
pub(super) fn judge(
    workload: &Workload,
    pools: &Pools,
    versions: &[Versions],
    certificate: &certificate::Certificate,
) -> Admission {
    let tests = response_tests(workload, versions).chain(utilisation_tests(workload, pools, versions));
    let fits = fits(workload, pools, versions);
    let is_proved = fits && certificate.is_analytic();
    let tests: Vec<Test> =
        tests.chain(is_proved.then(|| proofs(certificate)).into_iter().flatten()).collect();
    let binding = tests.iter().min_by(|a, b| a.tightness(b));
    let guarantee = if is_proved { Guarantee::Analytic } else { Guarantee::BestEffort };
    Admission {
        fits,
        guarantee,
        binding: binding.map_or_else(String::new, |test| match test.at_ns {
            None => test.what.clone(),
            Some(at_ns) => format!("{} after the events at {}", test.what, Duration::from_nanos(at_ns)),
        }),
        margin_ns: binding.map_or(0, |test| test.margin),
    }
}

/// Whether every test says yes.
pub(super) fn fits(workload: &Workload, pools: &Pools, versions: &[Versions]) -> bool {
    let utilisation = utilisation_tests(workload, pools, versions);
    response_tests(workload, versions).chain(utilisation).all(|test| test.margin >= 0)
}

/// What is proved of all tasks together, of those that are not alone anyway.
fn proofs(certificate: &certificate::Certificate) -> impl Iterator<Item = Test> + '_ {
    certificate.tasks.iter().filter_map(|task| {
        let response_ns = task.response_ns?;
        let slowest = task.versions.iter().find(|version| version.response_ns == Some(response_ns))?;
        let test = slowest.proof.as_ref().filter(|proof| !proof.is_alone())?;
        Some(Test {
            what: format!("response time ({}) of task `{}` among all", test.name(), task.name),
            at_ns: None,
            margin: i128::from(task.deadline_ns) - i128::from(response_ns),
            limit: task.deadline_ns,
        })
    })
}

fn response_tests<'a>(workload: &'a Workload, versions: &'a [Versions]) -> impl Iterator<Item = Test> + 'a {
    let of_task = |(task, versions): (&'a Task, &'a Versions)| {
        versions.iter().enumerate().map(|(n, Version { proof, .. })| Test {
            what: format!("response time ({}) of task `{}`", proof.bound, task.name),
            at_ns: (n > 0).then_some(proof.at_ns),
            margin: proof.margin_ns,
            limit: proof.limit_ns,
        })
    };
    workload.tasks.iter().zip(versions).flat_map(of_task)
}

/// No pool may be asked for more than its lanes can do, at any time.
fn utilisation_tests(workload: &Workload, pools: &Pools, versions: &[Versions]) -> Vec<Test> {
    let changes = versions.iter().flat_map(|versions| &versions.changes);
    let mut instants: Vec<Option<u64>> = changes.map(|version| Some(version.proof.at_ns)).collect();
    instants.push(None);
    instants.sort_unstable();
    instants.dedup();
    let mut tests = Vec::new();
    for at_ns in instants {
        for (p, pool) in workload.pools.iter().enumerate() {
            let demand =
                |(task, versions): (_, &Versions)| Some((versions.at(at_ns).work_ns[p], period_ns(task)?));
            let demands: Vec<Demand> = workload.tasks.iter().zip(versions).filter_map(demand).collect();
            tests.push(Test {
                what: format!("utilisation of pool `{}`", pool.name),
                at_ns,
                margin: slack(&demands, pools.lanes[p]),
                limit: u64::from(pools.lanes[p]) * 1_000_000_000,
            });
        }
    }
    tests
}

#[cfg(test)]
mod tests;
