//! The search: bounds of all tasks that hold together.
//!
//! *Rule.* Every task begins with R = D, and takes the least R that a test proves with the R of all others, until nothing
//! changes. A task that no test proves is one that is cut: its jobs are given up once they are late, so they have work until
//! D + the largest node; then everything begins anew.
//! *Why it holds.* All tests hold in the same final vector, which is checked once more at the end.

use crate::certificate::{self, Certificate, ClusterProof, Guarantee, Proof, TaskProof, VERSION};
use crate::interference::{Keys, Looked, Other};
use crate::set::Set;
use crate::several::{self, InCluster};
use crate::shape::Shape;
use crate::single::{Proved, Single, Variant};

/// Rounds of the outer fixed point.
const ROUNDS: usize = 16;

/// Proves what it can of a set. Time bound: a few milliseconds for sets of the usual size.
///
/// ```
/// use red_analysis::{Cluster, Node, Set, Task, prove};
/// let node = |name: &str, cost_ns| Node { name: name.to_owned(), cost_ns, cluster: 0 };
/// let task = |name: &str, period| Task {
///     name: name.to_owned(),
///     deadline_ns: period,
///     period_ns: Some(period),
///     nodes: vec![node("a", 2_000), node("b", 3_000)],
///     edges: vec![(0, 1)],
/// };
/// let set = Set {
///     clusters: vec![Cluster { pool: "gpu".to_owned(), name: "gpu".to_owned(), lanes: 1 }],
///     tasks: vec![task("fast", 20_000), task("slow", 40_000)],
/// };
/// let certificate = prove(&set);
/// assert!(certificate.is_analytic());
/// // Its own 5,000, and a node of the other that had started.
/// assert_eq!(certificate.tasks[0].response_ns, Some(8_000));
/// ```
#[must_use]
pub fn prove(set: &Set) -> Certificate {
    let search = Search::of(set);
    let (bounds, proofs) = search.run();
    search.certificate(set, &bounds, &proofs)
}

/// What proves a task.
#[derive(Clone, Debug)]
enum Found {
    Single(Proved),
    Several(several::Waits),
    Paths { response: i128, chains: usize },
}

impl Found {
    const fn response(&self) -> i128 {
        match self {
            Self::Single(proved) => proved.response,
            Self::Several(waits) => waits.response,
            Self::Paths { response, .. } => *response,
        }
    }
}

struct Search {
    shapes: Vec<Shape>,
    lanes: Vec<i128>,
}

impl Search {
    fn of(set: &Set) -> Self {
        Self {
            shapes: set.tasks.iter().map(|task| Shape::of(set, task)).collect(),
            lanes: set.clusters.iter().map(|cluster| cluster.lanes.into()).collect(),
        }
    }

    /// Bounds that hold together, and what proves them; those of tasks that are cut are not proved.
    fn run(&self) -> (Vec<i128>, Vec<Option<Found>>) {
        let mut is_cut = vec![false; self.shapes.len()];
        loop {
            let start = |(shape, is_cut): (&Shape, &bool)| {
                if *is_cut { shape.deadline + shape.largest + 1 } else { shape.deadline }
            };
            let mut bounds: Vec<i128> = self.shapes.iter().zip(&is_cut).map(start).collect();
            let mut proofs: Vec<Option<Found>> = vec![None; self.shapes.len()];
            let mut unproved = None;
            for _ in 0..ROUNDS {
                let before = bounds.clone();
                for k in (0..self.shapes.len()).filter(|k| !is_cut[*k]) {
                    match self.best(k, &bounds) {
                        Some(found) => {
                            bounds[k] = found.response().min(bounds[k]);
                            proofs[k] = Some(found);
                        }
                        // With the bounds of others only falling, what was proved stays proved.
                        None if proofs[k].is_some() => {}
                        None => unproved = Some(k),
                    }
                    if unproved.is_some() {
                        break;
                    }
                }
                if unproved.is_some() || bounds == before {
                    break;
                }
            }
            match unproved {
                Some(k) => is_cut[k] = true,
                None => return (bounds, proofs),
            }
        }
    }

