//! Schedulers of the literature for overload, in a simulator of their own: nodes keep their lanes, and no lane idles while a
//! job that its rule would run has a node ready.
//!
//! All are told what ours are told, and know the mean times from the beginning. A job whose longest path at best case leads
//! beyond its deadline is given up under each of them, and a given-up job's running nodes keep their lanes to their ends.

use super::load::Set;
use super::{d_over::DOver, robust::Robust};
use crate::scoreboard::drive::{Ends, Fate, Span};

/// A scheduler of the literature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Other {
    /// Highest value first.
    Value,
    /// Highest value for the work that is left first.
    Density,
    /// Robust EDF (Buttazzo and Stankovic: RED, a robust earliest deadline scheduling algorithm, 1993).
    Robust,
    /// D-over (Koren and Shasha: D-over, an optimal on-line scheduling algorithm for overloaded uniprocessor real-time
    /// systems, SIAM J. Comput. 1995).
    DOver,
}

/// A job in flight.
pub(super) struct Job {
    /// The how-manieth release of all: its name.
    pub(super) id: usize,
    /// When it is due, in nanoseconds.
    pub(super) deadline: u64,
    /// What it is worth.
    pub(super) value: f64,
    /// Work that is left over the lanes, or the longest path that is left where that is longer: mean times, in nanoseconds.
    pub(super) left: u64,
    /// Work that is left, so.
    pub(super) work: u64,
    /// The node that would start next takes so long in the mean, in nanoseconds; 0 where none is ready.
    pub(super) next: u64,
    task: usize,
    index: u64,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    waits_for: usize,
    state: State,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Waiting,
    Since(u64),
    Ended,
}

/// What happened since the last look.
pub(super) struct Look<'a> {
    /// When it is, in nanoseconds.
    pub(super) now: u64,
    /// Lanes, and those that are free.
    pub(super) lanes: u64,
    pub(super) free: usize,
    /// Of each node that has a lane: its job's name, and how long it takes from now on in the mean, in nanoseconds.
    pub(super) held: &'a [(usize, u64)],
    /// Names of the jobs that came.
    pub(super) came: &'a [usize],
    /// The jobs in flight, by name.
    pub(super) jobs: &'a [Job],
}

/// What a rule says.
#[derive(Default)]
pub(super) struct Answer {
    /// Names of the jobs that may have lanes, the first first.
    pub(super) order: Vec<usize>,
    /// Names of those that are given up.
    pub(super) given_up: Vec<usize>,
}

/// Decides who runs, each time something happened.
pub(super) trait Rule {
    fn look(&mut self, look: &Look<'_>) -> Answer;
}

/// Jobs by one number, the smallest first; of equals the first that is due.
struct Sorted(fn(&Job) -> f64);

impl Rule for Sorted {
    fn look(&mut self, look: &Look<'_>) -> Answer {
        let mut jobs: Vec<&Job> = look.jobs.iter().collect();
        jobs.sort_by(|a, b| {
            self.0(a).total_cmp(&self.0(b)).then((a.deadline, a.id).cmp(&(b.deadline, b.id)))
        });
        Answer { order: jobs.iter().map(|job| job.id).collect(), given_up: Vec::new() }
    }
}

/// Runs a set.
#[must_use]
pub(super) fn drive(set: &Set, other: Other) -> Ends {
    let mut rule: Box<dyn Rule> = match other {
        Other::Value => Box::new(Sorted(|job| -job.value)),
        Other::Density => Box::new(Sorted(|job| -job.value / job.work.max(1) as f64)),
        Other::Robust => Box::new(Robust::default()),
        Other::DOver => Box::new(DOver::of(set)),
    };
    let mut host = Host::of(set);
    host.run(&mut *rule);
    host.ends
}

/// A node that has a lane.
#[derive(Clone, Copy)]
struct Held {
    /// The job's name.
    id: usize,
    node: usize,
    /// When it would end if it took its mean time, and when it does, in nanoseconds.
    mean_end: u64,
    end: u64,
}

struct Host<'a> {
    set: &'a Set,
    /// Longest path after each node of each task, at WCET.
    tails: Vec<Vec<u64>>,
    /// Releases to come as (instant, task, number), the next last.
    coming: Vec<(u64, usize, u64)>,
    jobs: Vec<Job>,
    /// What runs on each lane.
    lanes: Vec<Option<Held>>,
    ends: Ends,
}

impl<'a> Host<'a> {
    fn of(set: &'a Set) -> Self {
        let mut coming: Vec<(u64, usize, u64)> =
            set.jobs().map(|(task, job)| (set.releases[task][job as usize], task, job)).collect();
        coming.sort_unstable_by(|a, b| b.cmp(a));
        let fates = set.releases.iter().map(|releases| vec![Fate::default(); releases.len()]).collect();
        let tails = set.tasks.iter().map(|task| task.graph.tails()).collect();
        let lanes = vec![None; set.lanes.into()];
        let ends = Ends { jobs: coming.len() as u64, fates, ..Ends::default() };
        Self { set, tails, coming, jobs: Vec::new(), lanes, ends }
    }

