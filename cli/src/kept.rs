//! What became of values, floors and predicted misses, and how long nodes took: for people.

use crate::given_up;
use crate::table::{Table, time};
use red_core::Duration;
use red_workload::metrics::TaskMetrics;

/// A table of all tasks of a run that is told in short, with what was promised to each.
pub(crate) fn tasks(tasks: &[TaskMetrics]) -> String {
    let mut table = Table::new(&["task", "released", "on time", "missed", "of them given up"]);
    for task in tasks {
        let counts = [task.released, task.on_time, task.missed, task.shed].map(|count| count.to_string());
        table.row([task.name.clone()].into_iter().chain(counts));
    }
    let parts = [table.to_string(), given_up::by_task(tasks), promises(tasks), nodes(tasks)];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n\n")
}

/// Value on time, floors, and how early misses were predicted; empty where no job missed and no task has a floor.
pub(crate) fn promises(tasks: &[TaskMetrics]) -> String {
    if tasks.iter().all(|task| task.missed == 0 && task.floor.is_none()) {
        return String::new();
    }
    let mut table = Table::new(&[
        "task",
        "value on time",
        "of",
        "floor",
        "worst window",
        "misses predicted",
        "ahead by p50",
    ]);
    for task in tasks {
        let (floor, worst) = task.floor.map_or(("-".to_owned(), "-".to_owned()), |floor| {
            let kept = if floor.kept { "kept" } else { "not kept" };
            (format!("{} of {}", floor.m, floor.k), format!("{}, {kept}", floor.worst))
        });
        let ahead = task.early_ns.p50.map_or("-".to_owned(), |ns| {
            let sign = if ns < 0 { "-" } else { "" };
            format!("{sign}{}", Duration::from_nanos(ns.unsigned_abs()))
        });
        table.row([
            task.name.clone(),
            task.value_on_time.to_string(),
            task.value_released.to_string(),
            floor,
            worst,
            task.warned.to_string(),
            ahead,
        ]);
    }
    let is_behind = tasks.iter().any(|task| task.early_ns.p50.is_some_and(|ns| ns < 0));
    let why = "\n\n  ahead by less than 0: told after the deadline, when a unit ended or a wait did and the scheduler looked again";
    table.to_string() + if is_behind { why } else { "" }
}

/// What nodes took beside their WCET; empty where that was not followed.
pub(crate) fn nodes(tasks: &[TaskMetrics]) -> String {
    if tasks.iter().all(|task| task.nodes.is_empty()) {
        return String::new();
    }
    let mut table = Table::new(&["node", "executions", "p50", "p99", "max", "WCET", "overruns"]);
    for task in tasks {
        for node in &task.nodes {
            let took = &node.execution_ns;
            let times = [took.p50, took.p99, took.max, Some(node.wcet_ns)].map(time);
            let name = format!("{}.{}", task.name, node.name);
            table.row(
                [name, node.count.to_string()].into_iter().chain(times).chain([node.overruns.to_string()]),
            );
        }
    }
    table.to_string()
}
