//! What a run under overload is measured by.

use super::load::Set;
use crate::scoreboard::drive::Ends;

/// The most value that could be on time: jobs by what they are worth for their work, as many as fit the lanes' time from the
/// first release to the last deadline, the last one in part.
pub(super) fn bound(set: &Set) -> f64 {
    fitting(set, |task, job| set.work(task, job) as f64)
}

/// The same if every job of a task had the mean work of all of them: who does not know which take less cannot choose those.
pub(super) fn capacity(set: &Set) -> f64 {
    let mean = |task: usize| {
        let jobs = set.releases[task].len() as u64;
        (0..jobs).map(|job| set.work(task, job)).sum::<u64>() as f64 / jobs as f64
    };
    let means: Vec<f64> = (0..set.tasks.len()).map(mean).collect();
    fitting(set, |task, _| means[task])
}

fn fitting(set: &Set, work: impl Fn(usize, u64) -> f64) -> f64 {
    let release = |(task, job): (usize, u64)| set.releases[task][job as usize];
    let first = set.jobs().map(release).min().unwrap_or(0);
    let last = set.jobs().map(|job| release(job) + set.tasks[job.0].deadline_ns).max().unwrap_or(0);
    let mut left = (u64::from(set.lanes) * (last - first)) as f64;
    let mut jobs: Vec<(f64, f64)> =
        set.jobs().map(|(task, job)| (f64::from(set.values[task]), work(task, job))).collect();
    jobs.sort_by(|a, b| (b.0 / b.1).total_cmp(&(a.0 / a.1)));
    let mut sum = 0.0;
    for (value, work) in jobs {
        let share = (left / work).min(1.0);
        sum += share * value;
        left -= share * work;
    }
    sum
}

/// The value that was on time.
pub(super) fn value(set: &Set, ends: &Ends) -> f64 {
    let of = |(fates, value): (&Vec<_>, &u32)| on_time(fates) as f64 * f64::from(*value);
    ends.fates.iter().zip(&set.values).map(of).sum()
}

/// The least share of a task's jobs that were on time over the greatest; `None` where no job was.
pub(super) fn fairness(ends: &Ends) -> Option<f64> {
    let shares = || ends.fates.iter().map(|fates| on_time(fates) as f64 / fates.len().max(1) as f64);
    let greatest = shares().fold(0.0, f64::max);
    (greatest > 0.0).then(|| shares().fold(greatest, f64::min) / greatest)
}

/// The share of all windows of all floors that were kept; `None` where there is none.
pub(super) fn floors(set: &Set, ends: &Ends) -> Option<f64> {
    let (mut kept, mut all) = (0, 0);
    for (fates, floor) in ends.fates.iter().zip(&set.floors) {
        let Some((m, k)) = floor else { continue };
        let windows = || fates.windows(*k as usize);
        all += windows().count();
        kept += windows().filter(|window| on_time(window) >= *m as usize).count();
    }
    (all > 0).then(|| f64::from(kept as u32) / all as f64)
}

fn on_time(fates: &[crate::scoreboard::drive::Fate]) -> usize {
    fates.iter().filter(|fate| fate.on_time).count()
}

#[cfg(test)]
mod tests;
