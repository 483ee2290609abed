//! The forward schedule: what happens to some jobs from now on if nothing else comes (8.4).

use super::Sim;
use super::dispatch::{Order, order};
use super::job::{FrameKey, Job, State};
use crate::graph::Role;

/// What the forward schedule makes of one job.
pub(super) struct Fate {
    /// Position among the jobs in flight.
    pub(super) job: usize,
    /// When the job ends; the largest instant if it never does.
    pub(super) end: i128,
    /// When a node of it takes a lane for the first time from now on.
    pub(super) first_start: Option<i128>,
    /// The pools in which nodes of it take lanes from now on.
    pub(super) pools: Vec<usize>,
}

impl Fate {
    /// Whether both jobs take lanes of one pool.
    pub(super) fn meets(&self, other: &Self) -> bool {
        self.pools.iter().any(|pool| other.pools.contains(pool))
    }
}

/// A job on its way. A node that neither waits nor is done runs.
struct Ahead<'a> {
    job: &'a Job,
    waits: Vec<bool>,
    done: Vec<bool>,
    fate: Fate,
}

impl Ahead<'_> {
    fn is_ready(&self, node: usize) -> bool {
        self.waits[node] && self.job.graph.nodes[node].preds.iter().all(|&pred| self.done[pred])
    }

    /// The frame of an encoder.
    fn key(&self, node: usize) -> Option<&FrameKey> {
        self.job.frames[node].as_ref().filter(|_| self.job.graph.nodes[node].role == Role::Encoder)
    }
}

/// A lane that is taken.
struct Busy {
    pool: usize,
    until: i128,
    /// Set where it computes a frame.
    key: Option<FrameKey>,
    /// Position in the group, and node.
    members: Vec<(usize, usize)>,
}

struct Forward<'a> {
    /// How many lanes each pool has.
    lanes: Vec<usize>,
    group: Vec<Ahead<'a>>,
    busy: Vec<Busy>,
    /// Frames whose results are there.
    kept: Vec<FrameKey>,
    /// Positions among the jobs in flight: they start nothing before the others that need one of their pools have ended.
    behind: Vec<usize>,
}

impl Sim<'_> {
    /// The forward schedule of the jobs at these positions, in their order.
    pub(super) fn forward(&self, group: &[usize], now: u64) -> Vec<Fate> {
        self.forward_behind(group, &[], now)
    }

    /// The same where some go behind the others.
    pub(super) fn forward_behind(&self, group: &[usize], behind: &[usize], now: u64) -> Vec<Fate> {
        let ahead = |&position: &usize| {
            let job = &self.jobs[position];
            Ahead {
                job,
                waits: job.state.iter().map(|&state| state == State::Waiting).collect(),
                done: job.state.iter().map(|&state| state == State::Done).collect(),
                fate: Fate { job: position, end: i128::MAX, first_start: None, pools: Vec::new() },
            }
        };
        let in_group = |task: usize, index: u64| {
            group.iter().position(|&at| (self.jobs[at].task, self.jobs[at].index) == (task, index))
        };
        let busy = self.running.iter().map(|unit| Busy {
            pool: unit.pool,
            until: i128::from(unit.finish),
            key: unit.key.clone(),
            members: unit.members.iter().filter_map(|&(t, i, node)| Some((in_group(t, i)?, node))).collect(),
        });
        let mut forward = Forward {
            lanes: self.workload.pools.iter().map(|pool| pool.lanes as usize).collect(),
            group: group.iter().map(ahead).collect(),
            busy: busy.collect(),
            kept: self.cached.iter().map(|output| output.key.clone()).collect(),
            behind: behind.to_vec(),
        };
        forward.run(i128::from(now));
        forward.group.into_iter().map(|ahead| ahead.fate).collect()
    }
}

impl Forward<'_> {
    /// From instant to instant until nothing runs any more. What takes no time makes another round of its instant.
    fn run(&mut self, now: i128) {
        let mut next = Some(now);
        while let Some(now) = next {
            self.end_units(now);
            self.hit();
            self.end_jobs(now);
            self.fill(now);
            next = self.busy.iter().map(|busy| busy.until).min();
        }
    }

    fn end_units(&mut self, now: i128) {
        for ended in self.busy.extract_if(.., |busy| busy.until == now) {
            for (at, node) in ended.members {
                self.group[at].done[node] = true;
            }
            self.kept.extend(ended.key);
        }
    }

    /// Every ready encoder whose result is there is done, and so on for what that readies.
    fn hit(&mut self) {
        while let Some((at, node)) = self.next_hit() {
            self.group[at].waits[node] = false;
            self.group[at].done[node] = true;
        }
    }

    fn next_hit(&self) -> Option<(usize, usize)> {
        let hits = |&(at, node): &(usize, usize)| {
            let ahead: &Ahead<'_> = &self.group[at];
            ahead.is_ready(node) && ahead.key(node).is_some_and(|key| self.kept.contains(key))
        };
        self.nodes().find(hits)
    }

    fn end_jobs(&mut self, now: i128) {
        let complete = |ahead: &&mut Ahead<'_>| ahead.done.iter().all(|&done| done);
        for ahead in self.group.iter_mut().filter(complete) {
            ahead.fate.end = ahead.fate.end.min(now);
        }
    }

    /// Fills the free lanes of each pool. What becomes ready by that does so in another round.
    fn fill(&mut self, now: i128) {
        for pool in 0..self.lanes.len() {
            let mut queue: Vec<(Order, usize, usize)> = Vec::new();
            for (at, node) in self.nodes() {
                let ahead = &self.group[at];
                if ahead.job.graph.nodes[node].pool == pool && ahead.is_ready(node) && !self.is_held(at) {
                    queue.push((order(ahead.job, node), at, node));
                }
            }
            queue.sort_unstable();
            for (_, at, node) in queue {
                let taken = self.busy.iter().filter(|busy| busy.pool == pool).count();
                if taken < self.lanes[pool] && !self.waits_for_key(at, node) {
                    self.start(at, node, now);
                }
            }
        }
    }

    fn is_held(&self, at: usize) -> bool {
        let goes_behind = |ahead: &Ahead<'_>| self.behind.contains(&ahead.fate.job);
        let comes_first = |other: &Ahead<'_>| {
            let mut pools = other.job.pools();
            let is_met = pools.any(|pool| self.group[at].job.pools().any(|own| own == pool));
            !goes_behind(other) && other.fate.end == i128::MAX && is_met
        };
        goes_behind(&self.group[at]) && self.group.iter().any(comes_first)
    }

    fn waits_for_key(&self, at: usize, node: usize) -> bool {
        self.group[at]
            .key(node)
            .is_some_and(|key| self.busy.iter().any(|busy| busy.key.as_ref() == Some(key)))
    }

    fn start(&mut self, at: usize, node: usize, now: i128) {
        let ahead = &mut self.group[at];
        let sub = &ahead.job.graph.nodes[node];
        ahead.waits[node] = false;
        ahead.fate.first_start.get_or_insert(now);
        ahead.fate.pools.push(sub.pool);
        let (pool, until) = (sub.pool, now + i128::from(sub.wcet_ns));
        self.busy.push(Busy { pool, until, key: ahead.key(node).cloned(), members: vec![(at, node)] });
    }

    /// Every node of the group.
    fn nodes(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let of = |(at, ahead): (usize, &Ahead<'_>)| (0..ahead.waits.len()).map(move |node| (at, node));
        self.group.iter().enumerate().flat_map(of)
    }
}

#[cfg(test)]
mod tests;
