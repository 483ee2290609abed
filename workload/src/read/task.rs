//! Tasks and the events that change them: `[[task]]` and `[[event]]`.

use super::node::{self, Origin};
use super::pool::Pools;
use super::{PlacedEvent, PlacedNode, PlacedTask, UniqueNames};
use crate::error::{Fault, Refusal, shown};
use crate::model::{Arrival, Event, MAX_INSTANT_NS, Part, Task, Work};
use crate::tree::{Field, Fields};

/// Tasks of a file: the scheduler's capacity.
const MAX_TASKS: usize = 16;

/// Nodes that a task may have after refinement, those that events add included: the scheduler's capacity.
const MAX_NODES: usize = 256;

const TASK_KEYS: [&str; 10] =
    ["name", "deadline", "period", "min_interarrival", "once", "offset", "value", "floor", "cluster", "node"];

/// All tasks of a file.
pub(super) fn all(workload: &Fields<'_>, pools: &Pools) -> Result<Vec<PlacedTask>, Fault> {
    let list = workload.need("task")?;
    let items = list.list()?;
    if items.len() == 0 {
        return Err(list.fault(Refusal::Missing, "at least one task"));
    }
    let mut names = UniqueNames::of("task");
    let mut tasks = Vec::new();
    for item in items {
        if tasks.len() == MAX_TASKS {
            let problem = "there are too many tasks";
            return Err(Fault::new(item.at(), Refusal::Limit, problem, format!("at most {MAX_TASKS}")));
        }
        let elsewhere = memory_bytes(&tasks);
        tasks.push(task(item, pools, elsewhere, &mut names)?);
    }
    Ok(tasks)
}

fn task<'t>(
    item: Field<'t>,
    pools: &Pools,
    elsewhere: u64,
    names: &mut UniqueNames<'t>,
) -> Result<PlacedTask, Fault> {
    let fields = Fields::open(item.tree, "a task", &TASK_KEYS)?;
    let task = Task {
        name: names.add(fields.need("name")?)?,
        deadline_ns: fields.need("deadline")?.time_in(1..=MAX_INSTANT_NS)?,
        arrival: arrival(&fields)?,
        offset_ns: fields.get("offset").map_or(Ok(0), |field| field.time_in(0..=MAX_INSTANT_NS))?,
        value: fields.get("value").map_or(Ok(1), |field| field.count(0..=u32::MAX))?,
        floor: fields.get("floor").map(floor).transpose()?,
        nodes: Vec::new(),
    };
    let list = fields.need("node")?;
    let cluster = pools.cluster(fields.get("cluster"))?;
    let mut placed = PlacedTask { task, cluster, nodes: Vec::new(), load: Load::default() };
    for item in list.list()? {
        let node = node::read(item, Origin::Task, pools.seen_by(placed.cluster.as_deref()))?;
        placed.load.add(&node, elsewhere)?;
        placed.nodes.push(node);
    }
    if placed.nodes.is_empty() {
        return Err(list.fault(Refusal::Missing, "at least one node"));
    }
    Ok(placed)
}

fn arrival(fields: &Fields<'_>) -> Result<Arrival, Fault> {
    let field = fields.exactly_one(&["period", "min_interarrival", "once"])?;
    match field.key {
        "period" => Ok(Arrival::Periodic { period_ns: field.time_in(1..=MAX_INSTANT_NS)? }),
        "min_interarrival" => {
            Ok(Arrival::Sporadic { min_interarrival_ns: field.time_in(1..=MAX_INSTANT_NS)? })
        }
        _ if field.boolean()? => Ok(Arrival::Once),
        _ => Err(field.fault(Refusal::Range, "`true`, or `period` or `min_interarrival` instead")),
    }
}

fn floor(field: Field<'_>) -> Result<(u32, u32), Fault> {
    let items: Vec<Field<'_>> = field.list()?.take(3).collect();
    let [m, k] = items[..] else {
        return Err(field.fault(Refusal::Type, "two integers [m, k]: m of any k consecutive jobs"));
    };
    let k_jobs = k.count(1..=u32::MAX)?;
    Ok((m.count(0..=k_jobs)?, k_jobs))
}

