//! Short ways to write workloads in tests. Times are milliseconds, memory is bytes.

use red_workload::model::{
    Arrival, Body, Event, Node, Part, Pool, PoolKind, Sensor, Stage, Task, Work, Workload,
};

use crate::oracle::{Outcome, Row};

pub(crate) const MS: u64 = 1_000_000;

pub(crate) fn part(cost_ms: u64) -> Part {
    Part {
        wcet_ns: cost_ms * MS,
        bcet_ns: 0,
        body: Body::None,
        pool: 0,
        memory_bytes: 0,
        atomic: false,
        contention_ns: 0,
    }
}

pub(crate) fn node(name: &str, cost_ms: u64, after: &[&str]) -> Node {
    written(name, after, Work::Plain(part(cost_ms)))
}

pub(crate) fn heavy(name: &str, cost_ms: u64, memory_bytes: u64) -> Node {
    written(name, &[], Work::Plain(Part { memory_bytes, ..part(cost_ms) }))
}

pub(crate) fn written(name: &str, after: &[&str], work: Work) -> Node {
    let after = after.iter().map(|&reference| reference.to_owned()).collect();
    Node { name: name.to_owned(), after, before: Vec::new(), work }
}

/// A stage of weights `w` and frame `front`.
pub(crate) fn stage(name: &str, encoder_ms: u64, decoders: &[(&str, u64)], after: &[&str]) -> Node {
    let decoders = decoders.iter().map(|&(name, cost)| (name.to_owned(), part(cost))).collect();
    let (weights, frame) = ("w".to_owned(), "front".to_owned());
    written(name, after, Work::Stage(Stage { weights, frame, encoder: part(encoder_ms), decoders }))
}

/// A task with one release at 0.
pub(crate) fn once(name: &str, deadline_ms: u64, nodes: Vec<Node>) -> Task {
    Task {
        name: name.to_owned(),
        deadline_ns: deadline_ms * MS,
        arrival: Arrival::Once,
        offset_ns: 0,
        value: 1,
        floor: None,
        nodes,
    }
}

pub(crate) fn at(task: Task, offset_ms: u64) -> Task {
    Task { offset_ns: offset_ms * MS, ..task }
}

pub(crate) fn every(task: Task, period_ms: u64) -> Task {
    Task { arrival: Arrival::Periodic { period_ns: period_ms * MS }, ..task }
}

/// One pool, named `gpu`.
pub(crate) fn workload(lanes: u32, tasks: Vec<Task>) -> Workload {
    let name = "gpu".to_owned();
    let pool = Pool { name, kind: PoolKind::Cpu, lanes, memory_bytes: None, cpus: Vec::new() };
    Workload { pools: vec![pool], sensors: Vec::new(), tasks, events: Vec::new(), sync: None }
}

/// With a sensor `front`.
pub(crate) fn sensed(mut workload: Workload, period_ms: u64) -> Workload {
    workload.sensors.push(Sensor { name: "front".to_owned(), period_ns: period_ms * MS });
    workload
}

pub(crate) fn adding(at_ms: u64, task: usize, node: Node) -> Event {
    Event { at_ns: at_ms * MS, task, add: vec![node], remove: Vec::new() }
}

/// `task/job/node lane start..finish`, in milliseconds.
pub(crate) fn lines(outcome: &Outcome) -> Vec<String> {
    let line = |row: &Row| {
        let lane = row.lane.map_or("-".to_owned(), |lane| lane.to_string());
        let (from, to) = (row.start_ns / MS, row.finish_ns / MS);
        format!("{}/{}/{} {lane} {from}..{to}", row.task, row.job, row.node)
    };
    outcome.rows.iter().map(line).collect()
}

/// `task/job at reason`, in milliseconds.
pub(crate) fn shed_lines(outcome: &Outcome) -> Vec<String> {
    let sheds = outcome.sheds.iter();
    sheds
        .map(|shed| format!("{}/{} {} {}", shed.task, shed.job, shed.at_ns / MS, shed.reason.name()))
        .collect()
}
