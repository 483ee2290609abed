//! The search: bounds of all tasks that hold together.
//!
//! *Rule.* Every task begins with R = D, and takes the least R that tests prove for each of its graphs with the R of all
//! others, until nothing changes. A task that no test proves is one that is cut: its jobs are given up once they are late, so
//! they have work until D + the largest node; then everything begins anew.
//! *Why it holds.* All tests hold in the same final vector, which is checked once more at the end.

use crate::interference::{Keys, Looked, Other};
use crate::member::{Member, only};
use crate::several::{self, InCluster};
use crate::shape::{Part, Shape};
use crate::single::{Proved, Single, Variant};
use red_certificate::{
    self as certificate, Certificate, ClusterProof, Guarantee, Proof, Set, TaskProof, VERSION, VersionProof,
};

/// Rounds of the outer fixed point.
const ROUNDS: usize = 16;

/// Proves what it can of a set. Time bound: rounds times tasks times graphs times four times 8,192 evaluations of an inequality,
/// each O(tasks * (chains + nodes + room)); milliseconds for sets of the usual size.
///
/// ```
/// use red_analysis::prove;
/// use red_certificate::{Cluster, Graph, Node, Set, Task};
/// let node = |name: &str, cost_ns| Node { name: name.to_owned(), cost_ns, cluster: 0 };
/// let task = |name: &str, period| Task {
///     name: name.to_owned(),
///     deadline_ns: period,
///     period_ns: Some(period),
///     versions: vec![Graph { nodes: vec![node("a", 2_000), node("b", 3_000)], edges: vec![(0, 1)] }],
///     ..Task::default()
/// };
/// let set = Set {
///     most_jobs: 64,
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
    Pools { response: i128 },
}

impl Found {
    const fn response(&self) -> i128 {
        match self {
            Self::Single(proved) => proved.response,
            Self::Several(waits) => waits.response,
            Self::Paths { response, .. } | Self::Pools { response } => *response,
        }
    }
}

struct Search {
    members: Vec<Member>,
    lanes: Vec<i128>,
    most_jobs: i128,
    /// Tasks that nothing can be proved of.
    is_open: Vec<bool>,
    /// By task: those that share an encoder's result with it.
    partners: Vec<Vec<usize>>,
}

/// What proves each graph of a task; nothing, if one is not proved.
type Proofs = Option<Vec<Found>>;

impl Search {
    fn of(set: &Set) -> Self {
        Self {
            members: set.tasks.iter().map(|task| Member::of(&set.clusters, task)).collect(),
            lanes: set.clusters.iter().map(|cluster| cluster.lanes.into()).collect(),
            most_jobs: set.most_jobs.into(),
            is_open: set.tasks.iter().map(|task| task.waits || !set.is_in_range()).collect(),
            partners: set.tasks.iter().map(|task| partners(set, task)).collect(),
        }
    }

    /// How long after its release a job may be at work at most, that no proof goes beyond: D, and as many periods as there is
    /// room for jobs.
    fn limit(&self, member: &Member) -> i128 {
        member.period.map_or(member.deadline, |period| member.deadline.min(period * self.most_jobs))
    }

    /// Bounds that hold together, and what proves them; those of tasks that are cut are not proved.
    fn run(&self) -> (Vec<i128>, Vec<Proofs>) {
        let mut is_cut = self.is_open.clone();
        loop {
            let alone = |k: &usize| !is_cut[*k] && self.partners[*k].iter().any(|i| is_cut[*i]);
            if let Some(k) = (0..is_cut.len()).find(alone) {
                is_cut[k] = true;
                continue;
            }
            if !self.has_room_beside(&is_cut) {
                let deadlines = self.members.iter().map(|member| member.deadline).collect();
                return (deadlines, vec![None; self.members.len()]);
            }
            match self.settle(&is_cut) {
                Err(unproved) => is_cut[unproved] = true,
                Ok((bounds, _)) if !self.has_room(&bounds) => {
                    return (bounds, vec![None; self.members.len()]);
                }
                Ok(found) => return found,
            }
        }
    }

    /// The same where these tasks are cut; or one more that has to be.
    fn settle(&self, is_cut: &[bool]) -> Result<(Vec<i128>, Vec<Proofs>), usize> {
        let start = |(member, is_cut): (&Member, &bool)| {
            if *is_cut { member.cut_at() } else { self.limit(member) }
        };
        let mut bounds: Vec<i128> = self.members.iter().zip(is_cut).map(start).collect();
        let mut proofs: Vec<Proofs> = vec![None; self.members.len()];
        // The bounds that each task was proved with.
        let mut seen: Vec<Vec<i128>> = vec![Vec::new(); self.members.len()];
        for _ in 0..ROUNDS {
            let before = bounds.clone();
            for k in (0..self.members.len()).filter(|k| !is_cut[*k]) {
                if seen[k] == bounds {
                    continue;
                }
                seen[k].clone_from(&bounds);
                if let Some(found) = self.best(k, &bounds) {
                    let response = found.iter().map(Found::response).max().unwrap_or(0);
                    bounds[k] = response.min(bounds[k]);
                    proofs[k] = Some(found);
                } else if proofs[k].is_none() {
                    // With the bounds of others only falling, what was proved stays proved.
                    return Err(k);
                }
            }
            if bounds == before {
                break;
            }
        }
        Ok((bounds, proofs))
    }

