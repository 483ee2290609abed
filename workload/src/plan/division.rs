//! A division of the pools that proves more than the file's.

use super::cure::each_part;
use super::{Plan, set};
use crate::build::BuildError;
use crate::model::{Pool, Workload};
use red_certificate::{Certificate, Cluster, Set, TaskProof};
use red_core::Capacity;
use serde::Serialize;
use std::fmt;

/// Clusters that prove more tasks than the pools as they are.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Division {
    /// Tasks that are proved then.
    pub proved: usize,
    /// The clusters, those of the divided pools only.
    pub clusters: Vec<Divided>,
}

/// A cluster, and who is in it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Divided {
    /// Pool.
    pub pool: String,
    /// Name.
    pub name: String,
    /// Lanes.
    pub lanes: u32,
    /// Tasks.
    pub tasks: Vec<String>,
}

/// The division that proves most of those that are looked at, under which nothing is proved worse of any task, and whose
/// workload `accepts` takes; `None` where the file's own is as good. Time bound: some thousand proofs.
///
/// # Errors
/// As [`plan`](super::plan).
pub fn division<C: Capacity>(
    workload: &Workload,
    plan: &Plan,
    mut accepts: impl FnMut(&Workload) -> bool,
) -> Result<Option<Division>, BuildError> {
    let takes = |divided: &Set, certificate: &Certificate| {
        is_no_worse(&plan.certificate, certificate)
            && applied(workload, divided).is_some_and(|divided| accepts(&divided))
    };
    let found = red_analysis::divide(&set::<C>(workload)?, &plan.certificate, takes);
    Ok(found.map(|(divided, certificate)| Division {
        proved: certificate.tasks.iter().filter(|task| task.response_ns.is_some()).count(),
        clusters: clusters(&divided),
    }))
}

/// Whether no bound is longer or gone.
fn is_no_worse(before: &Certificate, after: &Certificate) -> bool {
    let no_worse = |(before, after): (&TaskProof, &TaskProof)| match (before.response_ns, after.response_ns) {
        (None, _) => true,
        (Some(before), Some(after)) => after <= before,
        (Some(_), None) => false,
    };
    before.tasks.iter().zip(&after.tasks).all(no_worse)
}

/// The workload as the file would say it; `None` where it may not say so.
fn applied(workload: &Workload, divided: &Set) -> Option<Workload> {
    let mut new = workload.clone();
    let pool = |cluster: &Cluster| {
        let old = workload.pools.iter().find(|pool| pool.undivided() == cluster.pool)?;
        let is_divided = cluster.pool != cluster.name;
        let name = if is_divided { format!("{}.{}", cluster.pool, cluster.name) } else { old.name.clone() };
        // A budget cannot be divided in a file.
        let is_legal = !is_divided || old.memory_bytes.is_none();
        is_legal.then(|| Pool { name, lanes: cluster.lanes, ..old.clone() })
    };
    new.pools = divided.clusters.iter().map(pool).collect::<Option<_>>()?;
    let place = |task: usize, pool: usize| {
        let old = workload.pools[pool].undivided();
        let of_task = divided.tasks[task].versions.iter().flat_map(|graph| &graph.nodes);
        of_task.map(|node| node.cluster).find(|cluster| divided.clusters[*cluster].pool == old)
    };
    let mut is_whole = true;
    each_part(&mut new, |task, _, part| match place(task, part.pool) {
        Some(pool) => part.pool = pool,
        None => is_whole = false,
    });
    is_whole.then_some(new)
}

fn clusters(set: &Set) -> Vec<Divided> {
    let of = |(at, cluster): (usize, &Cluster)| {
        let is_in = |task: &&red_certificate::Task| {
            task.versions.iter().flat_map(|graph| &graph.nodes).any(|node| node.cluster == at)
        };
        let tasks = set.tasks.iter().filter(is_in).map(|task| task.name.clone()).collect();
        let Cluster { pool, name, lanes } = cluster.clone();
        (pool != name).then_some(Divided { pool, name, lanes, tasks })
    };
    set.clusters.iter().enumerate().filter_map(of).collect()
}

impl fmt::Display for Division {
    /// As lines of a workload file.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut pools: Vec<&str> = self.clusters.iter().map(|cluster| &*cluster.pool).collect();
        pools.dedup();
        for pool in pools {
            let here = self.clusters.iter().filter(|cluster| cluster.pool == pool);
            let list: Vec<String> =
                here.map(|c| format!("{{ name = \"{}\", lanes = {} }}", c.name, c.lanes)).collect();
            writeln!(f, "  to pool `{pool}`:\n    clusters = [{}]", list.join(", "))?;
        }
        for Divided { name, tasks, .. } in self.clusters.iter().filter(|cluster| !cluster.tasks.is_empty()) {
            writeln!(f, "  to {}:\n    cluster = \"{name}\"", tasks.join(", "))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
