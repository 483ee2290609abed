//! Lookahead: lanes that are left idle on purpose, for a node that is soon ready and is more pressing, or of a higher rank.
//!
//! *Rule.* Before the head of a pool starts: which nodes become ready there before it would end, by now plus its cost, with
//! a key below the head's and before that end? Those whose predecessors that are not done all run, once each of these has
//! run its cost; and the sources of the next job of each task, a period after the last one. Of them the first by (key,
//! instant, cost), as many as jobs have places, take its lanes in this order, each the first that is free: once after
//! the head has taken one, and once before it. If one starts after its key in the first case only, and the head not after
//! its own in the second, the pool starts nothing until something happens or that node should be ready.
//! Under pressure those that would not go before the head all the same are left out.
//! *Of a higher rank.* Whatever the gate, the next job of a task of higher rank that has less to spare than the head takes, at WCET,
//! counts whatever the head's key is, on as few lanes as end it in time, each from where it needs it, and the head waits for it even if it
//! is late by that; others that are ready and need not wait go before it. A lane that runs a higher rank is free once all behind that has run. A late release is
//! waited for for an eighth of its period. What cannot be in time alone, or
//! lost all of late, is waited for by nobody, but for one probe in 17; and if its nodes take too long, it waits for everybody.
//! *Why it ends.* A head that may be late for its key waits no longer, and each wait ends at an instant that is told. For a
//! higher rank it waits as long as it would take the lane of each next job; but a probe only for what a floor cannot spare.

use super::spread::{Held, Spread};
use super::{Scheduler, bits};
use crate::capacity::{Capacity, Empty};
use crate::config::Gate;
use crate::id::UnitId;
use crate::time::Instant;

/// The part of a period for which a release may be late and is waited for.
const PATIENCE: u64 = 8;

crate::capacity::stored! {
    /// A node that takes a lane, and when it is ready, in nanoseconds.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    struct Soon {
        key: i64,
        at: u64,
        cost: u64,
        /// Whether its job is of a higher rank than the head's.
        outranks: bool,
    }
}

/// Why a node does not start.
#[derive(Clone, Copy, Debug)]
struct Wait {
    /// Until when, in nanoseconds.
    until: u64,
    /// Whether the pool starts nothing else either: it is not for a higher rank.
    closes: bool,
}

impl<C: Capacity> Scheduler<C> {
    /// Starts the head of a pool with regard to memory, shared results and what comes soon, or another node in its stead, or
    /// nothing. Time bound: O(jobs * nodes) times that of a wait, where anything comes soon.
    #[cold]
    #[inline(never)]
    pub(super) fn start_with_care(
        &mut self,
        pool: usize,
        slot: usize,
        rank: usize,
        lane: usize,
    ) -> Option<UnitId> {
        let (slot, rank) = self.unheld(pool, slot, rank)?;
        self.reopen();
        let version = self.version(slot);
        if self.pools[pool].limited || version.encoders.contains(rank) || version.decoders.contains(rank) {
            return self.start_special(slot, rank, lane);
        }
        let unit = self.start(slot, rank, version.order[rank], lane);
        // It need not be the job that the queue would have given.
        self.requeue(slot);
        Some(unit)
    }

    /// The head if it may start; else the first node that may, or none.
    fn unheld(&mut self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        let Some(wait) = self.wait_of(pool, slot, rank) else { return Some((slot, rank)) };
        self.monitor.wake = self.monitor.wake.min(Instant::from_nanos(wait.until));
        self.alarm = self.alarm.min(self.monitor.wake);
        if wait.closes {
            None
        } else {
            self.most_pressing(pool, |slot, rank| self.may_start(pool, slot, rank))
        }
    }

    /// Whether a node that is ready need not wait for one that is soon ready.
    pub(super) fn may_start(&self, pool: usize, slot: usize, rank: usize) -> bool {
        self.wait_of(pool, slot, rank).is_none()
    }

