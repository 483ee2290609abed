//! What soon takes a lane, in the order in which it does.

use super::{Scheduler, bits, spread::Need, tasks::Task};
use crate::capacity::{Capacity, Empty};
use crate::time::{Duration, Instant};

/// The part of a period for which a release may be late and is awaited.
const PATIENCE: u64 = 8;

crate::capacity::stored! {
    /// A node that takes a lane, and when it is ready, in nanoseconds.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub(super) struct Soon {
        pub(super) key: i64,
        pub(super) at: u64,
        pub(super) cost: u64,
        /// Whether its job is of a higher rank than the head's.
        pub(super) outranks: bool,
        /// Of the head, or of all of a job of a higher rank that has not started, in bytes.
        pub(super) memory: u64,
        /// How many jobs of its task come before its job.
        pub(super) nth: u64,
    }
}

/// What the head meets by key; as many as jobs have places, the next jobs of each task before those after them.
#[derive(Debug)]
pub(super) struct Coming<C: Capacity> {
    soon: C::Jobs<Soon>,
    count: usize,
    head: Soon,
    /// Of all of a higher rank, in nanoseconds.
    work: u64,
}

impl<C: Capacity> Coming<C> {
    pub(super) fn new(head: Soon) -> Self {
        Self { soon: Empty::EMPTY, count: 0, head, work: 0 }
    }

    /// When the head ends.
    pub(super) fn end(&self) -> u64 {
        self.head.at.saturating_add(self.head.cost)
    }

    /// Until when a lane may be late because of the head, if so many had to do all of a higher rank that came so far behind it.
    pub(super) fn horizon(&self, lanes: u32) -> u64 {
        self.end().saturating_add(self.work.div_ceil(lanes.max(1).into()))
    }

    /// Takes in a node of a higher rank; another one if it is ready before the head ends, and more pressing.
    pub(super) fn meet(&mut self, mut node: Soon) {
        let (now, end) = (self.head.at, self.end());
        self.work = self.work.saturating_add(if node.outranks { node.cost } else { 0 });
        let is_soon = node.at > now && node.at < end && node.key < self.head.key.min(signed(end));
        if (node.outranks || is_soon) && self.has_place_for(&node) {
            for place in self.soon.as_mut().iter_mut().take(self.count) {
                (*place, node) = (node.min(*place), node.max(*place));
            }
            if self.count < C::JOBS {
                self.soon[self.count] = node;
                self.count += 1;
            }
        }
    }

    /// Whether there is a place; where all are taken, that of the last job goes, if that comes after this node's.
    fn has_place_for(&mut self, node: &Soon) -> bool {
        if self.count < C::JOBS {
            return true;
        }
        let order = |node: &Soon| (node.nth, *node);
        let Some(last) = self.iter().max_by_key(|node| order(node)).copied() else { return false };
        let is_sooner = order(node) < order(&last);
        if is_sooner {
            let mut moved = Soon::EMPTY;
            for place in self.soon.as_mut().iter_mut().take(self.count).rev() {
                core::mem::swap(place, &mut moved);
                if moved == last {
                    break;
                }
            }
            self.count -= 1;
        }
        is_sooner
    }

    /// Of a job of a higher rank all lanes that it needs after some instant, at the earliest from another one on.
    pub(super) fn meet_need(&mut self, after: u64, earliest: u64, nth: u64, need: &Need<C>) {
        for (from, cost) in need.lanes() {
            let from = after.saturating_add(from);
            let at = from.max(earliest);
            let key = signed(from).saturating_add(need.spare).max(signed(at));
            self.meet(Soon { key, at, cost, outranks: true, memory: need.memory, nth });
        }
    }

    /// Whether a lane that is free from an instant on has time for a node of a higher rank and all of these that are due no later, but not
    /// for the head, too. Time bound: O(jobs).
    pub(super) fn leave_no_time(&self, node: &Soon, free: u64) -> bool {
        let due = |node: &Soon| node.key.saturating_add(signed(node.cost));
        let before = self.iter().filter(|other| other.outranks && due(other) <= due(node));
        let end = before.map(|other| other.cost).fold(free, u64::saturating_add);
        let [without, with] = [end, end.saturating_add(self.head.cost)].map(signed);
        node.outranks && without <= due(node) && due(node) < with
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Soon> {
        self.soon.as_ref().iter().take(self.count)
    }
}

impl<C: Capacity> Scheduler<C> {
    /// When each of some lanes is free; never, where nobody knows.
    pub(super) fn lanes_free(&self, lanes: u32, ends: &C::Lanes<u64>) -> C::Lanes<u64> {
        let mut free = <C::Lanes<u64>>::EMPTY;
        for lane in 0..C::LANES {
            let l = &self.lanes[lane];
            let is_lost = lanes >> lane & 1 == 0 || l.is_busy() && l.members == 0;
            free[lane] = if is_lost { u64::MAX } else { ends[lane].max(self.now.as_nanos()) };
        }
        free
    }

    /// When each lane has run the cost of its unit, if a job in flight needs it, and of what waits on it.
    pub(super) fn lanes_end(&self) -> C::Lanes<u64> {
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

impl<C: Capacity> Task<C> {
    /// Until when its next job is awaited, by its period after the last one: who does not come by then may have stopped.
    pub(super) fn awaited_until(&self) -> Option<Instant> {
        let period = self.timing.period().filter(|_| self.next_job > 0)?;
        let patience = period.saturating_add(Duration::from_nanos(period.as_nanos() / PATIENCE));
        Some(self.released.saturating_add(patience))
    }
}

/// Takes the lane that is free first; when the node starts there.
pub(super) fn take<C: Capacity>(free: &mut C::Lanes<u64>, node: &Soon) -> i64 {
    let Some(lane) = free.as_mut().iter_mut().min() else { return i64::MAX };
    let start = node.at.max(*lane);
    *lane = start.saturating_add(node.cost);
    signed(start)
}

pub(super) fn signed(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests;
