//! What a node's executions took, beside its WCET.

use super::percentile;
use crate::build::Numbered;
use serde::Serialize;

/// Times in nanoseconds; `null` in JSON where there was no execution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct ExecutionTimes {
    /// Median, nearest rank.
    pub p50: Option<u64>,
    /// 99th percentile, nearest rank.
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

/// Executions of all nodes, kept whole.
#[derive(Clone, Debug, Default)]
pub struct Executions {
    /// By task and node.
    took_ns: Vec<Vec<Vec<u64>>>,
}

impl Executions {
    /// Of tasks with so many nodes.
    #[must_use]
    pub fn new(nodes: impl Iterator<Item = usize>) -> Self {
        Self { took_ns: nodes.map(|nodes| vec![Vec::new(); nodes]).collect() }
    }

    /// A node of a task was executed.
    pub fn add(&mut self, task: usize, node: usize, took_ns: u64) {
        if let Some(times) = self.took_ns.get_mut(task).and_then(|nodes| nodes.get_mut(node)) {
            times.push(took_ns);
        }
    }

    /// The nodes of a task.
    #[must_use]
    pub fn of(&self, task: usize, nodes: &[Numbered]) -> Vec<NodeMetrics> {
        let times = self.took_ns.get(task).into_iter().flatten();
        let of_node = |(node, times): (&Numbered, &Vec<u64>)| {
            let (mut sorted, wcet_ns) = (times.clone(), node.wcet_ns());
            sorted.sort_unstable();
            let [p50, p99] = [500, 990].map(|per_mille| percentile(&sorted, per_mille));
            NodeMetrics {
                name: node.name.clone(),
                wcet_ns,
                count: sorted.len() as u64,
                execution_ns: ExecutionTimes { p50, p99, max: sorted.last().copied() },
                overruns: sorted.iter().filter(|took| **took > wcet_ns).count() as u64,
            }
        };
        nodes.iter().zip(times).map(of_node).collect()
    }
}
