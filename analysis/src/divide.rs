//! A division of pools into clusters that proves more than what there is.
//!
//! *Background.* In a cluster nobody else's jobs carry in, and on one lane nothing carries in at all, so clusters are proved far
//! more often than the pool as a whole; what idle lanes of others could have done is lost.
//! *Rule.* Of a pool whose tasks are nowhere else: tasks by density W / D, the densest first, each into the first cluster that
//! is still proved with it; else into a new one of the fewest lanes that prove it; else into the one that then needs the fewest
//! lanes more. Lanes that are left go to the first. *Why it holds.* Whatever it gives is proved again as a whole.
//! *Paper reference.* Federated and partitioned scheduling in one form: Li et al. 2014, Baruah 2015.

use crate::prove::prove;
use red_certificate::{Certificate, Cluster, Set, Task};
use std::cmp::Reverse;

/// The set under another division that proves more tasks, with its certificate; `None` where none was found. Time bound: as
/// many proofs of parts of the set as it has tasks times lanes.
#[must_use]
pub fn divide(set: &Set, proved: &Certificate) -> Option<(Set, Certificate)> {
    if proved.is_analytic() {
        return None;
    }
    let mut pools: Vec<&str> = Vec::new();
    for cluster in &set.clusters {
        if !pools.contains(&cluster.pool.as_str()) {
            pools.push(&cluster.pool);
        }
    }
    let divided =
        pools.iter().fold(set.clone(), |divided, pool| divide_pool(&divided, pool).unwrap_or(divided));
    let certificate = prove(&divided);
    let count = |of: &Certificate| of.tasks.iter().filter(|task| task.response_ns.is_some()).count();
    (count(&certificate) > count(proved)).then_some((divided, certificate))
}

/// A new cluster: its lanes and tasks.
type New = (u32, Vec<usize>);

fn divide_pool(set: &Set, pool: &str) -> Option<Set> {
    let is_here = |cluster: usize| set.clusters[cluster].pool == pool;
    let lanes: u32 =
        set.clusters.iter().filter(|cluster| cluster.pool == pool).map(|cluster| cluster.lanes).sum();
    let clusters_of = |task: &Task| -> Vec<usize> {
        task.versions.iter().flat_map(|graph| &graph.nodes).map(|node| node.cluster).collect()
    };
    let mut tasks: Vec<usize> =
        (0..set.tasks.len()).filter(|i| clusters_of(&set.tasks[*i]).into_iter().any(is_here)).collect();
    let only_here = |i: &usize| clusters_of(&set.tasks[*i]).into_iter().all(is_here);
    if lanes < 2 || tasks.len() < 2 || !tasks.iter().all(only_here) {
        return None;
    }
    // W / D in millionths: as exact as an order needs.
    let density = |i: &usize| {
        let task = &set.tasks[*i];
        let work =
            |graph: &red_certificate::Graph| graph.nodes.iter().map(|node| u128::from(node.cost_ns)).sum();
        let work: u128 = task.versions.iter().map(work).max().unwrap_or(0);
        work * 1_000_000 / u128::from(task.deadline_ns.max(1))
    };
    tasks.sort_by_key(|i| Reverse(density(i)));
    let (mut clusters, mut free, mut left): (Vec<New>, u32, Vec<usize>) = (Vec::new(), lanes, Vec::new());
    for task in tasks {
        match place(set, pool, &clusters, free, task) {
            Some((at, more)) => {
                free -= more;
                if at == clusters.len() {
                    clusters.push((0, Vec::new()));
                }
                clusters[at].0 += more;
                clusters[at].1.push(task);
            }
            None => left.push(task),
        }
    }
    match (clusters.first_mut(), left.is_empty()) {
        (Some(first), true) => first.0 += free,
        // What cannot be proved anywhere has lanes of its own, as far as there are some.
        (_, false) if free > 0 => clusters.push((free, left)),
        (_, false) => clusters.last_mut()?.1.extend(left),
        (None, true) => return None,
    }
    Some(with_clusters(set, pool, &clusters))
}

/// Where a task goes, and how many lanes more that takes.
fn place(set: &Set, pool: &str, clusters: &[New], free: u32, task: usize) -> Option<(usize, u32)> {
    let is_proved = |(lanes, tasks): &New, more: u32| {
        let tasks: Vec<usize> = tasks.iter().copied().chain([task]).collect();
        prove(&alone(set, pool, lanes + more, &tasks)).is_analytic()
    };
    let as_it_is = clusters.iter().position(|cluster| is_proved(cluster, 0));
    if let Some(at) = as_it_is {
        return Some((at, 0));
    }
    let mut wider = (1..=free).flat_map(|more| {
        let new = [(clusters.len(), (0, Vec::new()))];
        let there = clusters.iter().cloned().enumerate();
        new.into_iter().chain(there).map(move |(at, cluster): (usize, New)| (at, cluster, more))
    });
    wider.find(|(_, cluster, more)| is_proved(cluster, *more)).map(|(at, _, more)| (at, more))
}

/// These tasks alone, in one cluster.
fn alone(set: &Set, pool: &str, lanes: u32, tasks: &[usize]) -> Set {
    let moved = |i: &usize| moved(&set.tasks[*i], 0);
    let cluster = Cluster { pool: pool.to_owned(), name: pool.to_owned(), lanes };
    Set { most_jobs: set.most_jobs, clusters: vec![cluster], tasks: tasks.iter().map(moved).collect() }
}

/// The set with these clusters in place of the pool's.
fn with_clusters(set: &Set, pool: &str, new: &[New]) -> Set {
    let first = set.clusters.iter().position(|cluster| cluster.pool == pool).unwrap_or(0);
    let before = set.clusters.iter().filter(|cluster| cluster.pool == pool).count();
    let cluster = |(nth, (lanes, _)): (usize, &New)| Cluster {
        pool: pool.to_owned(),
        name: format!("c{}", nth + 1),
        lanes: *lanes,
    };
    let mut divided = set.clone();
    divided.clusters.splice(first..first + before, new.iter().enumerate().map(cluster));
    for (i, task) in divided.tasks.iter_mut().enumerate() {
        match new.iter().position(|(_, tasks)| tasks.contains(&i)) {
            Some(at) => *task = moved(task, first + at),
            None => {
                let nodes = task.versions.iter_mut().flat_map(|graph| &mut graph.nodes);
                let later = nodes.filter(|node| node.cluster >= first + before);
                later.for_each(|node| node.cluster = node.cluster + new.len() - before);
            }
        }
    }
    divided
}

/// The task, all of it in one cluster.
fn moved(task: &Task, cluster: usize) -> Task {
    let mut task = task.clone();
    task.versions.iter_mut().flat_map(|graph| &mut graph.nodes).for_each(|node| node.cluster = cluster);
    task
}

#[cfg(test)]
mod tests;
