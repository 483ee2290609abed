//! Whether nodes take longer than they did in the beginning: a processor that gets hot, or whose clock is set down, makes
//! every measured cost wrong, and nothing else tells.
//!
//! *Rule.* A node's cost is the median of 15 executions in a row, which no single preemption moves. It has drifted when
//! two such medians in a row are above one and a half times the first, and that by a twentieth of its WCET: what is small
//! beside that changes no schedule.

use red_core::{Duration, Event, Instant};
use red_workload::build::Numbered;
use red_workload::metrics::nodes::{Executions, NodeMetrics};
use serde::Serialize;

const WINDOW: usize = 15;
/// What is no drift yet, in percent of the first median.
const STILL_PERCENT: u128 = 150;
/// Nor is less than this part of the WCET.
const PART_OF_WCET: u64 = 20;

/// A node whose cost has drifted.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub(crate) struct Drifted {
    /// Its task.
    pub(crate) task: String,
    /// Its name.
    pub(crate) node: String,
    /// What it took in the beginning.
    pub(crate) before_ns: u64,
    /// What it took when that was seen.
    pub(crate) after_ns: u64,
    /// When it was seen.
    pub(crate) at_ns: u64,
}

/// The costs of all nodes, as a run goes on.
#[derive(Debug, Default)]
pub(crate) struct Costs {
    executions: Executions,
    nodes: Vec<Vec<Cost>>,
    /// (task << 8 | node) + 1 of the last that drifted.
    last: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Cost {
    window: [u64; WINDOW],
    taken: usize,
    before_ns: u64,
    wcet_ns: u64,
    /// Medians in a row that were too large.
    above: u8,
    /// What it took then, and when.
    drifted: Option<(u64, u64)>,
}

impl Costs {
    /// Of tasks with these nodes.
    pub(crate) fn new(lanes: usize, nodes: &[Vec<Numbered>]) -> Self {
        let of_node = |node: &Numbered| Cost { wcet_ns: node.wcet_ns(), ..Cost::default() };
        let of_task = |nodes: &Vec<Numbered>| nodes.iter().map(of_node).collect();
        Self {
            executions: Executions::new(lanes, nodes),
            nodes: nodes.iter().map(of_task).collect(),
            last: 0,
        }
    }

    /// Follows the record. The node that drifted last, if one has, as the live view names it.
    pub(crate) fn event(&mut self, event: &Event) -> u64 {
        if let Some((task, node, took_ns)) = self.executions.event(event) {
            let cost = self.nodes.get_mut(task).and_then(|nodes| nodes.get_mut(node));
            if cost.is_some_and(|cost| cost.took(took_ns, event.at.as_nanos())) {
                self.last = ((task as u64) << 8 | node as u64) + 1;
            }
        }
        self.last
    }

    /// Nothing ran for so long: it is no part of what the nodes take that run.
    pub(crate) fn stood_still(&mut self, time: Duration, now: Instant) {
        self.executions.stood_still(time, now);
    }

    /// The nodes of a task, with what they took.
    pub(crate) fn nodes(&self, task: usize) -> Vec<NodeMetrics> {
        self.executions.of(task)
    }

    /// The nodes that have drifted.
    pub(crate) fn drifted(&self, tasks: &[String], nodes: &[Vec<Numbered>]) -> Vec<Drifted> {
        let named = tasks.iter().zip(nodes).zip(&self.nodes);
        let of_task = |((task, names), costs): ((&String, &Vec<Numbered>), &Vec<Cost>)| {
            let costs = names.iter().zip(costs);
            let told = costs.filter_map(|(node, cost)| {
                let (after_ns, at_ns) = cost.drifted?;
                let (task, node) = (task.clone(), node.name.clone());
                Some(Drifted { task, node, before_ns: cost.before_ns, after_ns, at_ns })
            });
            told.collect::<Vec<_>>()
        };
        named.flat_map(of_task).collect()
    }
}

impl Cost {
    /// Whether it is seen now that it has drifted.
    fn took(&mut self, ns: u64, at_ns: u64) -> bool {
        self.window[self.taken] = ns;
        self.taken += 1;
        if self.taken < WINDOW || self.drifted.is_some() {
            self.taken %= WINDOW;
            return false;
        }
        self.taken = 0;
        let (_, median, _) = self.window.select_nth_unstable(WINDOW / 2);
        let median = *median;
        if self.before_ns == 0 {
            // A marker node costs nothing, whatever it took once.
            self.before_ns = median.max(LEAST_NS);
        }
        let is_above = u128::from(median) * 100 > u128::from(self.before_ns) * STILL_PERCENT
            && median - self.before_ns > self.wcet_ns / PART_OF_WCET;
        self.above = if is_above { self.above + 1 } else { 0 };
        if self.above == 2 {
            self.drifted = Some((median, at_ns));
        }
        self.drifted.is_some()
    }
}

/// Below this it is the host that is measured, and no cost.
const LEAST_NS: u64 = 50_000;

#[cfg(test)]
mod tests {
    use super::*;
    use red_core::{Empty, EventKind, LaneId, NodeId, TaskId};
    use red_workload::build::Role;
    use red_workload::model::{Body, Part};

    const WCET_NS: u64 = 1_000_000;

    /// What is told when a node takes these times, one after the other.
    fn told(times_us: &[u64]) -> Vec<u64> {
        let node = |wcet_ns| {
            let part = Part {
                wcet_ns,
                bcet_ns: 0,
                body: Body::None,
                pool: 0,
                memory_bytes: 0,
                atomic: false,
                contention_ns: 0,
            };
            Numbered { name: "n".to_owned(), role: Role::Plain(part) }
        };
        let mut costs = Costs::new(1, &[vec![node(0), node(WCET_NS)]]);
        let mut now = 0;
        let mut event = |kind, at| {
            let event = Event {
                at: Instant::from_nanos(at),
                job: 0,
                kind,
                task: TaskId::EMPTY,
                node: NodeId::new(1),
                lane: LaneId::new(0),
            };
            costs.event(&event)
        };
        let told = times_us.iter().map(|took| {
            event(EventKind::Started, now);
            now += took * 1_000;
            event(EventKind::Completed, now)
        });
        told.collect()
    }

    #[test]
    fn what_takes_longer_for_good_is_told_once_it_is_sure() {
        let times = [[100; 30], [160; 30]].concat();
        let told = told(&times);
        assert_eq!(told.iter().position(|told| *told == 2), Some(59), "two medians in a row");
    }

    #[test]
    fn what_takes_longer_now_and_then_or_a_little_is_not() {
        let spikes: Vec<u64> = (0..300).map(|i| if i % 15 < 7 { 900 } else { 100 }).collect();
        let once = [[100; 30], [900; 30], [100; 30]].concat();
        let once: Vec<u64> =
            once.into_iter().enumerate().map(|(i, t)| if i < 45 { t } else { 100 }).collect();
        let short = [[1; 30], [40; 30]].concat();
        let beside_wcet = [[60; 30], [109; 30]].concat();
        for times in [spikes, once, [[100; 30], [149; 30]].concat(), short, beside_wcet] {
            assert!(told(&times).iter().all(|told| *told == 0), "{times:?}");
        }
    }
}
