//! Sets and certificates by hand, for tests.

use crate::graph::Shape;
use crate::{
    Certificate, Cluster, ClusterProof, Graph, Guarantee, Keys, Node, Proof, Rejected, Set, Task, TaskProof,
    VERSION, Variant, VersionProof, verify,
};

/// Chains, response time and proof of a graph.
type Claim<'a> = (&'a [usize], Option<(u64, Proof)>);

/// Those of the graphs of a task.
pub(crate) type Claims<'a> = &'a [Claim<'a>];

pub(crate) const ANY: Proof = Proof::A0 { keys: Keys::Any, variant: Variant::A };
pub(crate) const KEY: Proof = Proof::A0 { keys: Keys::Key, variant: Variant::B };

pub(crate) fn prefix(segments_ns: &[u64]) -> Proof {
    Proof::Prefix { keys: Keys::Key, variant: Variant::B, segments_ns: segments_ns.to_vec() }
}

pub(crate) fn graph(nodes: &[(u64, usize)], edges: &[(usize, usize)]) -> Graph {
    let node = |&(cost_ns, cluster): &(u64, usize)| Node { name: "n".to_owned(), cost_ns, cluster };
    Graph { nodes: nodes.iter().map(node).collect(), edges: edges.to_vec() }
}

/// In cluster 0.
pub(crate) fn task(
    name: &str,
    deadline_ns: u64,
    period_ns: u64,
    costs: &[u64],
    edges: &[(usize, usize)],
) -> Task {
    let nodes: Vec<_> = costs.iter().map(|cost| (*cost, 0)).collect();
    let versions = vec![graph(&nodes, edges)];
    Task { name: name.to_owned(), deadline_ns, period_ns: Some(period_ns), versions, ..Task::default() }
}

pub(crate) fn set(lanes: &[u32], tasks: Vec<Task>) -> Set {
    let cluster = |(c, lanes): (usize, &u32)| Cluster {
        pool: "gpu".to_owned(),
        name: format!("gpu{c}"),
        lanes: *lanes,
    };
    Set { most_jobs: 64, clusters: lanes.iter().enumerate().map(cluster).collect(), tasks }
}

/// What a set says, and these chains, response times and proofs of the graphs of each task.
pub(crate) fn certificate(set: &Set, claims: &[Claims<'_>]) -> Certificate {
    let tasks: Vec<TaskProof> = set
        .tasks
        .iter()
        .zip(claims)
        .map(|(task, claims)| {
            let version = |(graph, (chain_of, claim)): (&Graph, &Claim<'_>)| {
                let shape = Shape::of(graph, task.deadline_ns, set).expect("a graph");
                VersionProof {
                    work_ns: shape.work as u64,
                    critical_path_ns: shape.longest as u64,
                    shortest_path_ns: shape.shortest as u64,
                    hops: shape.hops as u64,
                    last_key_ns: shape.last_key as i64,
                    chain_of: chain_of.to_vec(),
                    response_ns: claim.as_ref().map(|(response, _)| *response),
                    proof: claim.as_ref().map(|(_, proof)| proof.clone()),
                }
            };
            let versions: Vec<_> = task.versions.iter().zip(*claims).map(version).collect();
            let response_ns = versions.iter().filter_map(|version| version.response_ns).max();
            TaskProof { name: task.name.clone(), deadline_ns: task.deadline_ns, response_ns, versions }
        })
        .collect();
    let cluster = |(c, cluster): (usize, &Cluster)| {
        let is_in = |task: &&Task| task.versions.iter().flat_map(|g| &g.nodes).any(|node| node.cluster == c);
        let names: Vec<String> = set.tasks.iter().filter(is_in).map(|task| task.name.clone()).collect();
        let is_open = |(task, tied): (&TaskProof, bool)| tied && task.response_ns.is_none();
        let guarantee = if tasks.iter().zip(set.tied_to(c)).any(is_open) {
            Guarantee::BestEffort
        } else {
            Guarantee::Analytic
        };
        let Cluster { pool, name, lanes } = cluster.clone();
        ClusterProof { pool, name, lanes, guarantee, tasks: names }
    };
    sealed(Certificate {
        version: VERSION,
        workload_sha256: set.digest(),
        rule: "latest-start".to_owned(),
        clusters: set.clusters.iter().enumerate().map(cluster).collect(),
        tasks,
        margin_ns: None,
        binding: String::new(),
        sha256: String::new(),
    })
}

/// With what follows from its tasks.
pub(crate) fn sealed(mut certificate: Certificate) -> Certificate {
    let (margin_ns, binding) = Certificate::tightest(&certificate.tasks).unzip();
    (certificate.margin_ns, certificate.binding) = (margin_ns, binding.unwrap_or_default());
    certificate.sealed()
}

/// Single graphs in which all nodes are of one chain.
pub(crate) fn verdict(set: &Set, claims: &[(u64, Proof)]) -> Result<(), Rejected> {
    let chains: Vec<Vec<usize>> =
        set.tasks.iter().map(|task| vec![0; task.versions[0].nodes.len()]).collect();
    let claims: Vec<[(&[usize], _); 1]> =
        claims.iter().zip(&chains).map(|(claim, chain)| [(chain.as_slice(), Some(claim.clone()))]).collect();
    let claims: Vec<Claims<'_>> = claims.iter().map(<[_; 1]>::as_slice).collect();
    verify(&certificate(set, &claims), set)
}

/// An inequality does not hold.
#[track_caller]
pub(crate) fn is_false(verdict: Result<(), Rejected>) {
    let error = verdict.expect_err("accepted");
    assert!(matches!(error, Rejected::Inequality { .. }), "{error:?}");
}

/// A test is named that needs this.
#[track_caller]
pub(crate) fn does_not_apply(verdict: Result<(), Rejected>, why: &str) {
    let error = verdict.expect_err("accepted");
    assert!(matches!(&error, Rejected::Test { needs, .. } if needs.contains(why)), "{error:?}");
}

/// The message has this part, and what to do.
#[track_caller]
pub(crate) fn is_of(verdict: Result<(), Rejected>, part: &str) {
    let text = verdict.expect_err(part).to_string();
    assert!(text.contains(part), "{text:?} is not about {part:?}");
    assert!(text.contains("make it anew") || text.contains("mended"), "{text}");
}