    /// Whether a pool starts its head, or another node in its stead.
    pub(super) fn may_start_any(&self, pool: usize, slot: usize, rank: usize) -> bool {
        let may_start = |slot, rank| self.may_start(pool, slot, rank);
        let instead = || self.most_pressing(pool, may_start).is_some();
        self.wait_of(pool, slot, rank).is_none_or(|wait| !wait.closes && instead())
    }

    /// What a node has to wait for, if it should start now. Time bound: O(jobs * (nodes + edges + lanes^2) + tasks * (k + lanes * (nodes * (nodes + lanes) + jobs))).
    fn wait_of(&self, pool: usize, slot: usize, rank: usize) -> Option<Wait> {
        let (looks, is_pressed) = (self.config.gate == Gate::Lookahead, self.is_pressed(pool));
        let p = &self.pools[pool];
        if p.limited || p.is_plain && !looks || self.config.preempt {
            return None;
        }
        let (now, lanes) = (self.now.as_nanos(), p.lanes);
        let key_of = |slot: usize, rank| self.jobs[slot].key_of(self.version(slot), rank, self.residual);
        let head = Soon { key: key_of(slot, rank), at: now, cost: self.at_most(slot, rank), outranks: false };
        let end = now.saturating_add(head.cost);
        let latest = head.key.min(signed(end));
        let (mut soon, mut count) = (<C::Jobs<Soon>>::EMPTY, 0);
        let mut meet = |mut node: Soon| {
            let before = if node.outranks { signed(end) } else { latest };
            if node.at > now && node.at < end && node.key < before {
                for place in soon.as_mut().iter_mut().take(count) {
                    (*place, node) = (node.min(*place), node.max(*place));
                }
                if count < C::JOBS {
                    soon[count] = node;
                    count += 1;
                }
            }
        };
        let job = &self.jobs[slot];
        let (band, timing) = (job.band, &self.tasks[job.task.index()].timing);
        // Most heads meet nobody: the lanes are looked at for the others.
        let ends = looks.then(|| self.lanes_end());
        if let Some(ends) = &ends {
            for slot in self.slots().filter(|slot| self.jobs[*slot].band >= band) {
                let (job, version) = (&self.jobs[slot], self.version(slot));
                for rank in version.in_pool[pool].without(&job.done).without(&job.running).iter() {
                    let runs = job.running.iter().filter(|r| version.successors[*r].contains(rank));
                    let before = runs.map(|r| ends[usize::from(job.place[r])]);
                    let (count, at) = before.fold((0, 0), |(count, at), end| (count + 1, end.max(at)));
                    if count == job.waiting_for[rank] {
                        let cost = self.node(slot, rank).cost();
                        meet(Soon { key: key_of(slot, rank), at, cost, outranks: false });
                    }
                }
            }
        }
        let cost = self.node(slot, rank).cost().max(head.cost);
        let own = || self.beside_next(slot);
        for task in self.tasks.as_ref().iter().filter(|task| task.admitted && task.next_job > 0) {
            let Some(period) = task.timing.period() else { continue };
            let (version, value) = (task.newest(), task.timing.value);
            let next = || (true, !task.timing.floor.spares(task.next_job), value);
            let is_above = task.is_blocked_by(cost) && next() > own() && self.can_gain(task);
            if !is_above && (!looks || is_pressed && value < timing.value) {
                continue;
            }
            let due = task.released.saturating_add(period).as_nanos();
            let patience = due.saturating_add(period.as_nanos() / PATIENCE);
            let is_late = is_above && due <= now;
            // What comes once the head has ended does not wait for it.
            if due >= end || is_late && patience <= now {
                continue;
            }
            let mut add = |before: i64, spare: i64, cost| {
                let at = if is_late { patience } else { due.saturating_add_signed(before) };
                let key = signed(due).saturating_add(before).saturating_add(spare);
                let key = if is_late { key.max(signed(at)) } else { key };
                meet(Soon { key, at, cost, outranks: is_above });
            };
            if is_above {
                let (due, count) = (task.timing.deadline.as_nanos(), lanes.count_ones() as usize);
                let Spread { held, end } = version.spread(pool, count, due, &task.nodes);
                let spare = signed(due.saturating_sub(end)).min(version.slack);
                for Held { from, until } in held.as_ref().iter().filter(|held| held.until > 0) {
                    add(signed(*from), spare, until - from);
                }
                continue;
            }
            for rank in version.sources.and(&version.in_pool[pool]).iter() {
                add(0, version.key[rank], task.nodes[usize::from(version.order[rank])].cost());
            }
        }
        if count == 0 {
            return None;
        }
        let ends = ends.unwrap_or_else(|| self.lanes_end());
        let mut free = <C::Lanes<u64>>::EMPTY;
        for lane in 0..C::LANES {
            let l = &self.lanes[lane];
            let is_lost = lanes >> lane & 1 == 0 || l.is_busy() && l.members == 0;
            // What is behind a unit of a higher rank goes on at once.
            let above = bits(l.members).filter(|other| !looks && self.beside_next(*other) > own());
            let after = above.map(|slot| self.after(slot, lane)).fold(0, u64::max);
            free[lane] = if is_lost { u64::MAX } else { ends[lane].max(now).saturating_add(after) };
        }
        let mut behind = free;
        take::<C>(&mut behind, &head);
        let (mut until, mut until_above) = (u64::MAX, u64::MAX);
        for node in soon.as_ref().iter().take(count) {
            let (late, in_time) = (take::<C>(&mut behind, node), take::<C>(&mut free, node));
            if late > node.key && in_time <= node.key {
                until = until.min(node.at);
                until_above = if node.outranks { until_above.min(node.at) } else { until_above };
            }
        }
        let is_in_time = take::<C>(&mut free, &head) <= head.key;
        let until = if is_in_time { until } else { until_above };
        (until < u64::MAX).then_some(Wait { until, closes: until_above == u64::MAX })
    }

