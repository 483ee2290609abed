//! A division of pools into clusters that proves more than what there is.
//!
//! *Background.* In a cluster nobody else's jobs carry in, and on one lane nothing carries in at all, so clusters are proved far
//! more often than the pool as a whole; what idle lanes of others could have done is lost.
//! *Rule.* Of a pool whose tasks are nowhere else: tasks by density W / D, the densest first. Spread: each into the cluster with the
//! least load, a new one of one lane before all others, that is still proved with it; else a new one of the fewest lanes that
//! prove it; else the one that then needs the fewest lanes more. Where that proves not all, packed: the same, but the first
//! cluster that is proved with it, and a new one after all others. Lanes that are left go where the proof stays, one by one,
//! and else stay idle in a cluster of their own: more lanes let in more nodes of lower rank.
//! *Why it holds.* Whatever it gives is proved again as a whole.
//! *Paper reference.* Federated and partitioned scheduling in one form: Li et al. 2014, Baruah 2015.

use crate::prove::prove;
use red_certificate::{Certificate, Cluster, Graph, Set, Task};
use std::cmp::Reverse;

/// The set under another division that proves more tasks, with its certificate; `None` where none was found that `accepts`
/// takes. Time bound: as many proofs of parts of the set as it has tasks times lanes.
#[must_use]
pub fn divide(
    set: &Set,
    proved: &Certificate,
    mut accepts: impl FnMut(&Set, &Certificate) -> bool,
) -> Option<(Set, Certificate)> {
    if proved.is_analytic() {
        return None;
    }
    let mut pools: Vec<&str> = Vec::new();
    for cluster in &set.clusters {
        if !pools.contains(&cluster.pool.as_str()) {
            pools.push(&cluster.pool);
        }
    }
    let mut best: Option<(Set, Certificate)> = None;
    for pool in pools {
        let (set, proved) = best.as_ref().map_or((set, proved), |(set, proved)| (set, proved));
        let mut is_better = |(divided, certificate): &(Set, Certificate)| {
            count(certificate) > count(proved) && accepts(divided, certificate)
        };
        let better = divide_pool(set, pool, &mut is_better);
        best = better.or(best);
    }
    best
}

fn count(certificate: &Certificate) -> usize {
    certificate.tasks.iter().filter(|task| task.response_ns.is_some()).count()
}

/// A new cluster.
#[derive(Clone, Debug, Default)]
struct New {
    lanes: u32,
    tasks: Vec<usize>,
}

/// Which clusters are tried first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Order {
    /// Those with the least load for each lane.
    Spread,
    /// Those that were there first.
    Packed,
}

/// A pool that is being divided.
struct Pool<'a> {
    set: &'a Set,
    name: &'a str,
    lanes: u32,
    /// The densest first.
    tasks: Vec<usize>,
}

/// Of both orders the one that proves more, if it is taken, else the other.
fn divide_pool(
    set: &Set,
    name: &str,
    takes: &mut impl FnMut(&(Set, Certificate)) -> bool,
) -> Option<(Set, Certificate)> {
    let is_here = |cluster: usize| set.clusters[cluster].pool == name;
    let lanes = set.clusters.iter().filter(|cluster| cluster.pool == name).map(|cluster| cluster.lanes).sum();
    let clusters_of = |task: &Task| -> Vec<usize> {
        task.versions.iter().flat_map(|graph| &graph.nodes).map(|node| node.cluster).collect()
    };
    let mut tasks: Vec<usize> =
        (0..set.tasks.len()).filter(|i| clusters_of(&set.tasks[*i]).into_iter().any(is_here)).collect();
    let only_here = |i: &usize| clusters_of(&set.tasks[*i]).into_iter().all(is_here);
    if lanes < 2 || tasks.len() < 2 || !tasks.iter().all(only_here) {
        return None;
    }
    tasks.sort_by_key(|i| Reverse(millionths(&set.tasks[*i], set.tasks[*i].deadline_ns)));
    let pool = Pool { set, name, lanes, tasks };
    let of = |order| {
        let divided = with_clusters(set, name, &pool.divided(order));
        let certificate = prove(&divided);
        (divided, certificate)
    };
    let spread = of(Order::Spread);
    if count(&spread.1) == set.tasks.len() && takes(&spread) {
        return Some(spread);
    }
    let packed = of(Order::Packed);
    let is_first = count(&packed.1) > count(&spread.1);
    let both = if is_first { [packed, spread] } else { [spread, packed] };
    both.into_iter().find(takes)
}

