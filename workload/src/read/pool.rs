//! Pools: `[[pool]]`, and the clusters that they are divided into.
//!
//! Behind the reader a cluster is a pool of its own, called `pool.cluster`: nothing there has to know of clusters.

use super::UniqueNames;
use crate::error::{Fault, Refusal};
use crate::model::{MAX_LANES, Pool, PoolKind};
use crate::tree::{Field, Fields};

/// CPUs that a Linux kernel can be built for.
const MAX_CPUS: u32 = 4096;

/// The pools of a file, by the names that it has for them.
#[derive(Debug)]
pub(super) struct Pools {
    /// Undivided pools and clusters, in the order of the file.
    pub(super) resolved: Vec<Pool>,
    named: Vec<Named>,
}

/// A pool by its name.
#[derive(Debug)]
struct Named {
    name: String,
    /// Which of the resolved it is, or its first cluster.
    first: usize,
    /// Its clusters; none where it is not divided.
    clusters: Vec<String>,
}

/// The pools as the nodes of one task see them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    pools: &'a Pools,
    cluster: Option<&'a str>,
}

impl Pools {
    /// All pools of a file.
    pub(super) fn read(workload: &Fields<'_>) -> Result<Self, Fault> {
        let list = workload.need("pool")?;
        let mut names = UniqueNames::of("pool");
        let mut free_lanes = MAX_LANES;
        let mut pools = Self { resolved: Vec::new(), named: Vec::new() };
        for item in list.list()? {
            pools.add(item, &mut names, &mut free_lanes)?;
        }
        if pools.named.is_empty() {
            return Err(list.fault(Refusal::Missing, "at least one pool"));
        }
        Ok(pools)
    }

    fn add<'t>(
        &mut self,
        item: Field<'t>,
        names: &mut UniqueNames<'t>,
        free_lanes: &mut u32,
    ) -> Result<(), Fault> {
        let fields =
            Fields::open(item.tree, "a pool", &["name", "kind", "lanes", "memory", "cpus", "clusters"])?;
        let pool = pool(&fields, names, free_lanes)?;
        let first = self.resolved.len();
        let clusters = fields.get("clusters").map(|field| clusters(field, &fields, &pool)).transpose()?;
        let clusters = clusters.unwrap_or_default();
        let names = clusters.iter().map(|(name, _)| name.clone()).collect();
        self.named.push(Named { name: pool.name.clone(), first, clusters: names });
        if clusters.is_empty() {
            self.resolved.push(pool);
            return Ok(());
        }
        let mut cpus = pool.cpus.iter().copied();
        for (name, lanes) in clusters {
            let cpus = cpus.by_ref().take(lanes as usize).collect();
            self.resolved.push(Pool { name: format!("{}.{name}", pool.name), lanes, cpus, ..pool.clone() });
        }
        Ok(())
    }

    /// The cluster that a task names, if it does.
    pub(super) fn cluster(&self, cluster: Option<Field<'_>>) -> Result<Option<String>, Fault> {
        let Some(field) = cluster else { return Ok(None) };
        let name = field.name()?;
        let known = || self.named.iter().flat_map(|pool| &pool.clusters).map(String::as_str);
        if known().any(|cluster| cluster == name) {
            return Ok(Some(name.to_owned()));
        }
        if known().next().is_none() {
            return Err(field.fault(Refusal::Reference, "no `cluster`, or a pool with `clusters`"));
        }
        Err(field.fault(Refusal::Reference, "the name of a cluster of a pool").with_nearest(name, known()))
    }

    pub(super) fn seen_by<'a>(&'a self, cluster: Option<&'a str>) -> Seen<'a> {
        Seen { pools: self, cluster }
    }
}

impl<'a> Seen<'a> {
    /// The first pool, which nodes are in that name none.
    pub(super) fn default(self) -> usize {
        self.pools.named.first().map_or(0, |pool| self.place(pool))
    }

