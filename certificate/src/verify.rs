//! The check: one pass over everything that a certificate states. It searches for nothing.

use crate::graph::Shape;
use crate::inequality::{Claim, World};
use crate::work::Load;
use crate::{Certificate, Guarantee, Rejected, Set, Task, TaskProof, VERSION, VersionProof};
use serde::Serialize;

/// Whether a certificate proves what it states of this set. Times are in nanoseconds; it takes time linear in the
/// inequalities that the certificate names, times nodes and jobs that the set has room for.
///
/// # Errors
/// What does not hold, and where.
///
/// # Examples
/// ```
/// use red_certificate::{Certificate, Rejected, Set, verify};
///
/// let set = Set::default();
/// let nothing = Certificate {
///     version: 1,
///     workload_sha256: set.digest(),
///     rule: "latest-start".to_owned(),
///     clusters: vec![],
///     tasks: vec![],
///     margin_ns: None,
///     binding: String::new(),
///     sha256: String::new(),
/// };
/// assert_eq!(verify(&nothing.clone().sealed(), &set), Ok(()));
/// assert!(matches!(verify(&nothing, &set), Err(Rejected::Statement { .. })));
/// ```
pub fn verify(certificate: &Certificate, set: &Set) -> Result<(), Rejected> {
    same("version", &VERSION, &certificate.version)?;
    same("rule", "latest-start", certificate.rule.as_str())?;
    same("workload_sha256", &set.digest(), &certificate.workload_sha256)?;
    same("sha256", &certificate.checksum(), &certificate.sha256)?;
    let shapes = shapes(set)?;
    tasks(certificate, set, &shapes)?;
    clusters(certificate, set)?;
    partners(certificate, set)?;
    if certificate.tasks.iter().any(|task| task.response_ns.is_some()) {
        let chains = chains(certificate, set, &shapes)?;
        let bounds = bounds(certificate, set, &shapes)?;
        let loads = loads(set, &shapes, &chains, &bounds);
        let world = World { set, shapes: &shapes, chains: &chains, loads: &loads };
        proofs(certificate, &world)?;
    } else {
        // Chains are stated where nothing is proved, too.
        chains(certificate, set, &shapes)?;
    }
    let (margin_ns, binding) = Certificate::tightest(&certificate.tasks).unzip();
    same("margin_ns", &margin_ns, &certificate.margin_ns)?;
    same("binding", &binding.unwrap_or_default(), &certificate.binding)
}

/// Graphs of each task.
fn shapes(set: &Set) -> Result<Vec<Vec<Shape>>, Rejected> {
    for cluster in &set.clusters {
        if cluster.lanes == 0 {
            let place = format!("cluster {}", cluster.name);
            return Err(Rejected::Set { place, wrong: "a cluster without lanes" });
        }
    }
    let mut shapes = Vec::new();
    for task in &set.tasks {
        let wrong = |wrong| Rejected::Set { place: format!("task {}", task.name), wrong };
        if task.versions.is_empty() {
            return Err(wrong("a task without a graph"));
        }
        if task.period_ns == Some(0) {
            return Err(wrong("a task without a least time between releases"));
        }
        let graphs = task.versions.iter().map(|graph| Shape::of(graph, task.deadline_ns, set));
        shapes.push(graphs.collect::<Result<Vec<_>, _>>().map_err(wrong)?);
    }
    Ok(shapes)
}

/// What is stated of tasks and their graphs, without the proofs.
fn tasks(certificate: &Certificate, set: &Set, shapes: &[Vec<Shape>]) -> Result<(), Rejected> {
    same("number of tasks", &set.tasks.len(), &certificate.tasks.len())?;
    for ((task, proof), shapes) in set.tasks.iter().zip(&certificate.tasks).zip(shapes) {
        let name = &task.name;
        same(&format!("name of task {name}"), name, &proof.name)?;
        same(&format!("deadline_ns of task {name}"), &task.deadline_ns, &proof.deadline_ns)?;
        same(&format!("number of versions of task {name}"), &shapes.len(), &proof.versions.len())?;
        for (n, (shape, version)) in shapes.iter().zip(&proof.versions).enumerate() {
            let same = |what: &str, expected: i128, stated: i128| {
                self::same(&format!("{what} of task {name}, version {n}"), &expected, &stated)
            };
            // Numbers that have no room are stated as the next ones that have.
            let most = i128::from(u64::MAX);
            let last_key = shape.last_key.clamp(i128::from(i64::MIN), i128::from(i64::MAX));
            same("work_ns", shape.work.min(most), i128::from(version.work_ns))?;
            same("critical_path_ns", shape.longest.min(most), i128::from(version.critical_path_ns))?;
            same("shortest_path_ns", shape.shortest.min(most), i128::from(version.shortest_path_ns))?;
            same("hops", shape.hops, i128::from(version.hops))?;
            same("last_key_ns", last_key, i128::from(version.last_key_ns))?;
            same("length of chain_of", shape.nodes.len() as i128, version.chain_of.len() as i128)?;
        }
        responses(proof, shapes)?;
    }
    Ok(())
}

