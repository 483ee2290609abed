//! A workload as the text of its file, so that a log holds what `redrt replay` sets its scheduler up from.

use red_workload::model::{Arrival, Event, Node, Part, Pool, PoolKind, Task, Work, Workload};
use std::fmt::Write;

/// The file of a workload that names no body.
pub(crate) fn toml(workload: &Workload) -> String {
    let mut text = String::new();
    let out = &mut text;
    for pool in &workload.pools {
        line(out, "[[pool]]");
        line(out, &format!("name = {:?}", pool.name));
        line(out, &format!("kind = {:?}", if pool.kind == PoolKind::Cpu { "cpu" } else { "cuda" }));
        line(out, &format!("lanes = {}", pool.lanes));
        pool.memory_bytes.iter().for_each(|bytes| line(out, &format!("memory = \"{bytes}B\"")));
    }
    for sensor in &workload.sensors {
        line(out, "[[sensor]]");
        line(out, &format!("name = {:?}", sensor.name));
        line(out, &format!("period = {}", time(sensor.period_ns)));
    }
    workload.tasks.iter().for_each(|task| add_task(out, &workload.pools, task));
    for event in &workload.events {
        add_event(out, workload, event);
    }
    if let Some(sync) = &workload.sync {
        line(out, &format!("[sync]\ngrid = {}\ncost = {}", time(sync.grid_ns), time(sync.cost_ns)));
    }
    text
}

fn add_task(out: &mut String, pools: &[Pool], task: &Task) {
    line(out, "[[task]]");
    line(out, &format!("name = {:?}", task.name));
    line(out, &format!("deadline = {}", time(task.deadline_ns)));
    line(
        out,
        &match task.arrival {
            Arrival::Periodic { period_ns } => format!("period = {}", time(period_ns)),
            Arrival::Sporadic { min_interarrival_ns } => {
                format!("min_interarrival = {}", time(min_interarrival_ns))
            }
            Arrival::Once => "once = true".to_owned(),
        },
    );
    line(out, &format!("offset = {}", time(task.offset_ns)));
    line(out, &format!("value = {}", task.value));
    task.floor.iter().for_each(|(m, k)| line(out, &format!("floor = [{m}, {k}]")));
    line(out, "node = [");
    task.nodes.iter().for_each(|node| line(out, &format!("  {},", node_table(pools, node))));
    line(out, "]");
}

fn add_event(out: &mut String, workload: &Workload, event: &Event) {
    line(out, "[[event]]");
    line(out, &format!("at = {}", time(event.at_ns)));
    line(out, &format!("task = {:?}", workload.tasks[event.task].name));
    line(out, "add = [");
    event.add.iter().for_each(|node| line(out, &format!("  {},", node_table(&workload.pools, node))));
    line(out, "]");
    line(out, &format!("remove = {:?}", event.remove));
}

fn node_table(pools: &[Pool], node: &Node) -> String {
    let mut keys = format!("name = {:?}", node.name);
    for (key, names) in [("after", &node.after), ("before", &node.before)] {
        if !names.is_empty() {
            let _infallible = write!(keys, ", {key} = {names:?}");
        }
    }
    match &node.work {
        Work::Plain(part) => format!("{{ {keys}, {} }}", part_keys(pools, part)),
        Work::Stage(stage) => {
            let decoder =
                |(name, part): &(String, Part)| format!("{{ name = {name:?}, {} }}", part_keys(pools, part));
            let decoders: Vec<String> = stage.decoders.iter().map(decoder).collect();
            format!(
                "{{ {keys}, mimonet = {{ weights = {:?}, frame = {:?}, encoder = {{ {} }}, decoders = [{}] }} }}",
                stage.weights,
                stage.frame,
                part_keys(pools, &stage.encoder),
                decoders.join(", ")
            )
        }
    }
}

fn part_keys(pools: &[Pool], part: &Part) -> String {
    let mut keys = format!(
        "wcet = {}, bcet = {}, pool = {:?}, memory = \"{}B\"",
        time(part.wcet_ns),
        time(part.bcet_ns),
        pools[part.pool].name,
        part.memory_bytes
    );
    if part.atomic {
        let _infallible = write!(keys, ", atomic = true, contention = {}", time(part.contention_ns));
    }
    keys
}

fn time(ns: u64) -> String {
    format!("\"{ns}ns\"")
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}

#[cfg(test)]
mod tests;