    /// The pool of this name.
    pub(super) fn find(self, field: Field<'_>) -> Result<usize, Fault> {
        let name = field.text()?;
        let found = self.pools.named.iter().find(|pool| pool.name == name);
        found.map(|pool| self.place(pool)).ok_or_else(|| {
            let fault = field.fault(Refusal::Reference, "the name of a pool");
            fault.with_nearest(name, self.pools.named.iter().map(|pool| pool.name.as_str()))
        })
    }

    pub(super) fn pool(self, index: usize) -> &'a Pool {
        &self.pools.resolved[index]
    }

    /// The task's cluster of a pool: that of its name, else the first.
    fn place(self, pool: &Named) -> usize {
        let own = pool.clusters.iter().position(|cluster| Some(&**cluster) == self.cluster);
        pool.first + own.unwrap_or(0)
    }
}

fn pool<'t>(fields: &Fields<'t>, names: &mut UniqueNames<'t>, free_lanes: &mut u32) -> Result<Pool, Fault> {
    let name = names.add(fields.need("name")?)?;
    let kind = fields.get("kind").map(kind).transpose()?.unwrap_or(PoolKind::Cpu);
    let lanes_field = fields.need("lanes")?;
    let lanes = lanes_field.count(1..=MAX_LANES)?;
    let too_many = || lanes_field.fault(Refusal::Limit, format!("at most {MAX_LANES} lanes over all pools"));
    *free_lanes = free_lanes.checked_sub(lanes).ok_or_else(too_many)?;
    let memory_bytes = fields.get("memory").map(|field| field.memory()).transpose()?;
    let cpus = fields.get("cpus").map(cpus).transpose()?.unwrap_or_default();
    Ok(Pool { name, kind, lanes, memory_bytes, cpus })
}

fn kind(field: Field<'_>) -> Result<PoolKind, Fault> {
    match field.text()? {
        "cpu" => Ok(PoolKind::Cpu),
        "cuda" => Ok(PoolKind::Cuda),
        other => {
            let fault = field.fault(Refusal::Range, "`cpu` or `cuda`");
            Err(fault.with_nearest(other, ["cpu", "cuda"]))
        }
    }
}

fn cpus(field: Field<'_>) -> Result<Vec<u32>, Fault> {
    let mut cpus = Vec::new();
    for item in field.list()? {
        let cpu = item.count(0..=MAX_CPUS - 1)?;
        if cpus.contains(&cpu) {
            return Err(item.fault(Refusal::Duplicate, "each CPU once"));
        }
        cpus.push(cpu);
    }
    Ok(cpus)
}

/// Clusters with their lanes, which are those of the pool.
fn clusters(field: Field<'_>, fields: &Fields<'_>, pool: &Pool) -> Result<Vec<(String, u32)>, Fault> {
    // Which cluster has how much of a budget nobody has said, and proofs want no node to wait for memory.
    fields.refuse("memory", "no `memory` beside `clusters`")?;
    let mut names = UniqueNames::of("cluster");
    let mut clusters = Vec::new();
    let mut lanes: u32 = 0;
    for item in field.list()? {
        let fields = Fields::open(item.tree, "a cluster", &["name", "lanes"])?;
        let name = names.add(fields.need("name")?)?;
        let own = fields.need("lanes")?;
        let count = own.count(1..=MAX_LANES)?;
        lanes += count;
        if lanes > pool.lanes {
            return Err(
                own.fault(Refusal::Range, format!("clusters with the {} lanes of their pool", pool.lanes))
            );
        }
        clusters.push((name, count));
    }
    if lanes < pool.lanes {
        let problem = format!("the clusters have {lanes} lanes together");
        let expected = format!("clusters with the {} lanes of their pool", pool.lanes);
        return Err(Fault::new(field.at(), Refusal::Range, problem, expected));
    }
    Ok(clusters)
}

#[cfg(test)]
mod tests;
