//! From the tree to the model: the tables of a file in their order, each with its own checks.

mod body;
mod node;
mod placed;
mod pool;
mod task;

use std::collections::HashSet;

use crate::error::{Fault, Refusal, shown};
use crate::graph;
use crate::model::{MAX_INSTANT_NS, Sensor, SyncGrid, Workload};
use crate::tree::{Field, Fields, Tree};

use pool::Pools;

pub(crate) use placed::{PlacedEvent, PlacedNode, PlacedTask};

/// What the file as a whole is.
pub(crate) const OWNER: &str = "a workload";
/// Its keys.
pub(crate) const KEYS: [&str; 5] = ["pool", "sensor", "task", "event", "sync"];

/// Distinct periods of sensors: the scheduler's capacity.
const MAX_PERIODS: usize = 256;

/// Offset of the body of each part of each task; parts in the order in which nodes are numbered.
pub(crate) type BodiesAt = Vec<Vec<usize>>;

/// Reads and checks a whole workload.
pub(crate) fn workload(root: &Tree<'_>) -> Result<(Workload, BodiesAt), Fault> {
    let fields = Fields::open(root, OWNER, &KEYS)?;
    let pools = Pools::read(&fields)?;
    let (sensors, periods_at) = sensors(&fields)?;
    let mut tasks = task::all(&fields, &pools)?;
    let mut events = task::events(&fields, &pools, &mut tasks)?;
    let sync = fields.get("sync").map(sync).transpose()?;
    // Stable: events of one instant keep the order of the file.
    events.sort_by_key(|event| event.event.at_ns);
    for (index, task) in tasks.iter().enumerate() {
        graph::check(task, events.iter().filter(|event| event.event.task == index))?;
    }
    let bodies_at = tasks.iter().enumerate().map(|(index, task)| {
        let added = events.iter().filter(|event| event.event.task == index).flat_map(|event| &event.add);
        task.nodes.iter().chain(added).flat_map(|node| &node.bodies_at).copied().collect()
    });
    let bodies_at = bodies_at.collect();
    let workload = Workload {
        pools: pools.resolved,
        sensors,
        tasks: tasks.into_iter().map(PlacedTask::into_model).collect(),
        events: events.into_iter().map(PlacedEvent::into_model).collect(),
        sync,
    };
    check_periods(&workload, &periods_at)?;
    Ok((workload, bodies_at))
}

/// Sensors, and the offset of each one's period.
fn sensors(fields: &Fields<'_>) -> Result<(Vec<Sensor>, Vec<usize>), Fault> {
    let (mut sensors, mut periods_at) = (Vec::new(), Vec::new());
    let mut names = UniqueNames::of("sensor");
    if let Some(list) = fields.get("sensor") {
        for item in list.list()? {
            let fields = Fields::open(item.tree, "a sensor", &["name", "period"])?;
            let name = names.add(fields.need("name")?)?;
            let period = fields.need("period")?;
            sensors.push(Sensor { name, period_ns: period.time_in(1..=MAX_INSTANT_NS)? });
            periods_at.push(period.at());
        }
    }
    Ok((sensors, periods_at))
}

/// The scheduler knows only sensors that a stage reads, and sensors of one period as one.
fn check_periods(workload: &Workload, periods_at: &[usize]) -> Result<(), Fault> {
    let frames = workload.frames();
    let mut periods = HashSet::new();
    for (sensor, at) in workload.sensors.iter().zip(periods_at) {
        let is_new = frames.contains(&*sensor.name) && periods.insert(sensor.period_ns);
        if is_new && periods.len() > MAX_PERIODS {
            let problem = "with this one, stages read sensors of too many periods";
            let expected = format!("at most {MAX_PERIODS} of them: give sensors of one clock one period");
            return Err(Fault::new(*at, Refusal::Limit, problem, expected));
        }
    }
    Ok(())
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
