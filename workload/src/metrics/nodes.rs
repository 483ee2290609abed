//! What a node's executions took, beside its WCET.

use crate::build::Numbered;
use hdrhistogram::Histogram;
use red_core::{Duration, Event, EventKind, Instant};
use serde::Serialize;

/// A body fails when it runs longer than 10 times its WCET and somewhat more than this.
const LONGEST_ABOVE_NS: u64 = 1_000_000_000;

/// Times in nanoseconds; `null` in JSON where there was no execution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ExecutionTimes {
    /// Median, to a thousandth.
    pub p50: Option<u64>,
    /// 99th percentile, to a thousandth.
    pub p99: Option<u64>,
    /// Longest.
    pub max: Option<u64>,
}

/// A node in numbers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NodeMetrics {
    /// Its name in its task.
    pub name: String,
    /// Its worst-case execution time, contention apart.
    pub wcet_ns: u64,
    /// How often it was executed. An encoder that took a kept result was not.
    pub count: u64,
    /// What that took, on its lane.
    pub execution_ns: ExecutionTimes,
    /// Executions above the WCET.
    pub overruns: u64,
}

/// Executions of all nodes, in memory that does not grow.
#[derive(Clone, Debug, Default)]
pub struct Executions {
    /// When what each lane runs was started.
    started: Vec<Option<Instant>>,
    /// By task and node.
    nodes: Vec<Vec<Times>>,
}

#[derive(Clone, Debug)]
struct Times {
    name: String,
    wcet_ns: u64,
    all: Histogram<u32>,
    longest_ns: u64,
    overruns: u64,
}

impl Executions {
    /// Of tasks with these nodes, on so many lanes.
    #[must_use]
    pub fn new(lanes: usize, nodes: &[Vec<Numbered>]) -> Self {
        let of_task = |nodes: &Vec<Numbered>| nodes.iter().map(Times::new).collect();
        Self { started: vec![None; lanes], nodes: nodes.iter().map(of_task).collect() }
    }

    /// Follows the record: an execution that ends is added. Its task, node and time.
    pub fn event(&mut self, event: &Event) -> Option<(usize, usize, u64)> {
        let lane = self.started.get_mut(event.lane.index())?;
        match event.kind {
            EventKind::Started => *lane = Some(event.at),
            EventKind::Completed => {
                let took_ns = event.at.since((*lane)?).as_nanos();
                let (task, node) = (event.task.index(), event.node.index());
                self.add(task, node, took_ns);
                return Some((task, node, took_ns));
            }
            _ => {}
        }
        None
    }

    /// Nothing ran for so long until `now`: it is no part of what runs.
    pub fn stood_still(&mut self, time: Duration, now: Instant) {
        for started in self.started.iter_mut().flatten() {
            *started = started.saturating_add(time).min(now);
        }
    }

    /// A node of a task was executed.
    pub fn add(&mut self, task: usize, node: usize, took_ns: u64) {
        if let Some(times) = self.nodes.get_mut(task).and_then(|nodes| nodes.get_mut(node)) {
            times.all.saturating_record(took_ns);
            times.longest_ns = times.longest_ns.max(took_ns);
            times.overruns += u64::from(took_ns > times.wcet_ns);
        }
    }

    /// The nodes of a task.
    #[must_use]
    pub fn of(&self, task: usize) -> Vec<NodeMetrics> {
        self.nodes.get(task).into_iter().flatten().map(Times::metrics).collect()
    }
}

impl Times {
    fn new(node: &Numbered) -> Self {
        let (name, wcet_ns) = (node.name.clone(), node.wcet_ns());
        let least = (wcet_ns / 4_096).max(1);
        let most = wcet_ns.saturating_mul(10).saturating_add(LONGEST_ABOVE_NS).max(2 * least);
        let all = Histogram::new_with_bounds(least, most, 3).expect("the bounds lie apart");
        Self { name, wcet_ns, all, longest_ns: 0, overruns: 0 }
    }

    fn metrics(&self) -> NodeMetrics {
        let at = |q: f64| (!self.all.is_empty()).then(|| self.all.value_at_quantile(q).min(self.longest_ns));
        let max = (!self.all.is_empty()).then_some(self.longest_ns);
        NodeMetrics {
            name: self.name.clone(),
            wcet_ns: self.wcet_ns,
            count: self.all.len(),
            execution_ns: ExecutionTimes { p50: at(0.5), p99: at(0.99), max },
            overruns: self.overruns,
        }
    }
}
