//! What a timeline shows first: the most interesting time, not the whole.

use crate::model::Run;

/// So many deadlines: of the task that is looked at, else the longest.
const DEADLINES: u64 = 5;

/// From and until: around the worst miss, else the first edit, else the beginning.
pub(crate) fn window(run: &Run) -> (u64, u64) {
    let longest = run.tasks.iter().map(|task| task.deadline_ns).max().unwrap_or(0).max(1);
    let late = |miss: &&crate::model::Miss| {
        let job = run.job(miss.task, miss.job);
        job.map_or(0, |job| miss.until_ns.saturating_sub(job.deadline_ns))
    };
    let worst = run.misses.iter().max_by_key(late).and_then(|miss| {
        let job = run.job(miss.task, miss.job)?;
        let deadline_ns = run.tasks.get(miss.task).map_or(longest, |task| task.deadline_ns.max(1));
        Some((job.release_ns, miss.until_ns.max(job.deadline_ns), deadline_ns))
    });
    let edit = run.edits.first().map(|(at, _)| (*at, *at, longest));
    let (from, until, deadline_ns) = worst.or(edit).unwrap_or((0, 0, longest));
    let wanted = deadline_ns
        .saturating_mul(DEADLINES)
        .max((until - from).saturating_mul(4) / 3)
        .min(run.end_ns.max(1));
    let before = (wanted - (until - from).min(wanted)) / 2;
    let from = from.saturating_sub(before).min(run.end_ns.saturating_sub(wanted));
    (from, from + wanted)
}

#[cfg(test)]
mod tests;