/// All events of a file, in its order. What they add counts as load of their tasks.
pub(super) fn events(
    workload: &Fields<'_>,
    pools: &Pools,
    tasks: &mut [PlacedTask],
) -> Result<Vec<PlacedEvent>, Fault> {
    match workload.get("event") {
        None => Ok(Vec::new()),
        Some(list) => list.list()?.map(|item| event(item, pools, tasks)).collect(),
    }
}

fn event(item: Field<'_>, pools: &Pools, tasks: &mut [PlacedTask]) -> Result<PlacedEvent, Fault> {
    let fields = Fields::open(item.tree, "an event", &["at", "task", "add", "remove"])?;
    let at_ns = fields.need("at")?.time_in(0..=MAX_INSTANT_NS)?;
    let task_field = fields.need("task")?;
    let name = task_field.text()?;
    let Some(task) = tasks.iter().position(|placed| placed.task.name == name) else {
        let fault = task_field.fault(Refusal::Reference, "the name of a task");
        return Err(fault.with_nearest(name, tasks.iter().map(|placed| placed.task.name.as_str())));
    };
    let mut add = Vec::new();
    if let Some(list) = fields.get("add") {
        for item in list.list()? {
            let node = node::read(item, Origin::Event, pools.seen_by(tasks[task].cluster.as_deref()))?;
            let elsewhere = memory_bytes(tasks) - tasks[task].load.memory_bytes;
            tasks[task].load.add(&node, elsewhere)?;
            add.push(node);
        }
    }
    let (remove, remove_at) = node::references(fields.get("remove"))?;
    if add.is_empty() && remove.is_empty() {
        let problem = format!("an event of task `{}` changes nothing", shown(name));
        return Err(Fault::new(fields.at, Refusal::Missing, problem, "nodes in `add` or names in `remove`"));
    }
    Ok(PlacedEvent { event: Event { at_ns, task, add: Vec::new(), remove }, add, remove_at })
}

/// What all nodes of a task add up to, over all its versions.
#[derive(Debug, Default)]
pub(super) struct Load {
    nodes: usize,
    cost_ns: u64,
    memory_bytes: u64,
    /// A bit for each pool that it uses.
    pools: u32,
}

/// Memory of all nodes of these tasks, which is known to fit.
fn memory_bytes(tasks: &[PlacedTask]) -> u64 {
    tasks.iter().map(|placed| placed.load.memory_bytes).sum()
}

impl Load {
    /// Adds a node's parts, where all other tasks take `elsewhere` bytes.
    fn add(&mut self, placed: &PlacedNode, elsewhere: u64) -> Result<(), Fault> {
        let at = placed.at;
        let overflow = |what, bits| {
            let problem = format!("up to here, the sum of the {what} overflows {bits} bits");
            Fault::new(at, Refusal::Overflow, problem, "a smaller sum, events included")
        };
        let mut add_part = |part: &Part| {
            self.nodes += 1;
            self.pools |= 1 << part.pool;
            // The bound on the response time in several pools counts the longest path twice.
            let bits = if self.pools.is_power_of_two() { 64 } else { 63 };
            let cost = part.wcet_ns.checked_add(part.contention_ns);
            self.cost_ns = cost
                .and_then(|cost| self.cost_ns.checked_add(cost))
                .filter(|sum| *sum <= u64::MAX >> (64 - bits))
                .ok_or_else(|| overflow("times (`wcet` and `contention`) of this task's nodes", bits))?;
            self.memory_bytes = self
                .memory_bytes
                .checked_add(part.memory_bytes)
                .filter(|sum| sum.checked_add(elsewhere).is_some())
                .ok_or_else(|| overflow("footprints (`memory`) of all tasks' nodes", 64))?;
            Ok(())
        };
        match &placed.node.work {
            Work::Plain(part) => add_part(part)?,
            Work::Stage(stage) => {
                add_part(&stage.encoder)?;
                stage.decoders.iter().try_for_each(|(_, part)| add_part(part))?;
            }
        }
        if self.nodes > MAX_NODES {
            let problem = "this task has too many nodes with this one";
            let expected = format!(
                "at most {MAX_NODES}, counting each part of a stage and every node that an event adds"
            );
            return Err(Fault::new(at, Refusal::Limit, problem, expected));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
