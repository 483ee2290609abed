//! Dispatch keys: at release by each policy's rule, and by the level rule over what remains of a job.

use super::Policy;
use super::job::{Job, State};
use crate::graph::Graph;
use crate::plan::{level_offsets, level_sums, portion};

/// Keys of a job released at `now`, on the time axis.
pub(super) fn at_release(policy: Policy, graph: &Graph, now: u64, deadline: u64) -> Vec<i128> {
    let costs = graph.costs();
    let absolute = |relative: u64| i128::from(now) + i128::from(relative);
    match policy {
        Policy::Edf => vec![absolute(deadline); costs.len()],
        Policy::RedFg | Policy::RedIda | Policy::Red => {
            let heights = graph.heights(|_| true);
            let due = level_offsets(&level_sums(&heights, &costs), deadline);
            heights.iter().map(|&height| absolute(due[height])).collect()
        }
        Policy::Redrt | Policy::RedrtLookahead => {
            let tails = graph.tails(&costs);
            let key = |v: usize| absolute(deadline) - i128::from(tails[v]) - i128::from(costs[v]);
            (0..costs.len()).map(key).collect()
        }
    }
}

/// Re-assigns the level shares of what remains of `job`, anchored at `now`: done nodes are gone, a running
/// node counts what is left of it and keeps its key.
///
/// Every execution takes the WCET, so the mean of past executions plus contention is the cost c'.
pub(super) fn reassign(job: &mut Job, now: u64) {
    let remains: Vec<usize> = (0..job.state.len()).filter(|&v| job.state[v] != State::Done).collect();
    let heights = job.graph.heights(|v| job.state[v] != State::Done);
    let left = |v: usize| match job.state[v] {
        State::Running(start) => job.graph.nodes[v].cost_ns.saturating_sub(now - start).max(1),
        State::Waiting | State::Done => job.graph.nodes[v].cost_ns,
    };
    let levels: Vec<usize> = remains.iter().map(|&v| heights[v]).collect();
    let sums = level_sums(&levels, &remains.iter().map(|&v| left(v)).collect::<Vec<_>>());
    let whole: u64 = sums.iter().sum();
    let key = |height: usize| {
        if i128::from(now) >= job.due {
            return job.due;
        }
        let budget = u64::try_from(job.due - i128::from(now)).expect("positive, and not above a deadline");
        let up_to: u64 = sums[..=height].iter().sum();
        portion(budget, up_to, whole).map_or(job.due, |share| i128::from(now) + i128::from(share))
    };
    let keys: Vec<(usize, i128)> = remains.iter().map(|&v| (v, key(heights[v]))).collect();
    for (v, key) in keys {
        if job.state[v] == State::Waiting {
            job.keys[v] = key;
        }
    }
}

#[cfg(test)]
mod tests;
