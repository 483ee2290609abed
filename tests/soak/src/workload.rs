//! Random workloads whose graphs are edited all the time, and what else a workload meets.

use crate::text::toml;
use red_tests::rng::{Rng, Shape, random_workload};
use red_workload::model::{Body, Event, Node, Part, Work, Workload};
use red_workload::policy::Policy;
use red_workload::{Format, parse};

/// Nodes that come to each task, at most.
const ROUNDS: u64 = 6;
/// Lanes of a workload in real time, at most.
const MOST_LANES: usize = 4;

/// A workload and what it meets, all by its seed.
pub(crate) struct Drawn {
    pub(crate) seed: u64,
    pub(crate) workload: Workload,
    /// Its file.
    pub(crate) text: String,
    pub(crate) policy: Policy,
    /// One pool with few lanes, which real time can have.
    pub(crate) realtime: bool,
    /// This task goes, with its jobs, at this instant.
    pub(crate) removal: Option<(usize, u64)>,
}

impl Drawn {
    /// The workload of a seed, with releases over `length_ns`. `cpus` are those for lanes in real time, 0 where there is
    /// none.
    pub(crate) fn of(seed: u64, length_ns: u64, cpus: usize, edits: bool) -> Self {
        let rng = &mut Rng::new(seed);
        let realtime = cpus > 0 && matches!(seed % 8, 1 | 3 | 5);
        let pools = if realtime { 1 } else { 2 };
        let shape = Shape { pools, nodes: 12, memory: false, sync: false, events: edits, ..Shape::default() };
        let mut workload = random_workload(seed, &shape);
        if realtime {
            workload.pools[0].lanes = rng.within(1, cpus.min(MOST_LANES) as u64) as u32;
        }
        if edits {
            (0..workload.tasks.len()).for_each(|task| edit(rng, &mut workload, task, length_ns));
            // Stable: of one instant, what comes first stays first.
            workload.events.sort_by_key(|event| event.at_ns);
        }
        let policy = Policy::ALL[rng.index(Policy::ALL.len())];
        let removal = rng
            .chance(25)
            .then(|| (rng.index(workload.tasks.len()), rng.within(length_ns * 6 / 10, length_ns * 9 / 10)));
        // As `redrt replay` reads it, so that both set up the same.
        let text = toml(&workload);
        let workload = parse(text.as_bytes(), Format::Toml, "random").expect("random workloads are valid");
        Self { seed, workload, text, policy, realtime, removal }
    }
}

/// Nodes that come to a task and go again, and one of its own that goes.
fn edit(rng: &mut Rng, workload: &mut Workload, task: usize, length_ns: u64) {
    let pools = workload.pools.len();
    let base = &workload.tasks[task].nodes;
    let mut events = Vec::new();
    for round in 0..rng.within(1, ROUNDS) {
        // Edges go from earlier to later nodes of the task, so that no order of edits closes a cycle.
        let split = rng.index(base.len());
        let after = (split > 0).then(|| base[rng.index(split)].name.clone());
        let before = rng.chance(70).then(|| base[split].name.clone());
        let node = Node {
            name: format!("s{round}"),
            after: after.into_iter().collect(),
            before: before.into_iter().collect(),
            work: Work::Plain(part(rng, pools)),
        };
        let at_ns = rng.within(0, length_ns * 7 / 10);
        let remove = vec![node.name.clone()];
        events.push(Event { at_ns, task, add: vec![node], remove: Vec::new() });
        if rng.chance(60) {
            let at_ns = at_ns + rng.within(1, length_ns / 4);
            events.push(Event { at_ns, task, add: Vec::new(), remove });
        }
    }
    let of_task = workload.events.iter().filter(|event| event.task == task);
    let named: Vec<&str> = of_task
        .chain(&events)
        .flat_map(|event| &event.add)
        .flat_map(|node| node.after.iter().chain(&node.before))
        .map(|name| name.split('.').next().unwrap_or(name))
        .collect();
    let mut free = base.iter().filter(|node| !named.contains(&node.name.as_str()));
    if let Some(node) = free.next_back().filter(|_| base.len() > 1) {
        let remove = vec![node.name.clone()];
        events.push(Event { at_ns: length_ns * 8 / 10, task, add: Vec::new(), remove });
    }
    workload.events.extend(events);
}

fn part(rng: &mut Rng, pools: usize) -> Part {
    let wcet_ns = rng.within(50_000, 2_000_000);
    Part {
        wcet_ns,
        bcet_ns: wcet_ns / 2,
        body: Body::None,
        pool: rng.index(pools),
        memory_bytes: 0,
        atomic: false,
        contention_ns: 0,
    }
}

#[cfg(test)]
mod tests;
