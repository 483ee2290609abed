//! Seeded random numbers, and random workloads that every policy must take.

mod graphs;

use red_workload::model::{Arrival, Event, Pool, PoolKind, Sensor, SyncGrid, Task, Work, Workload};

use crate::graph::Graph;
use graphs::{Names, added_nodes, nodes};

pub use red_traces::Rng;

/// What a random workload may contain.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shape {
    /// Most pools, 1 or 2.
    pub pools: u32,
    /// Most tasks, up to 16.
    pub tasks: u64,
    /// Most nodes per task as written; a stage is one.
    pub nodes: u64,
    /// MIMONet stages, with weights and frames shared between tasks.
    pub stages: bool,
    /// Nodes that take no time.
    pub zero_costs: bool,
    /// Memory budgets in some pools.
    pub memory: bool,
    /// Nodes that come and go.
    pub events: bool,
    /// A barrier grid in some workloads.
    pub sync: bool,
    /// Least and most utilisation of all lanes together, in percent.
    pub load_percent: (u64, u64),
}

impl Default for Shape {
    fn default() -> Self {
        Self {
            pools: 2,
            tasks: 4,
            nodes: 40,
            stages: true,
            zero_costs: true,
            memory: true,
            events: true,
            sync: true,
            load_percent: (30, 150),
        }
    }
}

/// A valid workload of this shape; equal seeds give equal workloads.
pub fn random_workload(seed: u64, shape: &Shape) -> Workload {
    let rng = &mut Rng::new(seed);
    let pools = pools(rng, shape);
    let lanes: u64 = pools.iter().map(|pool| u64::from(pool.lanes)).sum();
    let names = Names::new(rng, pools.len());
    let count = rng.within(1, shape.tasks);
    let load = rng.within(shape.load_percent.0, shape.load_percent.1);
    let mut workload = Workload {
        pools,
        sensors: sensors(rng),
        tasks: (0..count).map(|index| task(rng, shape, &names, index, load * lanes, count)).collect(),
        events: Vec::new(),
        sync: None,
    };
    if shape.events && rng.chance(50) {
        workload.events = events(rng, &names, &workload.tasks);
    }
    if shape.sync && rng.chance(20) {
        workload.sync =
            Some(SyncGrid { grid_ns: rng.within(1, 8) * 500_000, cost_ns: rng.within(0, 4) * 50_000 });
    }
    if shape.memory && rng.chance(40) {
        let which = rng.index(workload.pools.len());
        let slack = rng.within(0, 3) * 8 * graphs::MIB;
        workload.pools[which].memory_bytes = Some(largest_footprint(&workload, which) + slack);
    }
    workload
}

fn pools(rng: &mut Rng, shape: &Shape) -> Vec<Pool> {
    let pool = |rng: &mut Rng, name: &str| Pool {
        name: name.to_owned(),
        kind: PoolKind::Cpu,
        lanes: u32::try_from(rng.within(1, 4)).expect("small"),
        memory_bytes: None,
        cpus: Vec::new(),
    };
    let mut pools = vec![pool(rng, "gpu")];
    if shape.pools > 1 && rng.chance(50) {
        pools.push(pool(rng, "cpu"));
    }
    pools
}

/// Frame `front` has a sensor more often than not, the others never.
fn sensors(rng: &mut Rng) -> Vec<Sensor> {
    let period_ns = rng.within(5, 150) * 1_000_000;
    if rng.chance(70) { vec![Sensor { name: "front".to_owned(), period_ns }] } else { Vec::new() }
}

/// A task of about its part of `load` percent of one lane.
fn task(rng: &mut Rng, shape: &Shape, names: &Names, index: u64, load: u64, count: u64) -> Task {
    let nodes = nodes(rng, shape, names);
    let graph = Graph::of(&nodes, true);
    let costs = graph.costs();
    let work: u64 = costs.iter().sum();
    let longest = graph.longest_path(&costs);
    let share = rng.within(load / count / 2 + 1, load / count + 1);
    let period_ns = (work * 100 / share).clamp(1_000_000, 400_000_000);
    // From hopeless to loose, now and then longer than the period.
    let deadline_ns = match rng.within(0, 9) {
        0 => longest * rng.within(50, 99) / 100,
        1 | 2 => longest,
        3..=7 => longest + period_ns.saturating_sub(longest) * rng.within(10, 100) / 100,
        _ => longest + period_ns * rng.within(100, 200) / 100,
    };
    let arrival = match rng.within(0, 9) {
        0 => Arrival::Once,
        1 => Arrival::Sporadic { min_interarrival_ns: period_ns },
        _ => Arrival::Periodic { period_ns },
    };
    let k = rng.within(1, 5);
    let floor = (rng.within(0, k), k);
    let small = |value: u64| u32::try_from(value).expect("small");
    Task {
        name: format!("t{index}"),
        deadline_ns: deadline_ns.max(1),
        arrival,
        offset_ns: if rng.chance(50) { 0 } else { rng.within(0, period_ns) },
        value: small(rng.within(0, 3)),
        floor: rng.chance(30).then(|| (small(floor.0), small(floor.1))),
        nodes,
    }
}

/// Nodes that one task gains and loses again, at distinct instants.
fn events(rng: &mut Rng, names: &Names, tasks: &[Task]) -> Vec<Event> {
    let task = rng.index(tasks.len());
    let mut at_ns = rng.within(0, 60_000_000);
    let mut events: Vec<Event> = Vec::new();
    for round in 0..rng.within(1, 3) {
        let add = added_nodes(rng, names, &tasks[task].nodes, round);
        let remove = add.iter().map(|node| node.name.clone()).collect();
        events.push(Event { at_ns, task, add, remove: Vec::new() });
        at_ns += rng.within(1, 60_000_000);
        if rng.chance(60) {
            events.push(Event { at_ns, task, add: Vec::new(), remove });
            at_ns += rng.within(1, 60_000_000);
        }
    }
    events
}

/// What the largest node of a pool needs, and an encoder with any one decoder.
fn largest_footprint(workload: &Workload, pool: usize) -> u64 {
    let added = workload.events.iter().flat_map(|event| &event.add);
    let works = workload.tasks.iter().flat_map(|task| &task.nodes).chain(added).map(|node| &node.work);
    let footprint = |work: &Work| match work {
        Work::Plain(part) => part.memory_bytes,
        Work::Stage(stage) => {
            let decoders = stage.decoders.iter().map(|(_, part)| part.memory_bytes);
            stage.encoder.memory_bytes + decoders.max().unwrap_or(0)
        }
    };
    let uses = |work: &&Work| match work {
        Work::Plain(part) => part.pool == pool,
        Work::Stage(stage) => {
            stage.encoder.pool == pool || stage.decoders.iter().any(|(_, part)| part.pool == pool)
        }
    };
    works.filter(uses).map(footprint).max().unwrap_or(0).max(1)
}

#[cfg(test)]
mod tests;
