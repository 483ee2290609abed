//! A task as the search sees it: each of its graphs, and in each cluster what bounds all of them.
//!
//! *Rule.* Chains of the bound are the largest lengths, longest first; its nodes and groups are those of all graphs.
//! *Why it holds.* Whatever graph a job has, its chains are no more and no longer than these, its nodes are among these, and
//! its last job with work above a key is of a group that is among these. So nothing has to be known of when the task has
//! which graph, and jobs of old graphs may still run beside those of a new one.

use crate::shape::{Part, Shape, suffixes};
use red_certificate::{Cluster, Task};

/// A task. Times are in nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Member {
    pub(crate) deadline: i128,
    /// `None`: released once.
    pub(crate) period: Option<i128>,
    /// Of each of its graphs.
    pub(crate) shapes: Vec<Shape>,
    /// What bounds all of them in each cluster; `None` where none has a node.
    pub(crate) parts: Vec<Option<Part>>,
}

impl Member {
    pub(crate) fn of(clusters: &[Cluster], task: &Task) -> Self {
        let deadline = task.deadline_ns.into();
        let shapes: Vec<Shape> =
            task.versions.iter().map(|graph| Shape::of(clusters, deadline, graph)).collect();
        let parts = (0..clusters.len())
            .map(|cluster| shapes.iter().filter_map(|shape| shape.parts[cluster].clone()).reduce(Part::or))
            .collect();
        Self { deadline, period: task.period_ns.map(i128::from), shapes, parts }
    }

    /// How long after its release a job that is given up when it is late may be at work: a node that runs then ends.
    pub(crate) fn cut_at(&self) -> i128 {
        self.deadline + self.shapes.iter().map(|shape| shape.largest).max().unwrap_or(0) + 1
    }

    /// Jobs that are there at once, at most, if none is longer than `bound`.
    pub(crate) fn at_once(&self, bound: i128) -> i128 {
        1 + self.period.map_or(0, |period| bound.div_euclid(period))
    }

    /// The only cluster that it ever has nodes in.
    pub(crate) fn only_cluster(&self) -> Option<usize> {
        only(&self.parts)
    }
}

/// The only cluster with a part.
pub(crate) fn only(parts: &[Option<Part>]) -> Option<usize> {
    let mut used = parts.iter().enumerate().filter(|(_, part)| part.is_some()).map(|(at, _)| at);
    let first = used.next();
    if used.next().is_none() { first } else { None }
}

impl Part {
    /// What bounds both.
    fn or(mut self, mut other: Self) -> Self {
        let count = self.chains.len().max(other.chains.len());
        self.chains.resize(count, 0);
        other.chains.resize(count, 0);
        for (mine, theirs) in self.chains.iter_mut().zip(other.chains) {
            *mine = theirs.max(*mine);
        }
        self.suffixes = suffixes(&self.chains);
        self.work = self.work.max(other.work);
        self.nodes.extend(other.nodes);
        self.nodes.sort_unstable_by_key(|(_, cost)| std::cmp::Reverse(*cost));
        self.groups.extend(other.groups);
        self
    }
}

#[cfg(test)]
mod tests;
