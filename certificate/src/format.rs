//! A certificate: what was proved, with everything that checking it again takes.
//!
//! It is one JSON object. Times are integers in nanoseconds. Whoever checks it evaluates one inequality for each version of
//! each task (of PREFIX one for each segment and the closing one, of several clusters one for each), with no search and no
//! fixed point:
//!
//! - `workload_sha256` is [`Set::digest`](crate::Set::digest) of the workload; `sha256` is SHA-256 of the JSON of all other
//!   fields, in this order, without spaces, with an empty `sha256` at the end.
//! - Every task is in `tasks`, in their order, with all of its versions. `response_ns` of a task is R, the largest of its
//!   versions' and within the deadline, or `null`: not proved. A task that is not proved does work until D + its largest node
//!   + 1 ns at most, because its jobs are given up when they are late.
//! - Chains are recomputed from `chain_of`: nodes of one version with the same number and cluster have to be totally ordered
//!   by reachability. A node of no cost counts as 1 ns, since it has to wait for a lane, too.
//! - Inequalities are those of `docs/admission.md`, with the R of all tasks as they stand here. What others do is bounded by
//!   all of their versions together: chains by their largest lengths, longest first; nodes and groups of all versions.
//! - `guarantee` of a cluster is `analytic` where each task with a node in it is proved, for a job is given up only so that
//!   another that needs the same lanes is in time; else `best-effort`.

use crate::set::hex;
use serde::{Deserialize, Serialize};

/// The version of this format.
pub const VERSION: u32 = 1;

/// What was proved of a workload.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    /// [`VERSION`].
    pub version: u32,
    /// [`Set::digest`](crate::Set::digest).
    pub workload_sha256: String,
    /// Rule of keys: `latest-start`.
    pub rule: String,
    /// Clusters in the order of the set.
    pub clusters: Vec<ClusterProof>,
    /// Tasks in the order of the set.
    pub tasks: Vec<TaskProof>,
    /// Least D - R of a proved task.
    pub margin_ns: Option<u64>,
    /// That task, and the test of its slowest version: `cruise by PREFIX`; empty where none is proved.
    pub binding: String,
    /// Of all fields above.
    pub sha256: String,
}

/// A cluster.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ClusterProof {
    /// Pool.
    pub pool: String,
    /// Name.
    pub name: String,
    /// Lanes.
    pub lanes: u32,
    /// What is known of its tasks.
    pub guarantee: Guarantee,
    /// Names of the tasks with a node in it.
    pub tasks: Vec<String>,
}

/// What a verdict is worth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Guarantee {
    /// Proved for every release offset and every execution time up to the WCET.
    Analytic,
    /// Not that.
    BestEffort,
}

/// A task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TaskProof {
    /// Name.
    pub name: String,
    /// D.
    pub deadline_ns: u64,
    /// R, if every version of it is proved.
    pub response_ns: Option<u64>,
    /// Its graphs, in the order of the set.
    pub versions: Vec<VersionProof>,
}

/// A graph of a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VersionProof {
    /// W: sum of all costs.
    pub work_ns: u64,
    /// L: longest path.
    pub critical_path_ns: u64,
    /// Lmin: shortest path from source to sink.
    pub shortest_path_ns: u64,
    /// H: nodes of the path with the most of them.
    pub hops: u64,
    /// kap: the latest key; below zero where D is below the longest path.
    pub last_key_ns: i64,
    /// Chain of each node within its cluster.
    pub chain_of: Vec<usize>,
    /// No job with this graph responds later; `null` where the task is not proved.
    pub response_ns: Option<u64>,
    /// How that is proved.
    pub proof: Option<Proof>,
}

/// How a response time is proved.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "test", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Proof {
    /// One inequality over the response time.
    A0 {
        /// Which nodes of others count.
        keys: Keys,
        /// How J's own work is bounded.
        variant: Variant,
    },
    /// One inequality for each segment of windows that begin before the release, and the closing one.
    Prefix {
        /// Which nodes of others count.
        keys: Keys,
        /// How J's own work is bounded.
        variant: Variant,
        /// Begins of the segments; the first is 0.
        segments_ns: Vec<u64>,
    },
    /// Nobody else is in its cluster, and R is within the period: its longest chain, and the rest on the lanes that so many
    /// chains leave.
    Paths {
        /// Chains beside the first that have a lane to themselves.
        chains: usize,
    },
    /// Nobody else is in its clusters, and R is within the period: (1 - 1/m) of its longest path, rounded down, with m the lanes
    /// of its widest cluster; 1 ns; and of each cluster the work over the lanes, rounded up.
    Pools,
    /// One inequality for each cluster.
    Several {
        /// Which nodes of others count.
        keys: Keys,
        /// Waits by cluster, in the order of the set; 0 where it has no node.
        waits_ns: Vec<u64>,
    },
}

/// Which nodes of others count as going before the job's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keys {
    /// All.
    Any,
    /// Those of no later keys, and those of later ones that had started.
    Key,
}

/// How the job's own work beside its critical chain is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Variant {
    /// By W - L, over waiting for the shortest path.
    A,
    /// By what can fall into the waiting.
    B,
}

impl Certificate {
    /// The certificate with its checksum.
    #[must_use]
    pub fn sealed(self) -> Self {
        let sha256 = self.checksum();
        Self { sha256, ..self }
    }

    /// What `sha256` has to be.
    #[must_use]
    pub fn checksum(&self) -> String {
        let open = Self { sha256: String::new(), ..self.clone() };
        // Plain data: there is nothing in it that JSON does not have.
        hex(serde_json::to_string(&open).unwrap_or_default().as_bytes())
    }

    /// Least D - R of a proved task, and whose it is by what. Of equals the first by name.
    #[must_use]
    pub fn tightest(tasks: &[TaskProof]) -> Option<(u64, String)> {
        let margin = |task: &TaskProof| {
            let response_ns = task.response_ns?;
            let slowest = task.versions.iter().find(|version| version.response_ns == task.response_ns)?;
            let binding = format!("{} by {}", task.name, slowest.proof.as_ref()?.name());
            Some((task.deadline_ns.saturating_sub(response_ns), binding))
        };
        tasks.iter().filter_map(margin).min()
    }

    /// Whether every task is proved.
    #[must_use]
    pub fn is_analytic(&self) -> bool {
        self.tasks.iter().all(|task| task.response_ns.is_some())
    }
}

impl Proof {
    /// Whether it takes for granted that no other job is about.
    #[must_use]
    pub const fn is_alone(&self) -> bool {
        matches!(self, Self::Paths { .. } | Self::Pools)
    }

    /// Name of the test.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self {
            Self::A0 { .. } => "A0",
            Self::Prefix { .. } => "PREFIX",
            Self::Paths { .. } => "chains alone",
            Self::Pools => "pools alone",
            Self::Several { .. } => "several clusters",
        }
    }
}
