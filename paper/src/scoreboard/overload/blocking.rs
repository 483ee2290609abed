//! Who kept a lane from a group that broke.
//!
//! *Rule.* Looked at is the first job of the group that was not on time, and all time before it ended in which the group had
//! something in flight without a break: what a lane did then is lacking at the end. A node of lower value that had a lane then is a
//! blocker if nothing of the group was ready when it started, or all of the group that was in flight could still end in time
//! behind it, at mean times and with nobody else on the lanes: it took a lane that nobody needed yet, and more of the group came
//! after that. A group is blocked if it met such nodes only.

use super::load::Set;
use crate::scoreboard::drive::{Ends, Span};
use std::collections::BTreeMap;

/// A node of lower value that had a lane while a job was in flight that missed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Met {
    /// When it ran, and whose it is.
    pub(super) span: Span,
    /// Why it got its lane.
    pub(super) why: Why,
}

/// What a group lacked when a node of lower value started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Why {
    /// None of its nodes was ready.
    NothingReady,
    /// All of it that was in flight could wait.
    CouldWait,
    /// It could not.
    CouldNotWait,
}

/// The first job of a group that was not on time, as (task, number).
pub(super) fn first_missed(set: &Set, group: &[usize], ends: &Ends) -> Option<(usize, u64)> {
    let is_missed =
        |(task, job): &(usize, u64)| group.contains(task) && !ends.fates[*task][*job as usize].on_time;
    set.jobs().filter(is_missed).min_by_key(|(task, job)| (set.releases[*task][*job as usize], *task, *job))
}

/// Whether all that a group met started while it could wait, and there was somebody.
pub(super) fn is_blocked(met: &[Met]) -> bool {
    !met.is_empty() && met.iter().all(|met| met.why != Why::CouldNotWait)
}

/// The nodes of lower value that had a lane while a group had something in flight, up to the end of the first job of it that
/// was missed.
pub(super) fn met(set: &Set, group: &[usize], ends: &Ends) -> Vec<Met> {
    let Some((task, job)) = first_missed(set, group, ends) else { return Vec::new() };
    let release = set.releases[task][job as usize];
    let until = ends.fates[task][job as usize].at.min(release + set.tasks[task].deadline_ns);
    let since = busy_since(set, group, ends, release);
    let is_met = |span: &&Span| !group.contains(&span.task) && span.start < until && span.end > since;
    let why = |span: &Span| {
        let plan = Plan::at(set, group, ends, span.start);
        if !plan.is_anything_ready(span.start) {
            Why::NothingReady
        } else if plan.ends_in_time(span.start) {
            Why::CouldWait
        } else {
            Why::CouldNotWait
        }
    };
    ends.spans.iter().filter(is_met).map(|span| Met { span: *span, why: why(span) }).collect()
}

/// From when a group had something in flight without a break, up to an instant.
fn busy_since(set: &Set, group: &[usize], ends: &Ends, at: u64) -> u64 {
    let mut jobs: Vec<(u64, u64)> = set
        .jobs()
        .filter(|(task, _)| group.contains(task))
        .map(|(task, job)| (set.releases[task][job as usize], ends.fates[task][job as usize].at))
        .filter(|(release, _)| *release <= at)
        .collect();
    jobs.sort_unstable();
    let (mut since, mut until) = (at, 0);
    for (release, end) in jobs {
        if release > until {
            since = release;
        }
        until = until.max(end);
    }
    since
}

/// A node, as (task, job, number).
type Node = (usize, u64, usize);

/// What a group has in flight at an instant, just after something has started there.
struct Plan<'a> {
    set: &'a Set,
    /// When each node has ended that has started, at its mean where that is to come.
    end: BTreeMap<Node, u64>,
    /// When each lane is free, at mean times.
    free: Vec<u64>,
    /// Those that have not started.
    waiting: Vec<Node>,
}

impl<'a> Plan<'a> {
    fn at(set: &'a Set, group: &[usize], ends: &Ends, at: u64) -> Self {
        let cost = |span: &Span| set.mean(span.task, span.node);
        // Spans are in the order of starts.
        let started = &ends.spans[..ends.spans.partition_point(|span| span.start <= at)];
        let until = |span: &Span| if span.end > at { at.max(span.start + cost(span)) } else { span.end };
        let end: BTreeMap<Node, u64> =
            started.iter().map(|span| ((span.task, span.job, span.node), until(span))).collect();
        let mut free: Vec<u64> = started.iter().filter(|span| span.end > at).map(until).collect();
        free.resize(set.lanes.into(), at);
        let in_flight = set.jobs().filter(|(task, job)| {
            let (release, fate) = (set.releases[*task][*job as usize], ends.fates[*task][*job as usize]);
            group.contains(task) && release <= at && fate.at > at
        });
        let nodes = in_flight.flat_map(|(task, job)| {
            (0..set.tasks[task].graph.costs.len()).map(move |node| (task, job, node))
        });
        let waiting = nodes.filter(|node| !end.contains_key(node)).collect();
        Self { set, end, free, waiting }
    }

    /// When the last node before one ends; `None` if one of these has no end yet.
    fn ready(&self, (task, job, node): Node) -> Option<u64> {
        let before = self.before(task, node);
        before
            .map(|from| self.end.get(&(task, job, from)).copied())
            .try_fold(0, |ready, end| Some(ready.max(end?)))
    }

    fn before(&self, task: usize, node: usize) -> impl Iterator<Item = usize> {
        let graph = &self.set.tasks[task].graph;
        (0..graph.costs.len()).filter(move |from| graph.successors[*from].contains(&node))
    }

    fn is_anything_ready(&self, at: u64) -> bool {
        self.waiting.iter().any(|node| self.ready(*node).is_some_and(|ready| ready <= at))
    }

    /// Whether all ends in time if nothing else starts: by latest finish, as `redrt` does.
    fn ends_in_time(mut self, at: u64) -> bool {
        let set = self.set;
        let due = |(task, job, _): Node| set.releases[task][job as usize] + set.tasks[task].deadline_ns;
        let tails: Vec<Vec<u64>> = set.tasks.iter().map(|task| task.graph.tails()).collect();
        while !self.waiting.is_empty() {
            let Some(lane) = (0..self.free.len()).min_by_key(|lane| self.free[*lane]) else { return false };
            let now = self.free[lane].max(at);
            let start = |node: &Node| self.ready(*node).map(|ready| ready.max(now));
            let key = |node: &Node| due(*node) - tails[node.0][node.2];
            let next = (0..self.waiting.len())
                .filter_map(|nth| Some((start(&self.waiting[nth])?, key(&self.waiting[nth]), nth)))
                .min();
            let Some((start, _, nth)) = next else { return false };
            let node = self.waiting.swap_remove(nth);
            let end = start + set.mean(node.0, node.2);
            if end > due(node) {
                return false;
            }
            self.end.insert(node, end);
            self.free[lane] = end;
        }
        true
    }
}
