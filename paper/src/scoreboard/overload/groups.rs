//! Protected groups: tasks that nobody below them may cost anything, and whether they stay whole.
//!
//! *Rule.* A group is the tasks from some value up, where there are others below. It is protected if it is all on time when it
//! is alone, by the keys of `redrt` without any rule for overload, with deadlines that are shorter by the longest node of the others: that long may somebody who holds
//! a lane keep it. It is whole if 99 % of the jobs of each of its tasks are on time among the others.
//!
//! *Blocked.* A group that breaks is blocked if its first job that was not on time met a node of a lower value on a lane, and
//! each such node had started while the group could wait.

use super::blocking;
use super::load::Set;
use super::rules;
use crate::scoreboard::drive::Ends;

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
    if is_whole(group, ends) {
        Group::Whole
    } else if blocking::is_blocked(&blocking::met(set, group, ends)) {
        Group::Blocked
    } else {
        Group::Broken
    }
}

/// The share of jobs on time of the task of a group that has the least.
pub(super) fn least_on_time(group: &[usize], ends: &Ends) -> f64 {
    let share = |task: &usize| {
        let fates = &ends.fates[*task];
        let on_time = fates.iter().filter(|fate| fate.on_time).count();
        if fates.is_empty() { 1.0 } else { on_time as f64 / fates.len() as f64 }
    };
    group.iter().map(share).fold(1.0, f64::min)
}

/// Whether it stayed whole.
pub(super) fn is_whole(group: &[usize], ends: &Ends) -> bool {
    least_on_time(group, ends) >= WHOLE_PERCENT as f64 / 100.0
}

#[cfg(test)]
mod tests;
