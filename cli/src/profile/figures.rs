//! From measured times to what the file gets and what is printed.

use super::edit::Times;
use super::machine::{Machine, PRIORITY};
use super::measure::{Measured, Node};
use crate::table::{Table, time};
use red_workload::model::Workload;
use serde::Serialize;
use std::path::Path;

/// Times of one body, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub(super) struct Sample {
    /// How many.
    pub(super) runs: usize,
    /// Smallest.
    pub(super) min_ns: u64,
    /// Median.
    pub(super) median_ns: u64,
    /// 99th percentile, nearest rank.
    pub(super) p99_ns: u64,
    /// Largest.
    pub(super) max_ns: u64,
}

impl Sample {
    /// Sorts them.
    pub(super) fn of(mut times: Vec<u64>) -> Self {
        times.sort_unstable();
        let runs = times.len();
        let rank = |percent: usize| {
            times.get((runs * percent).div_ceil(100).saturating_sub(1)).copied().unwrap_or(0)
        };
        Self { runs, min_ns: rank(0), median_ns: rank(50), p99_ns: rank(99), max_ns: rank(100) }
    }
}

/// A profile, before it is written.
pub(super) struct Summary<'a> {
    pub(super) workload: &'a Workload,
    pub(super) measured: &'a Measured,
    pub(super) machine: &'a Machine,
    pub(super) margin_percent: u64,
}

impl Summary<'_> {
    /// What the file gets for each node of each task.
    pub(super) fn times(&self) -> Vec<Vec<Times>> {
        let of_task = |task| {
            let nodes = self.measured.nodes.iter().filter(move |node| node.task == task);
            nodes.map(|node| self.of_node(node)).map(|times| times.0).collect()
        };
        (0..self.workload.tasks.len()).map(of_task).collect()
    }

    /// The lanes of each pool, `None` where there was nothing to measure.
    pub(super) fn lanes(&self) -> Vec<Option<u64>> {
        self.measured.rho_percent.iter().map(|rho| rho.map(|rho| (rho / 100).max(1))).collect()
    }

    /// A node's times for the file, and its contention whether or not the file gets it.
    fn of_node(&self, node: &Node) -> (Times, Option<u64>) {
        let with_margin = u128::from(node.alone.max_ns) * u128::from(100 + self.margin_percent);
        let wcet_ns = up(u64::try_from(with_margin.div_ceil(100)).unwrap_or(u64::MAX));
        let contention_ns = node.contention_ns.map(up);
        let times = Times {
            wcet_ns,
            bcet_ns: down(node.alone.min_ns),
            contention_ns: contention_ns.filter(|_| node.part.atomic),
        };
        (times, contention_ns)
    }

    /// The comment on top of the copy.
    pub(super) fn header(&self, file: &Path) -> String {
        let Machine { cpus, model, kernel, .. } = self.machine;
        let most = self.measured.nodes.iter().map(|node| node.alone.runs).max().unwrap_or(0);
        let fewest = self.measured.nodes.iter().map(|node| node.alone.runs).min().unwrap_or(0);
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy();
        let mut lines = vec![
            format!("Profiled by redrt from {}.", name.escape_debug()),
            format!("Machine: {model}, CPUs used: {}, Linux {kernel}; {}.", cpus.len(), self.conditions()),
            format!(
                "Runs per node: {fewest} to {most}. wcet: longest alone and {} %; bcet: shortest alone.",
                self.margin_percent
            ),
        ];
        if let Some(device) = &self.machine.device {
            lines.push(format!("CUDA device: {device}; nodes there by events on it, copies included."));
        }
        lines.push(if self.measured.nodes.iter().all(|node| node.contention_ns.is_none()) {
            "contention: not measured, there is one CPU.".to_owned()
        } else {
            "contention (atomic nodes): longest beside the heaviest co-runners on all other CPUs, or streams, less longest \
             alone."
                .to_owned()
        });
        for (pool, rho) in self.workload.pools.iter().zip(&self.measured.rho_percent) {
            lines.push(match rho {
                Some(rho) => format!(
                    "Pool {}: rho = {}.{:02}; lanes: that rounded down, at least 1.",
                    pool.name,
                    rho / 100,
                    rho % 100
                ),
                None => format!("Pool {}: no nodes, lanes as they were.", pool.name),
            });
        }
        lines.iter().map(|line| format!("# {line}\n")).collect::<String>() + "\n"
    }

    fn conditions(&self) -> String {
        if self.machine.realtime() {
            format!("real time (SCHED_FIFO {PRIORITY}, memory locked)")
        } else {
            "BEST EFFORT, not real time".to_owned()
        }
    }
}

