//! The order of starts: no node starts while one of a smaller key is ready in its pool.
//!
//! Held under EDF: all nodes of a job are due at its deadline. Under the other policies keys change, a gate holds nodes back, ranks
//! go before keys, or a node waits for a higher rank, by times that are not known here; `tests/tests/properties` judges those.
//! Encoders are left out: they may join a unit of their frame, or wait for one.

use super::{Judge, Name, Node};
use crate::counts::Count;
use red_core::{Capacity, NodeId, Role, Scheduler, TaskId};
use red_workload::policy::Policy;

/// A node of a graph.
pub(super) struct Facts {
    pub(super) predecessors: Vec<usize>,
    pub(super) pool: usize,
    is_encoder: bool,
}

/// The nodes of a graph by number, `None` where there is none.
pub(super) type Graph = Vec<Option<Facts>>;

/// What a node's key is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rule {
    Deadline,
    /// It changes while the job runs, or is not what decides alone.
    Other,
}

impl Rule {
    pub(super) fn of(policy: Policy) -> Self {
        match policy {
            Policy::Edf => Self::Deadline,
            _ => Self::Other,
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
        })
    };
    (0..size).map(node).collect()
}

/// Key, release, task, job and node: what goes first is the least.
type Order = (u64, u64, Name, usize);

impl Judge {
    /// No node that could start in this pool goes before this one.
    pub(super) fn expect_order(&mut self, name: Name, node: usize) -> Result<(), String> {
        let facts = self.graphs[name.0][self.jobs[&name].version][node].as_ref();
        let Some(facts) = facts.filter(|facts| self.rule != Rule::Other && !facts.is_encoder) else {
            return Ok(());
        };
        let own = self.order(name, node);
        for (other, job) in &self.jobs {
            let graph = &self.graphs[other.0][job.version];
            for (number, facts_of) in graph.iter().enumerate() {
                let Some(waiting) = facts_of.as_ref().filter(|of| of.pool == facts.pool && !of.is_encoder)
                else {
                    continue;
                };
                let goes_before = || self.order(*other, number) < own;
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

    fn order(&self, name: Name, node: usize) -> Order {
        let (release, deadline) = self.books.times(name);
        (deadline, release, name, node)
    }
}
