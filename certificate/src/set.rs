//! What is to be proved: tasks, and the clusters of lanes that their nodes run on.

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fmt::Write;

/// A set of tasks. Edges lead between nodes of one graph, and graphs are acyclic and not empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Set {
    /// Jobs that the scheduler has room for; one more is shed at its release.
    pub most_jobs: u64,
    /// Clusters.
    pub clusters: Vec<Cluster>,
    /// Tasks.
    pub tasks: Vec<Task>,
}

/// Lanes that are dispatched together, and apart from all others.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Cluster {
    /// Pool that they are lanes of.
    pub pool: String,
    /// Name; that of the pool where it is not divided.
    pub name: String,
    /// How many, at least one.
    pub lanes: u32,
}

/// A sporadic task. Times are in nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Task {
    /// Name.
    pub name: String,
    /// Relative deadline.
    pub deadline_ns: u64,
    /// Least time between releases; `None`: it is released once.
    pub period_ns: Option<u64>,
    /// Whether a ready node of it may have to wait for something other than a lane, such as memory. Nothing is proved then.
    pub waits: bool,
    /// Names of the encoder results that it may share with other jobs. Whoever waits for a result that is being computed
    /// counts as computing it; so tasks that share one are proved all or none.
    pub frames: Vec<String>,
    /// Every graph that it ever has, at least one. Nothing is assumed of when it has which: a job keeps that of its release.
    pub versions: Vec<Graph>,
}

/// A graph.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Graph {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// From, to.
    pub edges: Vec<(usize, usize)>,
}

/// A node.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Node {
    /// Name.
    pub name: String,
    /// WCET and contention, in nanoseconds.
    pub cost_ns: u64,
    /// Which of the set's clusters it runs on.
    pub cluster: usize,
}

/// The longest deadline and the most work of a graph that anything is proved of: 73 minutes. Sums and products of the
/// inequalities stay within 128 bits then.
const MOST_NS: u64 = 1 << 42;

impl Set {
    /// Whether the numbers are small enough for anything to be proved: deadlines, and the work of each graph, up to 73
    /// minutes.
    #[must_use]
    pub fn is_in_range(&self) -> bool {
        let work = |graph: &Graph| {
            graph.nodes.iter().fold(0u64, |sum, node| sum.saturating_add(node.cost_ns.max(1)))
        };
        self.tasks.iter().all(|task| {
            task.deadline_ns <= MOST_NS && task.versions.iter().all(|graph| work(graph) <= MOST_NS)
        })
    }

    /// The tasks that decide whether a cluster is proved: those with nodes in it, and in every cluster in which these have
    /// any, and so on. Under overload the order of keys is given up for all of them.
    #[must_use]
    pub fn tied_to(&self, cluster: usize) -> Vec<bool> {
        let uses = |task: &Task, clusters: &[bool]| {
            task.versions.iter().flat_map(|graph| &graph.nodes).any(|node| clusters[node.cluster])
        };
        let (mut clusters, mut tied) = (vec![false; self.clusters.len()], vec![false; self.tasks.len()]);
        clusters[cluster] = true;
        while let Some(next) = (0..tied.len()).find(|i| !tied[*i] && uses(&self.tasks[*i], &clusters)) {
            tied[next] = true;
            let nodes = self.tasks[next].versions.iter().flat_map(|graph| &graph.nodes);
            nodes.for_each(|node| clusters[node.cluster] = true);
        }
        tied
    }

    /// SHA-256 of everything in it, in hexadecimal digits: of one line for the room, each cluster, task, version, node and
    /// edge, in their order, as words with a space between them. Names have no spaces.
    #[must_use]
    pub fn digest(&self) -> String {
        // Nothing that is written to a string fails.
        let mut text = format!("jobs {}\n", self.most_jobs);
        for Cluster { pool, name, lanes } in &self.clusters {
            let _ = writeln!(text, "cluster {pool} {name} {lanes}");
        }
        for task in &self.tasks {
            let period = task.period_ns.map_or_else(|| "once".to_owned(), |ns| ns.to_string());
            let Task { name, deadline_ns, waits, frames, .. } = task;
            let _ = writeln!(text, "task {name} {deadline_ns} {period} {waits}");
            for frame in frames {
                let _ = writeln!(text, "frame {frame}");
            }
            for graph in &task.versions {
                text.push_str("version\n");
                for Node { name, cost_ns, cluster } in &graph.nodes {
                    let _ = writeln!(text, "node {name} {cost_ns} {cluster}");
                }
                for (from, to) in &graph.edges {
                    let _ = writeln!(text, "edge {from} {to}");
                }
            }
        }
        hex(text.as_bytes())
    }
}

/// SHA-256 in hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
