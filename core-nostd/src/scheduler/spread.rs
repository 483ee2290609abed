//! A job alone on its pools: how many lanes of one it needs, from when and until when, and how much memory.
//!
//! *Rule.* The first ready node by rank goes on a lane of its pool as soon as one is free and there is memory, of several lanes on the one
//! that was busy last. Results of encoders are kept. Of the pool that is asked for, a job takes as few lanes as end it by its deadline; all,
//! if no number does. One in flight goes on from where it is: a lane counts from the end of what the job runs there.

use super::outlook::{Case, before_start};
use super::{Scheduler, bits, coming::signed, tasks::Task, version::Version};
use crate::capacity::{Capacity, Empty};
use crate::deadlines::Estimator;
use crate::graph::{Node, NodeSet};

crate::capacity::stored! {
    /// When a job needs a lane for the first time, and until when, in nanoseconds; equal: never.
    #[derive(Clone, Copy, Debug)]
    struct Held {
        from: u64,
        until: u64,
        /// Bytes of the last node there, and whether that runs already.
        memory: u64,
        runs: bool,
    }
}

crate::capacity::stored! {
    /// The lanes, from now or from the release on.
    #[derive(Clone, Copy, Debug)]
    struct Spread<C: Capacity> {
        held: C::Lanes<Held>,
        /// When the job ends.
        end: u64,
        /// Bytes of results, and the most that is held at once by what does not run yet.
        kept: u64,
        most: u64,
    }
}

impl<C: Capacity> Spread<C> {
    /// Bytes that are held at an instant by what is there; at that of the last start, or later.
    fn used(&self, at: u64, counts: impl Fn(&Held) -> bool) -> u64 {
        let there = self.held.as_ref().iter().filter(|held| held.until > at && counts(held));
        there.map(|held| held.memory).fold(self.kept, u64::saturating_add)
    }
}

/// Where a job is, and what is left of it.
struct Stage<'a, C: Capacity> {
    done: &'a NodeSet<C>,
    running: &'a NodeSet<C>,
    /// By rank: how many predecessors are not done.
    waiting_for: &'a C::Nodes<u8>,
    /// By rank, in nanoseconds.
    left: C::Nodes<u64>,
    /// By rank, in bytes; 0 where memory is not limited, and in other pools.
    memory: C::Nodes<u64>,
    /// By rank: the lanes of its pool.
    lanes: C::Nodes<u32>,
}

impl<'a, C: Capacity> Stage<'a, C> {
    fn new(done: &'a NodeSet<C>, running: &'a NodeSet<C>, waiting_for: &'a C::Nodes<u8>) -> Self {
        let (left, memory, lanes) = (Empty::EMPTY, Empty::EMPTY, Empty::EMPTY);
        Self { done, running, waiting_for, left, memory, lanes }
    }
}

/// What a job needs of a pool.
#[derive(Clone, Copy, Debug)]
pub(super) struct Need<C: Capacity> {
    lanes: C::Lanes<Held>,
    /// By how much later than that it may have them all, in nanoseconds.
    pub(super) spare: i64,
    /// Bytes that it has there at once, of nodes that have not started.
    pub(super) memory: u64,
}

impl<C: Capacity> Need<C> {
    /// Whether it has to have as many lanes by some instant, from another one on, as are not free by then. Time bound: O(lanes^2).
    pub(super) fn starts_before(&self, from: u64, free: &C::Lanes<u64>) -> bool {
        let latest =
            || self.lanes().map(|(after, _)| signed(from.saturating_add(after)).saturating_add(self.spare));
        let there = |by: i64| free.as_ref().iter().filter(|free| signed(**free) <= by).count();
        latest().any(|by| latest().filter(|latest| *latest <= by).count() > there(by))
    }

    /// When it needs a lane, and for how long.
    pub(super) fn lanes(&self) -> impl Iterator<Item = (u64, u64)> + '_ {
        let needed = self.lanes.as_ref().iter().filter(|held| held.until > held.from);
        needed.map(|held| (held.from, held.until - held.from))
    }
}

impl<C: Capacity> Scheduler<C> {
    /// What a job in flight needs from now on. Time bound: that of a spread.
    pub(super) fn need_of(&self, pool: usize, slot: usize) -> Need<C> {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let overran = self.tasks[job.task.index()].overran;
        let mut stage = Stage::new(&job.done, &job.running, &job.waiting_for);
        for rank in job.undone(version).iter() {
            self.enter(&mut stage, pool, rank, self.node(slot, rank));
            let left = |case| self.left_of(job, slot, rank, case);
            stage.left[rank] = left(Case::Worst).max(if overran { left(Case::Expected) } else { 0 });
        }
        self.need(pool, version, job.deadline.since(self.now).as_nanos(), &stage)
    }

