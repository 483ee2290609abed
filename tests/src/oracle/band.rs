//! Bands of the jobs in flight: ranks before keys while there is pressure (8.10).

use std::cmp::Reverse;

use super::Sim;
use super::job::Job;

/// What goes before keys, the lowest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Band {
    /// Of all jobs without pressure, and of a new one until the next look.
    Lowest,
    /// In time, owed, value.
    Ranked(bool, bool, u32),
    /// In time, and owed or of a value above the level; all where there is only one task.
    Highest,
}

/// A band, and where jobs of one go by deadline, that: the earlier one is above.
pub(super) type Place = (Band, Reverse<i128>);

/// Below every other.
pub(super) const NEW: Place = (Band::Lowest, Reverse(i128::MAX));

impl Sim<'_> {
    /// What each look begins with: whether there is pressure, and the band of each job in flight.
    pub(super) fn give_bands(&mut self, now: u64) {
        for job in &mut self.jobs {
            job.band = NEW;
        }
        let all: Vec<usize> = (0..self.jobs.len()).collect();
        let fates = self.forward(&all, now);
        let relative = |job: &Job| job.due - i128::from(job.release);
        let late = fates.iter().filter(|fate| self.is_late(fate)).map(|fate| relative(&self.jobs[fate.job]));
        if let Some(longest_late) = late.max() {
            let longest = self.jobs.iter().map(relative).max().unwrap_or(0);
            let time = (2 * longest).min(16 * longest_late);
            self.pressure_until = self.pressure_until.max(i128::from(now) + time);
        }
        self.pressed = i128::from(now) < self.pressure_until;
        if self.pressed {
            let level = self.level();
            let bands: Vec<Band> = self.jobs.iter().map(|job| self.band(job, level, now)).collect();
            for (job, band) in self.jobs.iter_mut().zip(bands) {
                job.band.0 = band;
            }
            self.go_by_deadline(&all, now);
        }
    }

    /// Orders jobs of a band by deadline, where all are of one value and only so nobody is late.
    fn go_by_deadline(&mut self, all: &[usize], now: u64) {
        let value = |job: &Job| self.workload.tasks[job.task].value;
        let one_value = self.jobs.iter().all(|job| value(job) == value(&self.jobs[0]));
        let is_anybody_late = |sim: &Self| sim.forward(all, now).iter().any(|fate| sim.is_late(fate));
        if !one_value || !is_anybody_late(self) {
            return;
        }
        self.jobs.iter_mut().for_each(|job| job.band.1 = Reverse(job.due));
        if is_anybody_late(self) {
            self.jobs.iter_mut().for_each(|job| job.band.1 = NEW.1);
        }
    }

    /// The largest value of a task with a job in flight that lost one of its last jobs; nothing is below all values.
    fn level(&self) -> Option<u32> {
        let losing = self.jobs.iter().map(|job| job.task).filter(|&task| self.recently_lost(task, &[]) > 0);
        losing.map(|task| self.workload.tasks[task].value).max()
    }

    fn band(&self, job: &Job, level: Option<u32>, now: u64) -> Band {
        let (in_time, _, value, _) = self.rank(job, &[], now);
        let owed = self.is_owed(job);
        let one_task = self.jobs.iter().all(|other| other.task == job.task);
        if one_task || in_time && (owed || Some(value) > level) {
            Band::Highest
        } else {
            Band::Ranked(in_time, owed, value)
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