    fn others<'a>(&'a self, k: usize, cluster: usize, bounds: &[i128]) -> Vec<Other<'a>> {
        let other = |(i, shape): (usize, &'a Shape)| {
            let part = shape.parts[cluster].as_ref().filter(|_| i != k)?;
            Some(Other { shape, part, bound: bounds[i] })
        };
        self.shapes.iter().enumerate().filter_map(other).collect()
    }

    /// Whether the limited carry-in of PREFIX may be claimed: nobody in the cluster is elsewhere, too, or overlaps itself.
    fn has_prefix(&self, cluster: usize) -> bool {
        self.shapes.iter().filter(|shape| shape.parts[cluster].is_some()).all(|shape| {
            shape.only_cluster() == Some(cluster)
                && shape.period.is_none_or(|period| shape.deadline <= period)
        })
    }

    fn best(&self, k: usize, bounds: &[i128]) -> Option<Found> {
        let shape = &self.shapes[k];
        if let Some(cluster) = shape.only_cluster() {
            let (part, others) = (shape.parts[cluster].as_ref()?, self.others(k, cluster, bounds));
            let looked = Looked { shape, others: &others, lanes: self.lanes[cluster] };
            let single = Single { looked, part, bound: bounds[k] };
            let found = single.best(bounds[k], self.has_prefix(cluster)).map(Found::Single);
            let alone = self.alone(k, others.is_empty(), bounds[k]);
            return found.into_iter().chain(alone).min_by_key(Found::response);
        }
        // The test for several clusters knows no other jobs of the same task.
        if shape.period.is_some_and(|period| shape.deadline > period) {
            return None;
        }
        let used: Vec<usize> =
            (0..self.lanes.len()).filter(|cluster| shape.parts[*cluster].is_some()).collect();
        let others: Vec<Vec<Other<'_>>> =
            used.iter().map(|cluster| self.others(k, *cluster, bounds)).collect();
        let parts: Vec<InCluster<'_>> = used
            .iter()
            .zip(&others)
            .filter_map(|(cluster, others)| {
                let looked = Looked { shape, others, lanes: self.lanes[*cluster] };
                Some(InCluster { cluster: *cluster, looked, part: shape.parts[*cluster].as_ref()? })
            })
            .collect();
        several::waits(&parts, shape.longest, bounds[k]).map(Found::Several)
    }

    /// The multi-path bound of a task that has its cluster to itself, one job after the other: He et al., RTSS 2022.
    fn alone(&self, k: usize, is_alone: bool, limit: i128) -> Option<Found> {
        let shape = &self.shapes[k];
        let cluster = shape.only_cluster().filter(|_| is_alone)?;
        let (part, lanes) = (shape.parts[cluster].as_ref()?, self.lanes[cluster]);
        let mut rest = part.work;
        let bounds = (0..lanes).zip(&part.chains).enumerate().map(|(nth, (taken, length))| {
            rest -= length;
            let response = shape.longest + (rest + lanes - taken - 1).div_euclid(lanes - taken);
            Found::Paths { response, chains: nth }
        });
        let best = bounds.min_by_key(Found::response)?;
        let limit = shape.period.map_or(limit, |period| period.min(limit));
        (best.response() <= limit).then_some(best)
    }

    fn certificate(&self, set: &Set, bounds: &[i128], proofs: &[Option<Found>]) -> Certificate {
        let task = |(i, task): (usize, &crate::set::Task)| {
            let shape = &self.shapes[i];
            let work = shape.parts.iter().flatten().map(|part| part.work).sum();
            TaskProof {
                name: task.name.clone(),
                deadline_ns: task.deadline_ns,
                response_ns: proofs[i].as_ref().map(|_| narrow(bounds[i])),
                work_ns: narrow(work),
                critical_path_ns: narrow(shape.longest),
                shortest_path_ns: narrow(shape.shortest),
                hops: narrow(shape.hops),
                last_key_ns: i64::try_from(shape.last_key).unwrap_or(i64::MIN),
                chain_of: shape.chain_of.clone(),
                proof: proofs[i].as_ref().map(|found| self.proof(found)),
            }
        };
        let tasks: Vec<TaskProof> = set.tasks.iter().enumerate().map(task).collect();
        let cluster = |(c, cluster): (usize, &crate::set::Cluster)| {
            let here = || self.shapes.iter().zip(&tasks).filter(move |(shape, _)| shape.parts[c].is_some());
            let is_proved = here().all(|(_, task)| task.response_ns.is_some());
            ClusterProof {
                pool: cluster.pool.clone(),
                name: cluster.name.clone(),
                lanes: cluster.lanes,
                guarantee: if is_proved { Guarantee::Analytic } else { Guarantee::BestEffort },
                tasks: here().map(|(_, task)| task.name.clone()).collect(),
            }
        };
        let margin = |task: &TaskProof| {
            Some((task.deadline_ns - task.response_ns?, task.name.clone(), task.proof.as_ref()?.name()))
        };
        let tightest = tasks.iter().filter_map(margin).min();
        Certificate {
            version: VERSION,
            workload_sha256: set.digest(),
            rule: "latest-start".to_owned(),
            clusters: set.clusters.iter().enumerate().map(cluster).collect(),
            margin_ns: tightest.as_ref().map(|(margin, ..)| *margin),
            binding: tightest.map_or_else(String::new, |(_, task, test)| format!("{task} by {test}")),
            tasks,
            sha256: String::new(),
        }
        .sealed()
    }

    fn proof(&self, found: &Found) -> Proof {
        let keys = |keys: Keys| match keys {
            Keys::Any => certificate::Keys::Any,
            Keys::Key => certificate::Keys::Key,
        };
        match found {
            Found::Paths { chains, .. } => Proof::Paths { chains: *chains },
            Found::Several(waits) => {
                let wait =
                    |cluster: usize| waits.waits.iter().find(|(c, _)| *c == cluster).map_or(0, |(_, y)| *y);
                Proof::Several {
                    keys: keys(waits.keys),
                    waits_ns: (0..self.lanes.len()).map(|cluster| narrow(wait(cluster))).collect(),
                }
            }
            Found::Single(proved) => {
                let variant = match proved.variant {
                    Variant::A => certificate::Variant::A,
                    Variant::B => certificate::Variant::B,
                };
                match &proved.segments {
                    None => Proof::A0 { keys: keys(proved.keys), variant },
                    Some(segments) => Proof::Prefix {
                        keys: keys(proved.keys),
                        variant,
                        segments_ns: segments.iter().map(|at| narrow(*at)).collect(),
                    },
                }
            }
        }
    }
}

impl Proof {
    /// Name of the test.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::A0 { .. } => "A0",
            Self::Prefix { .. } => "PREFIX",
            Self::Paths { .. } => "chains alone",
            Self::Several { .. } => "several clusters",
        }
    }
}

/// What is within a deadline fits.
fn narrow(ns: i128) -> u64 {
    u64::try_from(ns).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
