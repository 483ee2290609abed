//! Lookahead: lanes that are left idle on purpose, for a node that is soon ready and is more pressing, or of a higher rank.
//!
//! *Rule.* Before the head of a pool starts: which nodes become ready there before it would end, by now plus its cost, with
//! a key below the head's and before that end? Those whose predecessors that are not done all run, once each of these has
//! run its cost; and the sources of the next job of each task, a period after the last one. Of them the first by (key,
//! instant, cost), as many as jobs have places, take its lanes in this order, each the first that is free: once after
//! the head has taken one, and once before it. If one starts after its key in the first case only, and the head not after
//! its own in the second, the pool starts nothing until something happens or that node should be ready.
//! Under pressure those that would not go before the head all the same are left out.
//! *Of a higher rank.* Whatever the gate, the lanes that a job in flight of a higher rank needs from now on, and those of the next 16 jobs of such a
//! task, count whatever the head's key is, as far as the head can delay one because of another. The head waits for them even if it is late by
//! that; others that are ready and need not wait go before it. In a pool of limited memory the head is also in the way where its
//! memory and theirs do not fit, and on one lane where some of these and all that are due before them fit without the head and not with it. A late release is waited for for an eighth of its period. What cannot be in time alone, or lost all of
//! late, is waited for by nobody, but for one probe in 17; and if its nodes take too long, it waits for everybody.
//! *Why it ends.* A head that may be late for its key waits no longer, and each wait ends at an instant that is told, or with what runs.
//! For a higher rank it waits as long as it would take a lane of its; but a probe only for what a floor cannot spare.

use super::coming::{Coming, Soon, signed, take};
use super::{Scheduler, bits};
use crate::capacity::{Capacity, Empty};
use crate::config::{Gate, Shed};
use crate::id::UnitId;
use crate::time::{Duration, Instant};

/// Jobs to come of a task that are waited for.
const AHEAD: u64 = 16;

/// So many times what comes makes the head's reach longer.
const ROUNDS: u32 = 5;

/// Until something happens, at an instant that nobody knows.
const NEXT_EVENT: u64 = u64::MAX - 1;

