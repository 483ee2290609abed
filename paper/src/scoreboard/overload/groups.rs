//! Protected groups: tasks that nobody below them may cost anything, and whether they stay whole.
//!
//! *Rule.* A group is the tasks from some value up, where there are others below. It is protected if it is all on time when it
//! is alone, by the keys of `redrt` without any rule for overload, with deadlines that are shorter by the longest node of the others: that long may somebody who holds
//! a lane keep it. It is whole if 99 % of the jobs of each of its tasks are on time among the others.
//!
//! *Blocked.* A group that breaks is blocked if its first job that was not on time met a node of a lower value on a lane, and
//! each such node had started while no node of the group was ready: the lane was given before anybody knew.

use super::load::Set;
use super::rules;
use crate::scoreboard::drive::{Ends, Span};

/// Share of a task's jobs that is enough, in percent.
pub(super) const WHOLE_PERCENT: u64 = 99;

/// What became of a group.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Stayed whole.
    Whole,
    /// Broke, by blocking.
    Blocked,
    /// Broke.
    Broken,
}

/// The protected groups of a set, each as the numbers of its tasks.
pub(super) fn protected(set: &Set) -> Option<Vec<Vec<usize>>> {
    let mut values = set.values.clone();
    values.sort_unstable();
    values.dedup();
    let mut groups = Vec::new();
    for least in values.into_iter().skip(1) {
        let all = 0..set.tasks.len();
        let (group, others): (Vec<usize>, Vec<usize>) = all.partition(|task| set.values[*task] >= least);
        let longest = others.iter().flat_map(|task| &set.tasks[*task].graph.costs).max().copied();
        let Some(alone) = set.part(&group, longest.unwrap_or(0)) else { continue };
        if rules::by_keys(&alone)?.missed == 0 {
            groups.push(group);
        }
    }
    Some(groups)
}

/// What became of a group in a run of its set.
pub(super) fn fate(set: &Set, group: &[usize], ends: &Ends) -> Group {
    let is_whole = |task: &usize| {
        let fates = &ends.fates[*task];
        let on_time = fates.iter().filter(|fate| fate.on_time).count() as u64;
        100 * on_time >= WHOLE_PERCENT * fates.len() as u64
    };
    if group.iter().all(is_whole) {
        Group::Whole
    } else if is_blocked(set, group, ends) {
        Group::Blocked
    } else {
        Group::Broken
    }
}

fn is_blocked(set: &Set, group: &[usize], ends: &Ends) -> bool {
    let late =
        set.jobs().filter(|(task, job)| group.contains(task) && !ends.fates[*task][*job as usize].on_time);
    let first = late.map(|(task, job)| (set.releases[task][job as usize], task, job)).min();
    let Some((release, task, job)) = first else { return false };
    let until = ends.fates[task][job as usize].at.min(release + set.tasks[task].deadline_ns);
    let mut met = ends
        .spans
        .iter()
        .filter(|span| !group.contains(&span.task) && span.start < until && span.end > release);
    let mut is_blocked = false;
    let are_innocent = met.all(|span| {
        is_blocked = true;
        !is_ready(set, group, ends, span.start)
    });
    is_blocked && are_innocent
}

/// Whether a node of a group was ready at an instant, and got no lane then.
fn is_ready(set: &Set, group: &[usize], ends: &Ends, at: u64) -> bool {
    let in_flight = set.jobs().filter(|(task, job)| {
        let (release, fate) = (set.releases[*task][*job as usize], ends.fates[*task][*job as usize]);
        group.contains(task) && release <= at && fate.at > at
    });
    in_flight.into_iter().any(|(task, job)| {
        // Spans are in the order of starts.
        let until = |instant: u64, is_in: bool| {
            ends.spans.partition_point(|span| span.start < instant || is_in && span.start == instant)
        };
        let started = &ends.spans[until(set.releases[task][job as usize], false)..until(at, true)];
        let spans: Vec<&Span> = started.iter().filter(|span| (span.task, span.job) == (task, job)).collect();
        let graph = &set.tasks[task].graph;
        let has_ended = |node: usize| spans.iter().any(|span| span.node == node && span.end <= at);
        let is_free = |node: usize| {
            let before = (0..graph.costs.len()).filter(|from| graph.successors[*from].contains(&node));
            before.into_iter().all(has_ended)
        };
        let has_started = |node: usize| spans.iter().any(|span| span.node == node);
        (0..graph.costs.len()).any(|node| !has_started(node) && is_free(node))
    })
}

#[cfg(test)]
mod tests;
