//! The order of starts: no node starts while one of a smaller key is ready in its pool.
//!
//! Held under the policies whose keys stay as they are at a job's release: all nodes of a job are due at its deadline, or
//! each at its latest start. Encoders are left out: they may join a unit of their frame, or wait for one.

use super::{Judge, Name, Node};
use crate::counts::Count;
use red_core::{Capacity, NodeId, Role, Scheduler, TaskId};
use red_workload::policy::Policy;

/// A node of a graph.
pub(super) struct Facts {
    pub(super) predecessors: Vec<usize>,
    pub(super) pool: usize,
    is_encoder: bool,
    /// Its cost and the longest path after it.
    to_the_end_ns: u64,
}

/// The nodes of a graph by number, `None` where there is none.
pub(super) type Graph = Vec<Option<Facts>>;

/// What a node's key is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Deadline,
    LatestStart,
    /// It changes while the job runs, or a gate holds nodes back.
    Other,
}

impl Rule {
    pub(super) fn of(policy: Policy) -> Self {
        match policy {
            Policy::Edf => Self::Deadline,
            Policy::Redrt => Self::LatestStart,
            Policy::RedFg | Policy::RedIda | Policy::Red | Policy::RedrtLookahead => Self::Other,
        }
    }
}

/// The newest graph of a task.
pub(super) fn facts<C: Capacity>(scheduler: &Scheduler<C>, task: TaskId) -> Graph {
    let dag = scheduler.edit(task).expect("the task is there");
    let numbers: Vec<NodeId> = dag.nodes().collect();
    let size = numbers.last().map_or(0, |last| last.index() + 1);
    let node = |number: usize| {
        let id = NodeId::new(number as u8);
        let node = dag.node(id)?;
        let before = numbers.iter().filter(|other| dag.successors(**other).contains(number));
        Some(Facts {
            predecessors: before.map(|other| other.index()).collect(),
            pool: node.pool().index(),
            is_encoder: matches!(node.role(), Role::SharedEncoder(_)),
            to_the_end_ns: node.cost(),
        })
    };
    let mut graph: Graph = (0..size).map(node).collect();
    // Longest paths settle after as many rounds as a path has nodes.
    for _ in 0..numbers.len() {
        for number in &numbers {
            let after = dag.successors(*number).iter().filter_map(|next| graph[next].as_ref());
            let tail = after.map(|next| next.to_the_end_ns).max().unwrap_or(0);
            let own = dag.node(*number).map_or(0, |node| node.cost());
            graph[number.index()].iter_mut().for_each(|facts| facts.to_the_end_ns = own + tail);
        }
    }
    graph
}

/// Key, release, task, job and node: what goes first is the least.
type Order = (i128, u64, Name, usize);

impl Judge {
    /// No node that could start in this pool goes before this one; where ranks go before keys at times, none of its job.
    pub(super) fn expect_order(&mut self, name: Name, node: usize) -> Result<(), String> {
        let facts = self.graphs[name.0][self.jobs[&name].version][node].as_ref();
        let Some(facts) = facts.filter(|facts| self.rule != Rule::Other && !facts.is_encoder) else {
            return Ok(());
        };
        let own = self.order(name, node, facts);
        let is_compared = |other: &Name| self.rule != Rule::LatestStart || *other == name;
        for (other, job) in self.jobs.iter().filter(|(other, _)| is_compared(other)) {
            let graph = &self.graphs[other.0][job.version];
            for (number, facts_of) in graph.iter().enumerate() {
                let Some(waiting) = facts_of.as_ref().filter(|of| of.pool == facts.pool && !of.is_encoder)
                else {
                    continue;
                };
                let goes_before = || self.order(*other, number, waiting) < own;
                let is_ready = job.nodes[number] == Some(Node::Waiting)
                    && waiting.predecessors.iter().all(|before| job.is_done(*before));
                if is_ready && goes_before() {
                    return Err(format!("while node {number} of {other:?}, whose key is smaller, is ready"));
                }
            }
        }
        self.counts[Count::Ordered] += 1;
        Ok(())
    }

    fn order(&self, name: Name, node: usize, facts: &Facts) -> Order {
        let (release, deadline) = self.books.times(name);
        let before_ns = if self.rule == Rule::LatestStart { facts.to_the_end_ns } else { 0 };
        (i128::from(deadline) - i128::from(before_ns), release, name, node)
    }
}