/// Response times of a task: all or none, within what can be, and the task's is the largest.
fn responses(proof: &TaskProof, shapes: &[Shape]) -> Result<(), Rejected> {
    let place = |what: &str| format!("{what} of task {}", proof.name);
    let is_proved = |version: &&VersionProof| version.response_ns.is_some();
    let proved = proof.versions.iter().filter(is_proved).count();
    let by = proof.versions.iter().filter(|version| version.proof.is_some()).count();
    let all = if proof.response_ns.is_some() { proof.versions.len() } else { 0 };
    same(&place("number of response times of versions"), &all, &proved)?;
    same(&place("number of proofs of versions"), &all, &by)?;
    let most = proof.versions.iter().filter_map(|version| version.response_ns).max();
    same(&place("response_ns"), &most, &proof.response_ns)?;
    if most > Some(proof.deadline_ns) {
        let expected = format!("{} at most", proof.deadline_ns);
        return Err(differs(&place("response_ns"), expected, words(&most)));
    }
    for (n, (shape, version)) in shapes.iter().zip(&proof.versions).enumerate() {
        if version.response_ns.is_some_and(|response| i128::from(response) < shape.longest) {
            let expected = format!("{} at least", shape.longest);
            let stated = words(&version.response_ns);
            return Err(differs(&place(&format!("response_ns of version {n}")), expected, stated));
        }
    }
    Ok(())
}

/// What is stated of clusters.
fn clusters(certificate: &Certificate, set: &Set) -> Result<(), Rejected> {
    same("number of clusters", &set.clusters.len(), &certificate.clusters.len())?;
    for (c, (cluster, proof)) in set.clusters.iter().zip(&certificate.clusters).enumerate() {
        let place = |what: &str| format!("{what} of cluster {}", cluster.name);
        same(&place("pool"), &cluster.pool, &proof.pool)?;
        same(&place("name"), &cluster.name, &proof.name)?;
        same(&place("lanes"), &cluster.lanes, &proof.lanes)?;
        let is_in = |t: &usize| {
            set.tasks[*t].versions.iter().flat_map(|graph| &graph.nodes).any(|node| node.cluster == c)
        };
        let in_it: Vec<usize> = (0..set.tasks.len()).filter(is_in).collect();
        let names: Vec<&String> = in_it.iter().map(|t| &set.tasks[*t].name).collect();
        same(&place("tasks"), &names, &proof.tasks.iter().collect())?;
        // Jobs are given up, and go before others, for some that would be late and are tied to them: for none that is proved.
        let tied = set.tied_to(c);
        let is_proved =
            certificate.tasks.iter().zip(tied).all(|(task, tied)| !tied || task.response_ns.is_some());
        if is_proved != (proof.guarantee == Guarantee::Analytic) {
            let expected = if is_proved { "analytic" } else { "best-effort" };
            let stated = if is_proved { "best-effort" } else { "analytic" }.to_owned();
            return Err(differs(&place("guarantee"), expected.to_owned(), stated));
        }
    }
    Ok(())
}

/// Lengths of the chains of each graph in each cluster.
fn chains(
    certificate: &Certificate,
    set: &Set,
    shapes: &[Vec<Shape>],
) -> Result<Vec<Vec<Vec<Vec<i128>>>>, Rejected> {
    let of = |shape: &Shape, version: &VersionProof, place: &str| -> Result<Vec<Vec<i128>>, Rejected> {
        let of = |cluster| {
            shape.chains(&version.chain_of, cluster).map_err(|node| {
                let stated = format!("{} for node {node}", version.chain_of[node]);
                differs(place, "chains that are ordered by reachability".to_owned(), stated)
            })
        };
        (0..set.clusters.len()).map(of).collect()
    };
    let mut chains = Vec::new();
    for (proof, shapes) in certificate.tasks.iter().zip(shapes) {
        let place = format!("chain_of of task {}", proof.name);
        let versions = shapes.iter().zip(&proof.versions);
        chains.push(versions.map(|(shape, version)| of(shape, version, &place)).collect::<Result<_, _>>()?);
    }
    Ok(chains)
}