/// Why a node does not start.
#[derive(Clone, Copy, Debug)]
struct Wait {
    /// Until when, in nanoseconds, or `NEXT_EVENT`.
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
        let is_limited = self.pools[pool].limited;
        let fitting = if is_limited { self.fitting(pool, slot, rank) } else { Some((slot, rank)) };
        if fitting.is_none() && self.config.shed == Shed::Hopeless {
            // Who could overtake may have had to wait.
            self.look_again(NEXT_EVENT);
        }
        let (slot, rank) = fitting?;
        self.reopen();
        let version = self.version(slot);
        let is_special = version.encoders.contains(rank) || version.decoders.contains(rank);
        let unit = self.start(slot, rank, version.order[rank], lane);
        if is_limited || is_special {
            self.hold_and_share(slot, rank, lane);
        }
        // It need not be the job that the queue would have given.
        self.requeue(slot);
        Some(unit)
    }

    /// The head if it may start; else the first node that may, or none.
    fn unheld(&mut self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        if let Some(wait) = self.wait_of(pool, slot, rank) {
            self.look_again(wait.until);
            return self.instead(pool, wait);
        }
        Some((slot, rank))
    }

    /// All pools are looked at again at an instant, or before, when whatever ends next on a lane.
    fn look_again(&mut self, until: u64) {
        self.monitor.wake = self.monitor.wake.min(Instant::from_nanos(until));
        self.alarm = self.alarm.min(self.monitor.wake);
        self.lanes.as_mut().iter_mut().for_each(|lane| lane.leads = true);
    }

    /// What a pool starts whose head waits.
    fn instead(&self, pool: usize, wait: Wait) -> Option<(usize, usize)> {
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

    /// What a pool would start: its head, or another node in its stead.
    pub(super) fn goes(&self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        self.wait_of(pool, slot, rank).map_or(Some((slot, rank)), |wait| self.instead(pool, wait))
    }

    /// What a node has to wait for, if it should start now. Time bound: O((jobs + tasks) * lanes^2 * nodes^2 + tasks * lanes * jobs), and in a pool of
    /// limited memory O((jobs + tasks) * lanes^3 * nodes^2).
    fn wait_of(&self, pool: usize, slot: usize, rank: usize) -> Option<Wait> {
        let p = &self.pools[pool];
        let looks = self.config.gate == Gate::Lookahead && !p.limited;
        let blocks = if p.limited { self.config.shed == Shed::Hopeless } else { !p.is_plain };
        if !blocks && !looks || self.config.preempt {
            return None;
        }
        let (now, is_pressed, lanes) = (self.now.as_nanos(), self.is_pressed(pool), p.lanes);
        let key_of = |slot: usize, rank| self.jobs[slot].key_of(self.version(slot), rank, self.residual);
        let (key, cost) = (key_of(slot, rank), self.at_most(slot, rank));
        let head =
            Soon { key, at: now, cost, outranks: false, memory: self.node(slot, rank).memory.0, nth: 0 };
        let mut coming = Coming::<C>::new(head);
        let job = &self.jobs[slot];
        let (band, own_task, timing) = (job.band, job.task, &self.tasks[job.task.index()].timing);
        let own = if blocks { self.beside_next(slot, self.floor_of(job)) } else { (true, true, u32::MAX) };
        let has_floors =
            blocks && self.tasks.as_ref().iter().any(|task| task.admitted && task.timing.floor.needs_some());
        // Most heads meet nobody: the lanes are looked at for the others.
        let ends = (looks || has_floors).then(|| self.lanes_end());
        let mut again = <C::Lanes<u64>>::EMPTY;
        if let Some(ends) = ends.as_ref().filter(|_| has_floors) {
            again = self.lanes_free(lanes, ends);
            take::<C>(&mut again, &head);
        }
        let floors = self.floors_behind(pool, own_task, &again);
        for other in self.slots() {
            let (job, version) = (&self.jobs[other], self.version(other));
            let undone = version.in_pool[pool].without(&job.done).without(&job.running);
            let floor = &floors[job.task.index()];
            if blocks && !undone.is_empty() && self.is_waited_for(other, floor, own_task, own) {
                coming.meet_need(now, 0, 0, &self.need_of(pool, other));
            } else if let Some(ends) = ends.as_ref().filter(|_| looks && job.band >= band) {
                for rank in undone.iter() {
                    let runs = job.running.iter().filter(|r| version.successors[*r].contains(rank));
                    let before = runs.map(|r| ends[usize::from(job.place[r])]);
                    let (count, at) = before.fold((0, 0), |(count, at), end| (count + 1, end.max(at)));
                    if count == job.waiting_for[rank] {
                        let cost = self.node(other, rank).cost();
                        coming.meet(Soon { key: key_of(other, rank), at, cost, memory: 0, ..head });
                    }
                }
            }
        }
        let mut met = 0;
        for _ in 0..ROUNDS {
            // What comes once nobody is late any more because of the head does not wait for it.
            let (end, horizon) = (coming.end(), coming.horizon(lanes.count_ones()));
            if horizon == met {
                break;
            }
            for (t, task) in self.tasks.as_ref().iter().enumerate().filter(|(_, task)| task.admitted) {
                let (Some(period), Some(patience)) = (task.timing.period(), task.awaited_until()) else {
                    continue;
                };
                let (version, value, patience) = (task.newest(), task.timing.value, patience.as_nanos());
                let due = |nth: u64| {
                    let after = period.as_nanos().saturating_mul(nth + 1);
                    task.released.saturating_add(Duration::from_nanos(after)).as_nanos()
                };
                // Who does not come may have stopped.
                if due(0) >= horizon || patience <= now {
                    continue;
                }
                let (mut floor, mut need, mut is_met) = (floors[t], None, false);
                for nth in (0..AHEAD).take_while(|nth| t != own_task.index() && due(*nth) < horizon) {
                    let index = task.next_job + nth;
                    let is_above = (true, !floor.spares(index), value) > own && self.can_gain(task, index);
                    if is_above && due(nth) >= met {
                        let need = need.get_or_insert_with(|| self.need_of_next(pool, task));
                        let earliest = if nth > 0 || due(0) > now { 0 } else { patience };
                        coming.meet_need(due(nth), earliest, nth, need);
                    } else if !is_above && floor.needs_some() {
                        let need = need.get_or_insert_with(|| self.need_of_next(pool, task));
                        if need.starts_before(due(nth), &again) {
                            floor.ended(index, true);
                        }
                    }
                    is_met |= is_above && nth == 0;
                }
                let foresees = looks && met == 0 && !is_met && due(0) < end;
                if foresees && !(is_pressed && value < timing.value) {
                    for rank in version.sources.and(&version.in_pool[pool]).iter() {
                        let cost = task.nodes[usize::from(version.order[rank])].cost();
                        let key = signed(due(0)).saturating_add(version.key[rank]);
                        coming.meet(Soon { key, at: due(0), cost, memory: 0, ..head });
                    }
                }
            }
            met = horizon;
        }
        coming.iter().next()?;
        let ends = ends.unwrap_or_else(|| self.lanes_end());
        let mut free = self.lanes_free(lanes, &ends);
        // Bytes that are held when a node has to start, if the head does now.
        let at_first = free;
        let held = |at: i64| {
            let ended =
                bits(lanes.into()).filter(|lane| signed(at_first[*lane]) <= at).map(|lane| &self.lanes[lane]);
            let gone = ended
                .filter(|l| !(l.is_encoder && l.output != 0 && self.config.frame_cache))
                .map(|l| l.memory)
                .sum::<u64>();
            head.memory.saturating_add(p.used - gone)
        };
        let only = (lanes.count_ones() == 1).then_some(free[lanes.trailing_zeros() as usize]);
        let mut behind = free;
        take::<C>(&mut behind, &head);
        let (mut until, mut until_above) = (u64::MAX, u64::MAX);
        for node in coming.iter() {
            let is_ready = node.at <= now;
            let (late, in_time) = (take::<C>(&mut behind, node), take::<C>(&mut free, node));
            let is_crowded = p.limited && held(node.key).saturating_add(node.memory) > p.budget;
            let is_late = (late > node.key || is_crowded) && in_time <= node.key;
            if is_late || only.is_some_and(|free| coming.leave_no_time(node, free)) {
                let at = if is_ready { NEXT_EVENT } else { node.at };
                until = until.min(at);
                until_above = if node.outranks { until_above.min(at) } else { until_above };
            }
        }
        let is_in_time = take::<C>(&mut free, &head) <= head.key;
        let until = if is_in_time { until } else { until_above };
        (until < u64::MAX).then_some(Wait { until, closes: until_above == u64::MAX })
    }
}