    /// What a job to come of a task needs from its release on. Time bound: that of a spread.
    pub(super) fn need_of_next(&self, pool: usize, task: &Task<C>) -> Need<C> {
        let (version, none) = (task.newest(), NodeSet::EMPTY);
        let mut stage = Stage::new(&none, &none, &version.indegree);
        for rank in 0..usize::from(version.len) {
            let place = usize::from(version.order[rank]);
            let (node, window) =
                (&task.nodes[place], Estimator::of(task.shifts[place], &task.samples[place]));
            self.enter(&mut stage, pool, rank, node);
            stage.left[rank] =
                stage.left[rank].max(if task.overran { before_start(node, &window) } else { 0 });
        }
        let need = self.need(pool, version, task.timing.deadline.as_nanos(), &stage);
        Need { spare: need.spare.min(version.slack), ..need }
    }

    /// A node that has not run, where a pool is asked.
    fn enter(&self, stage: &mut Stage<'_, C>, pool: usize, rank: usize, node: &Node) {
        let p = &self.pools[node.pool.index()];
        (stage.left[rank], stage.lanes[rank]) = (node.cost(), p.lanes);
        stage.memory[rank] = if p.limited && node.pool.index() == pool { node.memory.0 } else { 0 };
    }

    /// What a job needs of the lanes of a pool so as to end within `due`. Time bound: O(lanes^2 * nodes^2), and
    /// O(lanes^3 * nodes^2) where nodes may have to wait for memory.
    fn need(&self, pool: usize, version: &Version<C>, due: u64, stage: &Stage<'_, C>) -> Need<C> {
        let (p, here) = (&self.pools[pool], version.in_pool[pool].without(stage.done));
        let work = here.iter().map(|rank| stage.left[rank]).fold(0, u64::saturating_add);
        let least = (work.div_ceil(due.max(1)) as usize).max(here.and(stage.running).len()).max(1);
        let on = |count: usize| {
            let few = bits(p.lanes.into()).take(count).fold(0, |few, lane| few | 1 << lane);
            version.spread_on(&here, few, p.budget, stage)
        };
        let all = p.lanes.count_ones() as usize;
        let spread = (least..all).map(on).find(|spread| spread.end <= due).unwrap_or_else(|| on(all));
        let spare = due.saturating_sub(spread.end).cast_signed();
        let mut lanes = <C::Lanes<Held>>::EMPTY;
        bits(p.lanes.into()).for_each(|lane| lanes[lane] = spread.held[lane]);
        Need { lanes, spare, memory: spread.most.min(p.budget) }
    }
}

impl<C: Capacity> Version<C> {
    /// The schedule where `here` are the nodes of the pool that is asked, of which the job has some lanes.
    fn spread_on(&self, here: &NodeSet<C>, few: u32, budget: u64, stage: &Stage<'_, C>) -> Spread<C> {
        let (mut new, mut ready, mut waiting_for) =
            (Spread::<C>::EMPTY, <C::Nodes<u64>>::EMPTY, *stage.waiting_for);
        let mut open = NodeSet::<C>::EMPTY;
        let mut clock = 0;
        let is_open = |rank: &usize| stage.waiting_for[*rank] == 0 && !stage.done.contains(*rank);
        (0..usize::from(self.len)).filter(is_open).for_each(|rank| open.insert(rank));
        let lanes_of = |rank: usize| if here.contains(rank) { few } else { stage.lanes[rank] };
        // Each round starts a node.
        loop {
            let start = |rank| {
                let is_new = !stage.running.contains(rank);
                if !is_new {
                    return (ready[rank], is_new, rank);
                }
                let ends = || bits(lanes_of(rank).into()).map(|lane| new.held[lane].until);
                let (first, memory) =
                    (ready[rank].max(ends().min().unwrap_or_default()).max(clock), stage.memory[rank]);
                let fits = |at: &u64| memory == 0 || new.used(*at, |_| true).saturating_add(memory) <= budget;
                let later = || ends().filter(|end| *end > first && fits(end)).min();
                let last = || ends().max().unwrap_or_default().max(first);
                let at = if fits(&first) { first } else { later().unwrap_or_else(last) };
                (at, is_new, rank)
            };
            let Some((start, is_new, rank)) = open.iter().map(start).min() else { return new };
            let (end, mut memory) = (start.saturating_add(stage.left[rank]), stage.memory[rank]);
            if self.encoders.contains(rank) && here.contains(rank) && is_new {
                (new.kept, memory) = (new.kept.saturating_add(memory), 0);
            }
            let free = bits(lanes_of(rank).into()).filter(|lane| new.held[*lane].until <= start);
            if let Some(lane) = free.max_by_key(|lane| new.held[*lane].until) {
                let lane = &mut new.held[lane];
                let from = if lane.until == 0 { start } else { lane.from };
                *lane = Held { from: if is_new { from } else { end }, until: end, memory, runs: !is_new };
            }
            new.most = new.most.max(new.used(start, |held| !held.runs));
            (new.end, clock) = (new.end.max(end), start);
            open.remove(rank);
            self.successors[rank].each(|next| {
                ready[next] = ready[next].max(end);
                waiting_for[next] = waiting_for[next].saturating_sub(1);
                open.insert_if(next, waiting_for[next] == 0 && !stage.done.contains(next));
            });
        }
    }
}

#[cfg(test)]
mod tests;
