//! Lookahead: lanes that are left idle on purpose, for a node that is more pressing and soon ready.
//!
//! *Rule.* Before the head of a pool starts: which nodes become ready there before it would end, by now plus its cost, with
//! a key below the head's and before that end? Those whose predecessors that are not done all run, once each of these has
//! run its cost; and the sources of the next job of each task, a period after the last one. Of them the first by (key,
//! instant, cost), as many as the pool has lanes, take its lanes in this order, each the first that is free: once after
//! the head has taken one, and once before it. If one starts after its key in the first case only, and the head not after
//! its own in the second, the pool starts nothing until something happens or that node should be ready.
//! Under pressure those that would not go before the head all the same are left out.
//! *Why it ends.* A head that may be late for its key waits no longer, and each wait ends at an instant that is told.

use super::{Scheduler, tasks::Task};
use crate::capacity::{Capacity, Empty};
use crate::id::UnitId;
use crate::time::Instant;

crate::capacity::stored! {
    /// A node that takes a lane, and when it is ready, in nanoseconds.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    struct Soon {
        key: i64,
        at: u64,
        cost: u64,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Starts the head of a pool, or nothing. Time bound: O(jobs * nodes * lanes).
    #[cold]
    #[inline(never)]
    pub(super) fn start_unless_held(
        &mut self,
        pool: usize,
        slot: usize,
        rank: usize,
        lane: usize,
    ) -> Option<UnitId> {
        let limited = self.pools[pool].limited;
        if !limited && !self.config.preempt && self.holds_back(pool, slot, rank) {
            return None;
        }
        self.reopen();
        let version = self.version(slot);
        if limited || version.encoders.contains(rank) || version.decoders.contains(rank) {
            return self.start_special(slot, rank, lane);
        }
        Some(self.start(slot, rank, version.order[rank], lane))
    }

    fn holds_back(&mut self, pool: usize, slot: usize, rank: usize) -> bool {
        let (now, lanes) = (self.now.as_nanos(), self.pools[pool].lanes);
        let key_of = |slot: usize, rank| self.jobs[slot].key_of(self.version(slot), rank, self.residual);
        let head = Soon { key: key_of(slot, rank), at: now, cost: self.node(slot, rank).cost() };
        // When the unit on a lane has run its cost, if a job in flight needs it.
        let mut ends = <C::Lanes<u64>>::EMPTY;
        for (slot, rank) in self.slots().flat_map(|s| self.jobs[s].running.iter().map(move |r| (s, r))) {
            let lane = usize::from(self.jobs[slot].place[rank]);
            let left = self.node(slot, rank).cost().saturating_sub(self.executed_on(lane).as_nanos());
            ends[lane] = ends[lane].max(now.saturating_add(left));
        }
        let end = now.saturating_add(head.cost);
        let latest = head.key.min(signed(end));
        let mut soon = <C::Lanes<Soon>>::EMPTY;
        soon.as_mut().fill(Soon { key: i64::MAX, ..Soon::EMPTY });
        let mut meet = |mut node: Soon| {
            if node.at > now && node.at < end && node.key < latest {
                for place in soon.as_mut().iter_mut().take(lanes.count_ones() as usize) {
                    (*place, node) = (node.min(*place), node.max(*place));
                }
            }
        };
        let (band, value) = (self.jobs[slot].band, self.tasks[self.jobs[slot].task.index()].timing.value);
        for slot in self.slots().filter(|slot| self.jobs[*slot].band >= band) {
            let (job, version) = (&self.jobs[slot], self.version(slot));
            for rank in version.in_pool[pool].without(&job.done).without(&job.running).iter() {
                let runs = job.running.iter().filter(|r| version.successors[*r].contains(rank));
                let before = runs.map(|r| ends[usize::from(job.place[r])]);
                let (count, at) = before.fold((0, 0), |(count, at), end| (count + 1, end.max(at)));
                if count == job.waiting_for[rank] {
                    meet(Soon { key: key_of(slot, rank), at, cost: self.node(slot, rank).cost() });
                }
            }
        }
        let is_below = |task: &&Task<C>| self.is_pressed() && task.timing.value < value;
        let tasks = self.tasks.as_ref().iter().filter(|task| task.admitted && task.next_job > 0);
        for task in tasks.filter(|task| !is_below(task)) {
            let Some(period) = task.timing.period() else { continue };
            let (at, version) = (task.released.saturating_add(period).as_nanos(), task.newest());
            for rank in version.sources.and(&version.in_pool[pool]).iter() {
                let cost = task.nodes[usize::from(version.order[rank])].cost();
                meet(Soon { key: signed(at).saturating_add(version.key[rank]), at, cost });
            }
        }
        let mut free = <C::Lanes<u64>>::EMPTY;
        for lane in 0..C::LANES {
            let l = &self.lanes[lane];
            let is_lost = lanes >> lane & 1 == 0 || l.is_busy() && l.members == 0;
            free[lane] = if is_lost { u64::MAX } else { ends[lane].max(now) };
        }
        let mut behind = free;
        take::<C>(&mut behind, &head);
        let mut until = u64::MAX;
        for node in soon.as_ref() {
            let (late, in_time) = (take::<C>(&mut behind, node), take::<C>(&mut free, node));
            if late > node.key && in_time <= node.key {
                until = until.min(node.at);
            }
        }
        let waits = until < u64::MAX && take::<C>(&mut free, &head) <= head.key;
        if waits {
            self.monitor.wake = self.monitor.wake.min(Instant::from_nanos(until));
            self.alarm = self.alarm.min(self.monitor.wake);
        }
        waits
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
