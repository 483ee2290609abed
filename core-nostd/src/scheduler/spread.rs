//! A job alone on its pools: how many lanes of one it needs, from when and until when, and how much memory.
//!
//! *Rule.* The first ready node by rank goes on a lane as soon as one is free, of several on the one that was busy last. Nodes of
//! other pools start when they are ready. A job takes as few lanes as end it by its deadline; all, if no number does. One in flight
//! goes on from where it is: a lane counts from the end of what the job runs there.

use super::{Scheduler, outlook::Case, tasks::Task, version::Version};
use crate::capacity::{Capacity, Empty};
use crate::graph::{Node, NodeSet};

crate::capacity::stored! {
    /// When a job needs a lane for the first time, and until when, in nanoseconds; equal: never.
    #[derive(Clone, Copy, Debug)]
    struct Held {
        from: u64,
        until: u64,
    }
}

crate::capacity::stored! {
    /// The lanes of the pool, from now or from the release on; when the job ends.
    #[derive(Clone, Copy, Debug)]
    struct Spread<C: Capacity> {
        held: C::Lanes<Held>,
        end: u64,
    }
}

/// Where a job is.
#[derive(Debug)]
struct Stage<'a, C: Capacity> {
    done: &'a NodeSet<C>,
    running: &'a NodeSet<C>,
    /// By rank: how many predecessors are not done.
    waiting_for: &'a C::Nodes<u8>,
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
        let stage = Stage { done: &job.done, running: &job.running, waiting_for: &job.waiting_for };
        let left = |rank| self.left_of(job, slot, rank, Case::Worst);
        let due = job.deadline.since(self.now).as_nanos();
        self.need(pool, version, &self.tasks[job.task.index()], due, &stage, &left)
    }

    /// What the next job of a task needs from its release on, at WCET. Time bound: that of a spread.
    pub(super) fn need_of_next(&self, pool: usize, task: &Task<C>) -> Need<C> {
        let version = task.newest();
        let none = NodeSet::EMPTY;
        let stage = Stage { done: &none, running: &none, waiting_for: &version.indegree };
        let cost = |rank| task.nodes[usize::from(version.order[rank])].cost();
        let need = self.need(pool, version, task, task.timing.deadline.as_nanos(), &stage, &cost);
        Need { spare: need.spare.min(version.slack), ..need }
    }

    fn need(
        &self,
        pool: usize,
        version: &Version<C>,
        task: &Task<C>,
        due: u64,
        stage: &Stage<'_, C>,
        left: &dyn Fn(usize) -> u64,
    ) -> Need<C> {
        let (p, all) = (&self.pools[pool], self.pools[pool].lanes.count_ones() as usize);
        let new = version.in_pool[pool].without(stage.done).without(stage.running);
        let holds = |lanes| if p.limited { version.footprint(&new, lanes, &task.nodes) } else { 0 };
        // Nor does it run on more lanes than there is memory for.
        let lanes = p.budget.checked_div(holds(1)).map_or(all, |most| all.min(most.max(1) as usize));
        let Spread { held, end } = version.spread(pool, lanes, due, stage, left);
        let mut need = Need { lanes: held, spare: due.saturating_sub(end).cast_signed(), memory: 0 };
        need.memory = holds(need.lanes().count()).min(p.budget);
        need
    }
}

impl<C: Capacity> Version<C> {
    /// The lanes of a pool that a job needs so as to end within `due`, if so much is left of each node. Time bound:
    /// O(lanes * nodes * (nodes + lanes)).
    fn spread(
        &self,
        pool: usize,
        lanes: usize,
        due: u64,
        stage: &Stage<'_, C>,
        left: &dyn Fn(usize) -> u64,
    ) -> Spread<C> {
        let here = self.in_pool[pool].without(stage.done);
        let work = here.iter().map(left).fold(0, u64::saturating_add);
        let least = (work.div_ceil(due.max(1)) as usize).max(here.and(stage.running).len()).max(1);
        let on = |count: usize| self.spread_on(&here, count, stage, left);
        (least..lanes).map(on).find(|spread| spread.end <= due).unwrap_or_else(|| on(lanes))
    }

    fn spread_on(
        &self,
        here: &NodeSet<C>,
        count: usize,
        stage: &Stage<'_, C>,
        left: &dyn Fn(usize) -> u64,
    ) -> Spread<C> {
        let (mut new, mut ready, mut waiting_for) =
            (Spread::<C>::EMPTY, <C::Nodes<u64>>::EMPTY, *stage.waiting_for);
        let mut open = NodeSet::<C>::EMPTY;
        let is_open = |rank: &usize| stage.waiting_for[*rank] == 0 && !stage.done.contains(*rank);
        (0..usize::from(self.len)).filter(is_open).for_each(|rank| open.insert(rank));
        // Each round starts a node.
        loop {
            let free = new.held.as_ref().iter().take(count).map(|lane| lane.until).min().unwrap_or_default();
            let start = |rank| {
                let is_new = !stage.running.contains(rank);
                let lane = if here.contains(rank) && is_new { free } else { 0 };
                (ready[rank].max(lane), is_new, rank)
            };
            let Some((start, is_new, rank)) = open.iter().map(start).min() else { return new };
            let end = start.saturating_add(left(rank));
            let lanes = new.held.as_mut().iter_mut().take(count);
            let lane = lanes.filter(|lane| lane.until <= start).max_by_key(|lane| lane.until);
            if let Some(lane) = lane.filter(|_| here.contains(rank)) {
                let from = if lane.until == 0 { start } else { lane.from };
                *lane = Held { from: if is_new { from } else { end }, until: end };
            }
            new.end = new.end.max(end);
            open.remove(rank);
            self.successors[rank].each(|next| {
                ready[next] = ready[next].max(end);
                waiting_for[next] = waiting_for[next].saturating_sub(1);
                open.insert_if(next, waiting_for[next] == 0);
            });
        }
    }

    /// The most that some of its nodes hold of a pool at once on so many lanes, beside the results of encoders.
    fn footprint(&self, of: &NodeSet<C>, lanes: usize, nodes: &C::Nodes<Node>) -> u64 {
        let bytes = |rank: usize| nodes[usize::from(self.order[rank])].memory.0;
        let sum = |set: &NodeSet<C>| set.iter().map(bytes).fold(0, u64::saturating_add);
        let most = of.iter().map(bytes).fold(0, u64::max).saturating_mul(lanes as u64);
        sum(of).min(most.saturating_add(sum(&of.and(&self.encoders))))
    }
}