    fn run(&mut self, rule: &mut dyn Rule) {
        let mut names = 0..;
        loop {
            let end = self.lanes.iter().flatten().map(|held| held.end).min();
            let release = self.coming.last().map(|(at, ..)| *at);
            let Some(now) = [end, release].into_iter().flatten().min() else { break };
            self.complete(now);
            let mut came = Vec::new();
            while let Some((_, task, index)) = self.coming.pop_if(|(at, ..)| *at == now) {
                came.extend(names.next());
                self.jobs.push(self.released(came[came.len() - 1], task, index, now));
            }
            let is_lost = |job: &Job| now + self.path(job, now, self.set.times.best_percent()) > job.deadline;
            let lost: Vec<usize> = self.jobs.iter().filter(|job| is_lost(job)).map(|job| job.id).collect();
            self.give_up(&lost, now);
            self.measure(now);
            let free = self.lanes.iter().filter(|lane| lane.is_none()).count();
            let held: Vec<(usize, u64)> = self.held(now).collect();
            let lanes = self.set.lanes.into();
            let look = Look { now, lanes, free, held: &held, came: &came, jobs: &self.jobs };
            let answer = rule.look(&look);
            self.give_up(&answer.given_up, now);
            self.fill(&answer.order, now);
        }
        // Who was never let run.
        for job in self.jobs.drain(..) {
            self.ends.fates[job.task][job.index as usize] = Fate { on_time: false, at: job.deadline };
            self.ends.missed += 1;
        }
    }

    fn released(&self, id: usize, task: usize, index: u64, now: u64) -> Job {
        let of = &self.set.tasks[task];
        let mut nodes = vec![Node { waits_for: 0, state: State::Waiting }; of.graph.costs.len()];
        of.graph.successors.iter().flatten().for_each(|to| nodes[*to].waits_for += 1);
        let (deadline, value) = (now + of.deadline_ns, self.set.values[task].into());
        Job { id, deadline, value, left: 0, work: 0, next: 0, task, index, nodes }
    }

    fn complete(&mut self, now: u64) {
        for lane in &mut self.lanes {
            let Some(Held { id, node, .. }) = lane.take_if(|held| held.end == now) else { continue };
            // Its job may have been given up.
            let Some(at) = self.jobs.iter().position(|job| job.id == id) else { continue };
            let job = &mut self.jobs[at];
            job.nodes[node].state = State::Ended;
            for to in &self.set.tasks[job.task].graph.successors[node] {
                job.nodes[*to].waits_for -= 1;
            }
            if job.nodes.iter().all(|node| node.state == State::Ended) {
                let on_time = now <= job.deadline;
                self.ends.fates[job.task][job.index as usize] = Fate { on_time, at: now };
                self.ends.missed += u64::from(!on_time);
                self.ends.last_end = now;
                self.jobs.remove(at);
            }
        }
    }

    fn give_up(&mut self, ids: &[usize], now: u64) {
        for job in self.jobs.extract_if(.., |job| ids.contains(&job.id)) {
            self.ends.fates[job.task][job.index as usize] = Fate { on_time: false, at: now };
            self.ends.missed += 1;
        }
    }

    /// What is left of a node, in nanoseconds, at so many percent of its WCET.
    fn left(&self, job: &Job, node: usize, now: u64, percent: u64) -> u64 {
        let whole = self.set.tasks[job.task].graph.costs[node] * percent / 100;
        match job.nodes[node].state {
            State::Waiting => whole,
            State::Since(start) => whole.saturating_sub(now - start),
            State::Ended => 0,
        }
    }

    /// The longest path that is left.
    fn path(&self, job: &Job, now: u64, percent: u64) -> u64 {
        let nodes = (0..job.nodes.len()).filter(|node| job.nodes[*node].state != State::Ended);
        let from = nodes.map(|n| self.left(job, n, now, percent) + self.tails[job.task][n] * percent / 100);
        from.max().unwrap_or(0)
    }

    /// What rules go by.
    fn measure(&mut self, now: u64) {
        let percent = self.set.times.mean_percent();
        for at in 0..self.jobs.len() {
            let job = &self.jobs[at];
            let work: u64 = (0..job.nodes.len()).map(|node| self.left(job, node, now, percent)).sum();
            let left = self.path(job, now, percent).max(work.div_ceil(self.set.lanes.into()));
            let next = self.ready(job).map_or(0, |node| self.set.mean(job.task, node));
            let job = &mut self.jobs[at];
            (job.work, job.left, job.next) = (work, left, next);
        }
    }

    fn held(&self, now: u64) -> impl Iterator<Item = (usize, u64)> + '_ {
        self.lanes.iter().flatten().map(move |held| (held.id, held.mean_end.saturating_sub(now)))
    }

    /// Of a job's ready nodes the one with the longest path from it on.
    fn ready(&self, job: &Job) -> Option<usize> {
        let is_ready = |node: &usize| {
            let Node { waits_for, state } = job.nodes[*node];
            waits_for == 0 && state == State::Waiting
        };
        let costs = &self.set.tasks[job.task].graph.costs;
        let path = |node: &usize| (self.tails[job.task][*node] + costs[*node], usize::MAX - node);
        (0..job.nodes.len()).filter(is_ready).max_by_key(path)
    }

    fn fill(&mut self, order: &[usize], now: u64) {
        let mut free: Vec<usize> =
            (0..self.lanes.len()).rev().filter(|lane| self.lanes[*lane].is_none()).collect();
        for id in order {
            let Some(at) = self.jobs.iter().position(|job| job.id == *id) else { continue };
            while !free.is_empty() {
                let Some(node) = self.ready(&self.jobs[at]) else { break };
                let Job { task, index: job, .. } = self.jobs[at];
                let end = now + self.set.time(task, job, node).max(1);
                self.jobs[at].nodes[node].state = State::Since(now);
                self.ends.spans.push(Span { task, job, node, start: now, end });
                if let Some(lane) = free.pop() {
                    let mean_end = now + self.set.mean(task, node);
                    self.lanes[lane] = Some(Held { id: *id, node, mean_end, end });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
