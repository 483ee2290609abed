//! From the tree to the model: the tables of a file in their order, each with its own checks.

mod body;
mod node;
mod placed;
mod pool;
mod task;

use std::collections::HashSet;

use crate::error::{Fault, Refusal, shown};
use crate::graph;
use crate::model::{Sensor, SyncGrid, Workload};
use crate::tree::{Field, Fields, Tree};

pub(crate) use placed::{PlacedEvent, PlacedNode, PlacedTask};

/// Longest time that is an instant or a distance of instants: 146 years. A difference of two fits `i64`, and a sum
/// of three fits `u64`.
const MAX_INSTANT_NS: u64 = 1 << 62;

/// Reads and checks a whole workload.
pub(crate) fn workload(root: &Tree<'_>) -> Result<Workload, Fault> {
    let fields = Fields::open(root, "a workload", &["pool", "sensor", "task", "event", "sync"])?;
    let pools = pool::all(&fields)?;
    let sensors = sensors(&fields)?;
    let mut tasks = task::all(&fields, &pools)?;
    let mut events = task::events(&fields, &pools, &mut tasks)?;
    let sync = fields.get("sync").map(sync).transpose()?;
    // Stable: events of one instant keep the order of the file.
    events.sort_by_key(|event| event.event.at_ns);
    for (index, task) in tasks.iter().enumerate() {
        graph::check(task, events.iter().filter(|event| event.event.task == index))?;
    }
    Ok(Workload {
        pools,
        sensors,
        tasks: tasks.into_iter().map(PlacedTask::into_model).collect(),
        events: events.into_iter().map(PlacedEvent::into_model).collect(),
        sync,
    })
}

fn sensors(fields: &Fields<'_>) -> Result<Vec<Sensor>, Fault> {
    let Some(list) = fields.get("sensor") else {
        return Ok(Vec::new());
    };
    let mut names = UniqueNames::of("sensor");
    list.list()?
        .map(|item| {
            let fields = Fields::open(item.tree, "a sensor", &["name", "period"])?;
            let name = names.add(fields.need("name")?)?;
            Ok(Sensor { name, period_ns: fields.need("period")?.time_in(1..=MAX_INSTANT_NS)? })
        })
        .collect()
}

fn sync(field: Field<'_>) -> Result<SyncGrid, Fault> {
    let fields = Fields::open(field.tree, "the barrier grid", &["grid", "cost"])?;
    Ok(SyncGrid {
        grid_ns: fields.need("grid")?.time_in(1..=MAX_INSTANT_NS)?,
        cost_ns: fields.need("cost")?.time_in(0..=MAX_INSTANT_NS)?,
    })
}

/// Names of which each may stand only once.
struct UniqueNames<'t> {
    kind: &'static str,
    taken: HashSet<&'t str>,
}

impl<'t> UniqueNames<'t> {
    fn of(kind: &'static str) -> Self {
        Self { kind, taken: HashSet::new() }
    }

    fn add(&mut self, field: Field<'t>) -> Result<String, Fault> {
        let name = field.name()?;
        if self.taken.insert(name) {
            return Ok(name.to_owned());
        }
        let problem = format!("a {} named `{}` is there already", self.kind, shown(name));
        Err(Fault::new(field.at(), Refusal::Duplicate, problem, "a name that is not taken"))
    }
}

#[cfg(test)]
mod tests;