/// Whether nothing is stated to be proved of a task that waits for more than lanes, itself or by who shares a result with it.
fn partners(certificate: &Certificate, set: &Set) -> Result<(), Rejected> {
    for (task, proof) in
        set.tasks.iter().zip(&certificate.tasks).filter(|(_, proof)| proof.response_ns.is_some())
    {
        let shares = |other: &Task| other.frames.iter().any(|frame| task.frames.contains(frame));
        let open = set
            .tasks
            .iter()
            .zip(&certificate.tasks)
            .find(|(other, proof)| proof.response_ns.is_none() && shares(other));
        if task.waits || open.is_some() {
            let place = format!("response_ns of task {}", task.name);
            return Err(differs(&place, words(&None::<u64>), words(&proof.response_ns)));
        }
    }
    Ok(())
}

/// How long after its release a job of each task does anything; and whether all such jobs have room.
fn bounds(certificate: &Certificate, set: &Set, shapes: &[Vec<Shape>]) -> Result<Vec<i128>, Rejected> {
    if !set.is_in_range() {
        return Err(Rejected::Set { place: "numbers".to_owned(), wrong: "times above 73 minutes" });
    }
    let bound = |(proof, shapes): (&TaskProof, &Vec<Shape>)| {
        let nodes = shapes.iter().flat_map(|shape| &shape.nodes);
        let largest = nodes.map(|node| node.cost).max().unwrap_or(0);
        proof.response_ns.map_or(i128::from(proof.deadline_ns) + largest + 1, i128::from)
    };
    let bounds: Vec<i128> = certificate.tasks.iter().zip(shapes).map(bound).collect();
    let jobs = |(bound, period): (&i128, Option<u64>)| 1 + period.map_or(0, |t| bound / i128::from(t));
    let periods = set.tasks.iter().map(|task| task.period_ns);
    let jobs: i128 = bounds.iter().zip(periods).map(jobs).sum();
    if jobs > i128::from(set.most_jobs) {
        let expected = format!("{} at most", set.most_jobs);
        return Err(differs("jobs at once by the response times", expected, jobs.to_string()));
    }
    Ok(bounds)
}

/// Each task in each cluster.
fn loads(
    set: &Set,
    shapes: &[Vec<Shape>],
    chains: &[Vec<Vec<Vec<i128>>>],
    bounds: &[i128],
) -> Vec<Vec<Load>> {
    let of = |t: usize, cluster: usize| {
        let versions = shapes[t].iter().zip(&chains[t]);
        let versions: Vec<_> = versions.map(|(shape, chains)| (shape, chains[cluster].as_slice())).collect();
        let lanes = set.clusters[cluster].lanes;
        Load::of(&versions, (cluster, lanes), set.tasks[t].period_ns, bounds[t])
    };
    let of = |t: usize| (0..set.clusters.len()).map(|cluster| of(t, cluster)).collect();
    (0..set.tasks.len()).map(of).collect()
}

/// Every proof by its inequalities.
fn proofs(certificate: &Certificate, world: &World<'_>) -> Result<(), Rejected> {
    for (task, of) in certificate.tasks.iter().enumerate() {
        for (version, stated) in of.versions.iter().enumerate() {
            if let (Some(response), Some(proof)) = (stated.response_ns, &stated.proof) {
                let place = format!("task {}, version {version}", of.name);
                let response = i128::from(response);
                world.proves(&Claim { place, task, version, response, proof })?;
            }
        }
    }
    Ok(())
}

fn same<T: PartialEq + Serialize + ?Sized>(place: &str, expected: &T, stated: &T) -> Result<(), Rejected> {
    if expected == stated {
        return Ok(());
    }
    Err(differs(place, words(expected), words(stated)))
}

/// A value as it stands in a certificate.
fn words<T: Serialize + ?Sized>(value: &T) -> String {
    // Plain data has a JSON form.
    serde_json::to_string(value).unwrap_or_default()
}

fn differs(place: &str, expected: String, stated: String) -> Rejected {
    Rejected::Statement { place: place.to_owned(), expected, stated }
}

#[cfg(test)]
mod tests;
