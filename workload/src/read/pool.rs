//! Pools: `[[pool]]`.

use super::UniqueNames;
use crate::error::{Fault, Refusal};
use crate::model::{MAX_LANES, Pool, PoolKind};
use crate::tree::{Field, Fields};

/// CPUs that a Linux kernel can be built for.
const MAX_CPUS: u32 = 4096;

/// All pools of a file.
pub(super) fn all(workload: &Fields<'_>) -> Result<Vec<Pool>, Fault> {
    let list = workload.need("pool")?;
    let mut names = UniqueNames::of("pool");
    let mut free_lanes = MAX_LANES;
    let pools: Vec<Pool> =
        list.list()?.map(|item| pool(item, &mut names, &mut free_lanes)).collect::<Result<_, _>>()?;
    if pools.is_empty() {
        return Err(list.fault(Refusal::Missing, "at least one pool"));
    }
    Ok(pools)
}

fn pool<'t>(item: Field<'t>, names: &mut UniqueNames<'t>, free_lanes: &mut u32) -> Result<Pool, Fault> {
    let fields = Fields::open(item.tree, "a pool", &["name", "kind", "lanes", "memory", "cpus"])?;
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
