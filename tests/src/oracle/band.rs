//! Bands of the jobs in flight: ranks before keys while there is pressure (8.10).

use std::cmp::Reverse;
use std::collections::BTreeSet;

use super::Sim;
use super::job::Job;

/// What goes before keys, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Band {
    /// Late and to stay, until the next look.
    Last,
    /// Of all jobs without pressure, and of a new one until the next look.
    Lowest,
    /// In time, owed, value.
    Ranked(bool, bool, u32, u64),
    /// In time, and owed or of a value above the level; all where there is only one task.
    Highest,
}

/// A band, and where jobs of one go by deadline, that: the earlier one is above.
pub(super) type Place = (Band, Reverse<i128>);

/// Below every other.
pub(super) const NEW: Place = (Band::Lowest, Reverse(i128::MAX));

/// Behind all others.
pub(super) const LAST: Place = (Band::Last, NEW.1);

impl Sim<'_> {
    /// What each look begins with: where there is pressure, and the band of each job in flight.
    pub(super) fn give_bands(&mut self, now: u64) {
        for job in &mut self.jobs {
            job.band = NEW;
        }
        let time = |&at: &usize| self.jobs[at].due - i128::from(self.jobs[at].release);
        let late = self.late_ones(now);
        let mut until = self.pressure_until.clone();
        for (pools, tied) in self.ties(&late) {
            let longest = tied.iter().map(time).max().unwrap_or(0);
            let longest_late = late.iter().filter(|at| tied.contains(at)).map(time).max().unwrap_or(0);
            let end = i128::from(now) + (4 * longest).min(16 * longest_late);
            pools.into_iter().for_each(|pool| until[pool] = until[pool].max(end));
        }
        self.pressed = until.iter().map(|&until| i128::from(now) < until).collect();
        self.pressure_until = until;
        let under: Vec<usize> =
            (0..self.jobs.len()).filter(|&at| self.jobs[at].pools().any(|pool| self.pressed[pool])).collect();
        for (_, tied) in self.ties(&under) {
            let level = self.level(&tied);
            for &at in &tied {
                self.jobs[at].band.0 = self.band(at, &tied, level, now);
            }
        }
        self.go_by_deadline(now);
    }

    /// Positions of the jobs that would be late.
    fn late_ones(&self, now: u64) -> Vec<usize> {
        let all: Vec<usize> = (0..self.jobs.len()).collect();
        let fates = self.forward(&all, now);
        fates.iter().filter(|fate| self.is_late(fate)).map(|fate| fate.job).collect()
    }

    /// Pools, and all jobs in flight that need any of them: those that hang together with these jobs.
    fn ties(&self, jobs: &[usize]) -> Vec<(BTreeSet<usize>, Vec<usize>)> {
        let mut ties: Vec<(BTreeSet<usize>, Vec<usize>)> = Vec::new();
        for &first in jobs {
            if ties.iter().any(|(_, tied)| tied.contains(&first)) {
                continue;
            }
            let mut pools: BTreeSet<usize> = self.jobs[first].pools().collect();
            for _ in 0..self.workload.pools.len() {
                for job in &self.jobs {
                    if job.pools().any(|pool| pools.contains(&pool)) {
                        pools.extend(job.pools());
                    }
                }
            }
            let needs = |at: &usize| self.jobs[*at].pools().any(|pool| pools.contains(&pool));
            let tied = (0..self.jobs.len()).filter(needs).collect();
            ties.push((pools, tied));
        }
        ties
    }

    /// Orders jobs of a band by deadline, where those that are tied to a late one are of one value, and only so none of them is late.
    fn go_by_deadline(&mut self, now: u64) {
        let late = self.late_ones(now);
        let value = |at: usize| self.workload.tasks[self.jobs[at].task].value;
        let alike = |tied: &Vec<usize>| tied.iter().all(|&at| value(at) == value(tied[0]));
        let all: Vec<usize> =
            self.ties(&late).into_iter().map(|(_, tied)| tied).filter(alike).flatten().collect();
        for &at in &all {
            self.jobs[at].band.1 = Reverse(self.jobs[at].due);
        }
        if self.late_ones(now).iter().any(|at| all.contains(at)) {
            all.iter().for_each(|&at| self.jobs[at].band.1 = NEW.1);
        }
    }

    /// The largest value of a task with one of these jobs that lost several of its last jobs; nothing is below all values.
    fn level(&self, tied: &[usize]) -> Option<u32> {
        let losing =
            tied.iter().map(|&at| self.jobs[at].task).filter(|&task| self.recently_lost(task, &[]) >= 4);
        losing.map(|task| self.workload.tasks[task].value).max()
    }

    fn band(&self, at: usize, tied: &[usize], level: Option<u32>, now: u64) -> Band {
        let job = &self.jobs[at];
        let (in_time, _, value, probe) = self.rank(job, &[], now);
        let owed = self.is_owed(job);
        let one_task = tied.iter().all(|&other| self.jobs[other].task == job.task);
        if one_task || in_time && (owed || Some(value) > level) {
            Band::Highest
        } else {
            Band::Ranked(in_time, owed, value, probe)
        }
    }

    /// Whether the floor needs the job, or another one of its task where the job has started.
    fn is_owed(&self, job: &Job) -> bool {
        let mut own = self.jobs.iter().filter(|other| other.task == job.task);
        self.floor_needs(job, &[]) || job.started && own.any(|other| self.floor_needs(other, &[]))
    }
}

#[cfg(test)]
mod tests;
