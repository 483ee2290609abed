//! A division of the pools that proves more than the file's.

use super::{Plan, set};
use crate::build::BuildError;
use crate::model::Workload;
use red_certificate::Set;
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

/// The division that proves most of those that are looked at; `None` where the file's own is as good. Time bound: some
/// thousand proofs.
///
/// # Errors
/// As [`plan`](super::plan).
pub fn division<C: Capacity>(workload: &Workload, plan: &Plan) -> Result<Option<Division>, BuildError> {
    let found = red_analysis::divide(&set::<C>(workload)?, &plan.certificate);
    Ok(found.map(|(divided, certificate)| Division {
        proved: certificate.tasks.iter().filter(|task| task.response_ns.is_some()).count(),
        clusters: clusters(&divided),
    }))
}

fn clusters(set: &Set) -> Vec<Divided> {
    let of = |(at, cluster): (usize, &red_certificate::Cluster)| {
        let is_in = |task: &&red_certificate::Task| {
            task.versions.iter().flat_map(|graph| &graph.nodes).any(|node| node.cluster == at)
        };
        let tasks = set.tasks.iter().filter(is_in).map(|task| task.name.clone()).collect();
        let red_certificate::Cluster { pool, name, lanes } = cluster.clone();
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
