//! Bands of the jobs in flight: ranks before keys while there is pressure (8.10).

use std::cmp::Reverse;
use std::collections::BTreeSet;

use super::Sim;
use super::job::Job;
use super::rank::Name;

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

/// A band; where jobs of one go by deadline, that, the earlier one is above; where floors ask for that, before it whether a floor needs the
/// job, and behind it the band by rank.
pub(super) type Place = (Band, bool, Reverse<i128>, Band);

/// Below every other.
pub(super) const NEW: Place = in_band(Band::Lowest);

/// Behind all others.
pub(super) const LAST: Place = in_band(Band::Last);

const fn in_band(band: Band) -> Place {
    (band, false, Reverse(i128::MAX), Band::Last)
}

impl Sim<'_> {
    /// What each look begins with: where there is pressure, and the band of each job in flight. Jobs that count as lost from then on.
    pub(super) fn give_bands(&mut self, now: u64) -> Vec<Name> {
        for job in &mut self.jobs {
            job.band = NEW;
        }
        let time = |&at: &usize| self.jobs[at].due - i128::from(self.jobs[at].release);
        let all: Vec<usize> = (0..self.jobs.len()).collect();
        let late = self.late_ones(&all, &[], now);
        let mut until = self.pressure_until.clone();
        for (pools, tied) in self.ties(&late) {
            let longest = tied.iter().map(time).max().unwrap_or(0);
            let longest_late = late.iter().filter(|at| tied.contains(at)).map(time).max().unwrap_or(0);
            let end = i128::from(now) + (4 * longest).min(16 * longest_late);
            pools.into_iter().for_each(|pool| until[pool] = until[pool].max(end));
        }
        self.pressed = until.iter().map(|&until| i128::from(now) < until).collect();
        self.pressure_until = until;
        let lost = self.lost_anyway(&late, now);
        self.order(&all, &[], &lost, now);
        lost
    }

    /// Gives each job in flight its band, where jobs of these names are lost; by deadline, if that has those of a group in time that could be
    /// whole, some of them behind all others.
    pub(super) fn order(&mut self, group: &[usize], behind: &[usize], lost: &[Name], now: u64) {
        let under: Vec<usize> =
            (0..self.jobs.len()).filter(|&at| self.jobs[at].pools().any(|pool| self.pressed[pool])).collect();
        for (_, tied) in self.ties(&under) {
            let level = self.level(&tied);
            for &at in &tied {
                self.jobs[at].band = in_band(self.band(at, &tied, level, lost, now));
            }
        }
        self.go_by_deadline(group, behind, now);
    }

    /// Positions of the jobs of a group that would be late, some of them behind all others.
    fn late_ones(&self, group: &[usize], behind: &[usize], now: u64) -> Vec<usize> {
        let fates = self.forward_behind(group, behind, now);
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

    /// Orders jobs that are tied to a late one by band and deadline, and by deadline alone from the lowest band on of a late one whose task
    /// could be whole; where so none of such tasks is late there. Where no late one is of such a task, tasks with a floor take their place:
    /// those that the floor needs first, and only where nobody is late who was not. Where there is no such one either, where none is late.
    fn go_by_deadline(&mut self, group: &[usize], behind: &[usize], now: u64) {
        let late = self.late_ones(group, behind, now);
        let mut ties = Vec::new();
        for (_, tied) in self.ties(&late) {
            let before: Vec<Place> = tied.iter().map(|&at| self.jobs[at].band).collect();
            let of_task = |is: &dyn Fn(usize) -> bool| -> Vec<usize> {
                tied.iter().copied().filter(|&at| is(self.jobs[at].task)).collect()
            };
            let whole = of_task(&|task| self.could_be_whole(task, now));
            let by_floor = !whole.iter().any(|at| late.contains(at));
            let main = if by_floor { of_task(&|task| self.has_floor(task)) } else { whole };
            let first = main.iter().filter(|at| late.contains(at)).map(|&at| self.jobs[at].band.0).min();
            let is_above = |at: usize| first.is_some_and(|first| first <= self.jobs[at].band.0);
            let above: Vec<usize> = tied.iter().copied().filter(|&at| is_above(at)).collect();
            let owed: Vec<bool> =
                tied.iter().map(|&at| by_floor && self.floor_needs(&self.jobs[at], &[])).collect();
            for (&at, owed) in tied.iter().zip(owed) {
                let (band, due) = (self.jobs[at].band.0, Reverse(self.jobs[at].due));
                self.jobs[at].band = match (above.contains(&at), by_floor) {
                    (false, _) => (band, false, due, Band::Last),
                    (true, false) => (Band::Highest, false, due, Band::Last),
                    (true, true) => (Band::Highest, owed, due, band),
                };
            }
            let is_needed = |at: &usize| main.contains(at) || by_floor && !late.contains(at);
            let needed = match first {
                Some(_) => above.into_iter().filter(is_needed).collect(),
                None => tied.clone(),
            };
            ties.push((tied, needed, before));
        }
        let late = self.late_ones(group, behind, now);
        for (tied, needed, before) in ties {
            if late.iter().any(|at| needed.contains(at)) {
                tied.iter().zip(before).for_each(|(&at, band)| self.jobs[at].band = band);
            }
        }
    }

    /// The largest value of a task with one of these jobs that lost several of its last jobs; nothing is below all values.
    fn level(&self, tied: &[usize]) -> Option<u32> {
        let losing =
            tied.iter().map(|&at| self.jobs[at].task).filter(|&task| self.recently_lost(task, &[]) >= 4);
        losing.map(|task| self.workload.tasks[task].value).max()
    }

    /// Whether the task and what counts before it ask for no more millionths of lanes than each pool that it needs has, and fewer nodes of
    /// those of these that need each job than it has lanes take longer than the task can wait. Before it is all of whom is worth as much or more,
    /// and of others what floors need, of those that have a job in flight or whose next one is no later than by an eighth of its period. One
    /// without a period counts as if one came each relative deadline.
    fn could_be_whole(&self, task: usize, now: u64) -> bool {
        let tasks = &self.workload.tasks;
        let is_there = |of: usize| {
            let is_soon = |period: u64| {
                self.expected_release(of).is_some_and(|(at, _)| now < at.saturating_add(period / 8))
            };
            self.jobs.iter().any(|job| job.task == of) || self.gap(of).is_some_and(is_soon)
        };
        let before = |of: usize| match tasks[of].floor {
            _ if !is_there(of) => (0, 1),
            _ if tasks[of].value >= tasks[task].value => (1, 1),
            floor => floor.unwrap_or((0, 1)),
        };
        let times = |of: usize, pool: usize| {
            let nodes = self.tasks[of].graph.nodes.iter().filter(move |node| node.pool == pool);
            nodes.map(|node| i128::from(node.wcet_ns))
        };
        let asks = |of: usize, pool: usize| {
            let (some, k) = before(of);
            let asked = times(of, pool).sum::<i128>() * i128::from(some) * 1_000_000;
            asked / (i128::from(self.gap(of).unwrap_or(tasks[of].deadline_ns)) * i128::from(k))
        };
        let graph = &self.tasks[task].graph;
        let slack = self.slack(task, graph);
        let fits = |pool: usize| {
            let lanes = i128::from(self.workload.pools[pool].lanes);
            let asked: i128 = (0..tasks.len()).map(|of| asks(of, pool)).sum();
            let others = (0..tasks.len()).filter(|&of| of != task && before(of).0 == before(of).1);
            let long = others.flat_map(|of| times(of, pool)).filter(|&time| time > slack).count();
            asked <= 1_000_000 * lanes && (long as i128) < lanes
        };
        graph.nodes.iter().all(|node| fits(node.pool))
    }

    fn band(&self, at: usize, tied: &[usize], level: Option<u32>, lost: &[Name], now: u64) -> Band {
        let job = &self.jobs[at];
        let (in_time, _, value, probe) = self.rank(job, &[], now);
        let owed = self.is_owed(job, lost);
        let one_task = tied.iter().all(|&other| self.jobs[other].task == job.task);
        if one_task || in_time && (owed || Some(value) > level) {
            Band::Highest
        } else {
            Band::Ranked(in_time, owed, value, probe)
        }
    }

    /// Whether the floor needs the job, or another one of its task where the job has started.
    fn is_owed(&self, job: &Job, lost: &[Name]) -> bool {
        let mut own = self.jobs.iter().filter(|other| other.task == job.task);
        self.floor_needs(job, lost) || job.started && own.any(|other| self.floor_needs(other, lost))
    }
}

#[cfg(test)]
mod tests;