    /// How long the path of a job is after what it runs on a lane, at WCET, if all of it is in this pool.
    fn after(&self, slot: usize, lane: usize) -> u64 {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let due = job.deadline.since(job.release).as_nanos().cast_signed();
        let after = |rank| {
            let path = due.saturating_sub(version.key[rank]).max(0).cast_unsigned();
            path.saturating_sub(self.node(slot, rank).cost())
        };
        let is_here = version.pool_mask == 1 << self.lanes[lane].pool;
        self.ranks_on(slot, lane).filter(|_| is_here).map(after).max().unwrap_or_default()
    }

    /// When each lane has run the cost of its unit, if a job in flight needs it, and of what waits on it.
    fn lanes_end(&self) -> C::Lanes<u64> {
        let now = self.now.as_nanos();
        let mut ends = <C::Lanes<u64>>::EMPTY;
        for (slot, rank) in self.slots().flat_map(|s| self.jobs[s].running.iter().map(move |r| (s, r))) {
            let lane = usize::from(self.jobs[slot].place[rank]);
            let left = self.node(slot, rank).cost().saturating_sub(self.executed_on(lane).as_nanos());
            ends[lane] = ends[lane].max(now.saturating_add(left));
        }
        for lane in bits(self.promised.into()) {
            let left = self.promised_cost(lane);
            ends[lane] = ends[lane].max(now).saturating_add(left);
        }
        ends
    }
}

/// Takes the lane that is free first; when the node starts there.
fn take<C: Capacity>(free: &mut C::Lanes<u64>, node: &Soon) -> i64 {
    let Some(lane) = free.as_mut().iter_mut().min() else { return i64::MAX };
    let start = node.at.max(*lane);
    *lane = start.saturating_add(node.cost);
    signed(start)
}

fn signed(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX)
}