    /// Whether no job can find the scheduler full.
    fn has_room(&self, bounds: &[i128]) -> bool {
        self.members.iter().zip(bounds).map(|(member, bound)| member.at_once(*bound)).sum::<i128>()
            <= self.most_jobs
    }

    /// Whether jobs of tasks that are cut leave room for one of each other.
    fn has_room_beside(&self, is_cut: &[bool]) -> bool {
        let bound = |(member, is_cut): (&Member, &bool)| if *is_cut { member.cut_at() } else { 0 };
        self.has_room(&self.members.iter().zip(is_cut).map(bound).collect::<Vec<i128>>())
    }

    fn others<'a>(&'a self, k: usize, cluster: usize, bounds: &[i128]) -> Vec<Other<'a>> {
        let other = |(i, member): (usize, &'a Member)| {
            let part = member.parts[cluster].as_ref().filter(|_| i != k)?;
            Some(Other { period: member.period, part, bound: bounds[i] })
        };
        self.members.iter().enumerate().filter_map(other).collect()
    }

    /// Whether the limited carry-in of PREFIX may be claimed: nobody in the cluster is elsewhere, too, or overlaps itself.
    fn has_prefix(&self, cluster: usize) -> bool {
        self.members.iter().filter(|member| member.parts[cluster].is_some()).all(|member| {
            member.only_cluster() == Some(cluster)
                && member.period.is_none_or(|period| member.deadline <= period)
        })
    }

    /// The best proof of each graph of a task.
    fn best(&self, k: usize, bounds: &[i128]) -> Proofs {
        let alone = self.alone(k, bounds[k]);
        let of = |(nth, shape): (usize, &Shape)| {
            let found = match only(&shape.parts) {
                Some(cluster) => self.in_one(k, shape, cluster, bounds),
                None => self.in_several(k, shape, bounds),
            };
            let alone = alone.as_ref().map(|alone| alone[nth].clone());
            found.into_iter().chain(alone).min_by_key(Found::response)
        };
        self.members[k].shapes.iter().enumerate().map(of).collect()
    }

    fn in_one(&self, k: usize, shape: &Shape, cluster: usize, bounds: &[i128]) -> Option<Found> {
        let Member { period, parts, .. } = &self.members[k];
        let others = self.others(k, cluster, bounds);
        let looked = Looked { shape, others: &others, lanes: self.lanes[cluster] };
        let this = Other { period: *period, part: parts[cluster].as_ref()?, bound: bounds[k] };
        let single = Single { looked, part: shape.parts[cluster].as_ref()?, this };
        single.best(bounds[k], self.has_prefix(cluster)).map(Found::Single)
    }

    fn in_several(&self, k: usize, shape: &Shape, bounds: &[i128]) -> Option<Found> {
        // The test for several clusters knows no other jobs of the same task.
        let member = &self.members[k];
        if member.period.is_some_and(|period| member.deadline > period) {
            return None;
        }
        let used: Vec<(usize, &Part)> =
            shape.parts.iter().enumerate().filter_map(|(at, part)| Some((at, part.as_ref()?))).collect();
        let others: Vec<Vec<Other<'_>>> =
            used.iter().map(|(cluster, _)| self.others(k, *cluster, bounds)).collect();
        let mut parts = Vec::with_capacity(used.len());
        for ((cluster, part), others) in used.into_iter().zip(&others) {
            let looked = Looked { shape, others, lanes: self.lanes[cluster] };
            parts.push(InCluster { cluster, looked, part });
        }
        several::waits(&parts, shape.longest, bounds[k]).map(Found::Several)
    }

    /// Bounds of a task that has its clusters to itself, one job after the other, if each of its graphs has one before the next
    /// job comes.
    fn alone(&self, k: usize, limit: i128) -> Proofs {
        let member = &self.members[k];
        let is_mine = |cluster: usize| member.parts[cluster].is_some();
        let meets = |other: &Member| (0..self.lanes.len()).any(|c| is_mine(c) && other.parts[c].is_some());
        if self.members.iter().enumerate().any(|(i, other)| i != k && meets(other)) {
            return None;
        }
        let limit = member.period.map_or(limit, |period| period.min(limit));
        let of = |shape: &Shape| {
            let found = match only(&shape.parts) {
                Some(cluster) => self.paths(shape, cluster),
                None => Some(self.pools(shape)),
            };
            found.filter(|found| found.response() <= limit)
        };
        member.shapes.iter().map(of).collect()
    }

    /// The multi-path bound: He et al., RTSS 2022.
    fn paths(&self, shape: &Shape, cluster: usize) -> Option<Found> {
        let (part, lanes) = (shape.parts[cluster].as_ref()?, self.lanes[cluster]);
        let mut rest = part.work;
        let bounds = (0..lanes).zip(&part.chains).enumerate().map(|(nth, (taken, length))| {
            rest -= length;
            let response = shape.longest + (rest + lanes - taken - 1).div_euclid(lanes - taken);
            Found::Paths { response, chains: nth }
        });
        bounds.min_by_key(Found::response)
    }

    /// Graham's bound over several pools: Han et al., TPDS 2019.
    fn pools(&self, shape: &Shape) -> Found {
        let used = || shape.parts.iter().zip(&self.lanes).filter_map(|(part, m)| Some((part.as_ref()?, *m)));
        let widest = used().map(|(_, lanes)| lanes).max().unwrap_or(1);
        let shares: i128 = used().map(|(part, lanes)| (part.work + lanes - 1).div_euclid(lanes)).sum();
        Found::Pools { response: shape.longest * (widest - 1) / widest + 1 + shares }
    }

    fn certificate(&self, set: &Set, bounds: &[i128], proofs: &[Proofs]) -> Certificate {
        let tasks: Vec<TaskProof> = (0..set.tasks.len())
            .map(|i| {
                let (task, proofs) = (&set.tasks[i], proofs[i].as_ref());
                let version = |(nth, shape): (usize, &Shape)| {
                    self.version(shape, proofs.and_then(|proofs| proofs.get(nth)))
                };
                TaskProof {
                    name: task.name.clone(),
                    deadline_ns: task.deadline_ns,
                    response_ns: proofs.map(|_| narrow(bounds[i])),
                    versions: self.members[i].shapes.iter().enumerate().map(version).collect(),
                }
            })
            .collect();
        let is_proved = |i: usize| tasks[i].response_ns.is_some();
        let cluster = |(c, cluster): (usize, &certificate::Cluster)| {
            let here = || (0..tasks.len()).filter(move |i| self.members[*i].parts[c].is_some());
            let tied = set.tied_to(c);
            let is_proved = (0..tasks.len()).filter(|i| tied[*i]).all(is_proved);
            ClusterProof {
                pool: cluster.pool.clone(),
                name: cluster.name.clone(),
                lanes: cluster.lanes,
                guarantee: if is_proved { Guarantee::Analytic } else { Guarantee::BestEffort },
                tasks: here().map(|i| tasks[i].name.clone()).collect(),
            }
        };
        Certificate {
            version: VERSION,
            workload_sha256: set.digest(),
            rule: "latest-start".to_owned(),
            clusters: set.clusters.iter().enumerate().map(cluster).collect(),
            margin_ns: Certificate::tightest(&tasks).map(|(margin, _)| margin),
            binding: Certificate::tightest(&tasks).map_or_else(String::new, |(_, binding)| binding),
            tasks,
            sha256: String::new(),
        }
        .sealed()
    }

    fn version(&self, shape: &Shape, found: Option<&Found>) -> VersionProof {
        VersionProof {
            work_ns: narrow(shape.work),
            critical_path_ns: narrow(shape.longest),
            shortest_path_ns: narrow(shape.shortest),
            hops: narrow(shape.hops),
            last_key_ns: i64::try_from(shape.last_key).unwrap_or(if shape.last_key < 0 {
                i64::MIN
            } else {
                i64::MAX
            }),
            chain_of: shape.chain_of.clone(),
            response_ns: found.map(|found| narrow(found.response())),
            proof: found.map(|found| self.proof(found)),
        }
    }

    fn proof(&self, found: &Found) -> Proof {
        let keys = |keys: Keys| match keys {
            Keys::Any => certificate::Keys::Any,
            Keys::Key => certificate::Keys::Key,
        };
        match found {
            Found::Paths { chains, .. } => Proof::Paths { chains: *chains },
            Found::Pools { .. } => Proof::Pools,
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

/// Other tasks that share an encoder's result with this one.
fn partners(set: &Set, task: &certificate::Task) -> Vec<usize> {
    let shares = |other: &certificate::Task| {
        other.name != task.name && other.frames.iter().any(|frame| task.frames.contains(frame))
    };
    (0..set.tasks.len()).filter(|i| shares(&set.tasks[*i])).collect()
}

/// What is within a deadline fits.
fn narrow(ns: i128) -> u64 {
    u64::try_from(ns).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