/// Work over so much time, in millionths: as exact as an order needs.
fn millionths(task: &Task, time_ns: u64) -> u128 {
    let work = |graph: &Graph| graph.nodes.iter().map(|node| u128::from(node.cost_ns)).sum::<u128>();
    task.versions.iter().map(work).max().unwrap_or(0) * 1_000_000 / u128::from(time_ns.max(1))
}

impl Pool<'_> {
    fn divided(&self, order: Order) -> Vec<New> {
        let (mut clusters, mut free, mut left): (Vec<New>, u32, Vec<usize>) =
            (Vec::new(), self.lanes, Vec::new());
        for task in &self.tasks {
            match self.place(order, &clusters, free, *task) {
                Some((at, more)) => {
                    free -= more;
                    if at == clusters.len() {
                        clusters.push(New::default());
                    }
                    clusters[at].lanes += more;
                    clusters[at].tasks.push(*task);
                }
                None => left.push(*task),
            }
        }
        if left.is_empty() {
            self.widen(&mut clusters, &mut free);
        }
        // What cannot be proved anywhere has lanes of its own, as far as there are some.
        match clusters.last_mut() {
            Some(last) if free == 0 => last.tasks.extend(left),
            _ => clusters.push(New { lanes: free, tasks: left }),
        }
        clusters
    }

    /// Where a task goes, and how many lanes more that takes.
    fn place(&self, order: Order, clusters: &[New], free: u32, task: usize) -> Option<(usize, u32)> {
        let new = clusters.len();
        let mut as_it_is: Vec<(usize, u32)> = (0..new).map(|at| (at, 0)).collect();
        if order == Order::Spread {
            as_it_is.sort_by_key(|(at, _)| self.load(&clusters[*at]) / u128::from(clusters[*at].lanes));
            as_it_is.splice(0..0, (free > 0).then_some((new, 1)));
        }
        let wider = (1..=free).flat_map(|more| [new].into_iter().chain(0..new).map(move |at| (at, more)));
        as_it_is.into_iter().chain(wider).find(|(at, more)| {
            let mut cluster = clusters.get(*at).cloned().unwrap_or_default();
            cluster.lanes += more;
            cluster.tasks.push(task);
            self.is_proved(&cluster)
        })
    }

    /// Gives lanes to clusters that are proved with them.
    fn widen(&self, clusters: &mut [New], free: &mut u32) {
        for cluster in clusters {
            while *free > 0 {
                let wider = New { lanes: cluster.lanes + 1, ..cluster.clone() };
                if !self.is_proved(&wider) {
                    break;
                }
                *cluster = wider;
                *free -= 1;
            }
        }
    }

    /// Millionths of a lane that its tasks take.
    fn load(&self, cluster: &New) -> u128 {
        let tasks = cluster.tasks.iter().map(|i| &self.set.tasks[*i]);
        tasks.map(|task| task.period_ns.map_or(0, |period| millionths(task, period))).sum()
    }

    fn is_proved(&self, cluster: &New) -> bool {
        // More than all lanes all the time: seen without a search.
        self.load(cluster) <= 1_000_000 * u128::from(cluster.lanes)
            && prove(&alone(self.set, self.name, cluster.lanes, &cluster.tasks)).is_analytic()
    }
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
    let cluster = |(nth, New { lanes, .. }): (usize, &New)| Cluster {
        pool: pool.to_owned(),
        name: format!("c{}", nth + 1),
        lanes: *lanes,
    };
    let mut divided = set.clone();
    divided.clusters.splice(first..first + before, new.iter().enumerate().map(cluster));
    for (i, task) in divided.tasks.iter_mut().enumerate() {
        match new.iter().position(|New { tasks, .. }| tasks.contains(&i)) {
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