/// Times from 100 us on are written in whole microseconds, an error below 1 %.
const fn granule(ns: u64) -> u64 {
    if ns < 100_000 { 1 } else { 1_000 }
}

/// A bound from above.
fn up(ns: u64) -> u64 {
    ns.checked_next_multiple_of(granule(ns)).unwrap_or(ns)
}

/// A bound from below.
const fn down(ns: u64) -> u64 {
    ns - ns % granule(ns)
}

/// The answer, as `--json` prints it.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    nodes: Vec<NodeRow<'a>>,
    pools: Vec<PoolRow<'a>>,
    realtime: bool,
    file: String,
}

#[derive(Serialize)]
struct NodeRow<'a> {
    task: &'a str,
    node: &'a str,
    #[serde(flatten)]
    alone: Sample,
    wcet_ns: u64,
    bcet_ns: u64,
    contention_ns: Option<u64>,
}

#[derive(Serialize)]
struct PoolRow<'a> {
    name: &'a str,
    rho: Option<f64>,
    lanes: u64,
}

impl<'a> Report<'a> {
    /// The profile that was written to `file`.
    pub(super) fn new(summary: &Summary<'a>, file: &Path) -> Self {
        let row = |node: &'a Node| {
            let (times, contention_ns) = summary.of_node(node);
            NodeRow {
                task: &summary.workload.tasks[node.task].name,
                node: &node.name,
                alone: node.alone,
                wcet_ns: times.wcet_ns,
                bcet_ns: times.bcet_ns,
                contention_ns,
            }
        };
        let lanes = summary.lanes();
        let rows = summary.workload.pools.iter().zip(&summary.measured.rho_percent).zip(lanes);
        let pools = rows.map(|((pool, rho), lanes)| PoolRow {
            name: &pool.name,
            rho: rho.map(|rho| rho as f64 / 100.0),
            lanes: lanes.unwrap_or(u64::from(pool.lanes)),
        });
        Self {
            nodes: summary.measured.nodes.iter().map(row).collect(),
            pools: pools.collect(),
            realtime: summary.machine.realtime(),
            file: file.to_string_lossy().into_owned(),
        }
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let mut alone = Table::new(&["node, alone", "runs", "min", "median", "p99", "max"]);
        let mut written = Table::new(&["node, in the file", "wcet", "bcet", "contention"]);
        for row in &self.nodes {
            let Sample { runs, min_ns, median_ns, p99_ns, max_ns } = row.alone;
            let name = format!("{}.{}", row.task, row.node);
            let times = [min_ns, median_ns, p99_ns, max_ns].map(|ns| time(Some(ns)));
            alone.row([name.clone(), runs.to_string()].into_iter().chain(times));
            let times = [Some(row.wcet_ns), Some(row.bcet_ns), row.contention_ns].map(time);
            written.row([name].into_iter().chain(times));
        }
        let pools: String = self.pools.iter().map(PoolRow::text).collect();
        let mode = if self.realtime { "real time" } else { "BEST EFFORT, not real time" };
        format!(
            "{alone}\n\n{written}\n\n{pools}measured in {mode}; contention is written for atomic nodes\nfile: {}",
            self.file
        )
    }
}

impl PoolRow<'_> {
    fn text(&self) -> String {
        let rho = self.rho.map_or_else(|| "not measured".to_owned(), |rho| format!("{rho:.2}"));
        format!("pool {}: rho {rho}, lanes {}\n", self.name, self.lanes)
    }
}

#[cfg(test)]
mod tests;
