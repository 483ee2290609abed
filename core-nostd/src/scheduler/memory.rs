//! Pools with a memory budget.
//!
//! *Rule.* A node fits if running footprints + kept results + its own are within the budget. While the head does not
//! fit, at most as many later nodes as the pool has lanes overtake it. If nothing runs then, kept results without a
//! ready decoder go, and their encoders run again; if need be, all that the head does not read. Before a head that
//! is an encoder the most pressing ready decoder starts then, and its result stays.
//! *Why it goes on.* A node fits beside its own encoder's result, which admission checked. Encoders alone would throw
//! each other's results away for ever, because keys put them before decoders; a decoder's end is for good.

use super::{Scheduler, event::EventKind};
use crate::capacity::Capacity;
use crate::policy::frame_cache::OutputState;

impl<C: Capacity> Scheduler<C> {
    /// The node to start when `rank` of `slot` is the pool's head: itself, one that may overtake it, or none.
    pub(super) fn fitting(&mut self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        let Some(next) = self.next_that_fits(pool, slot, rank) else {
            return if self.is_drained(pool) { self.make_room(pool, slot, rank) } else { None };
        };
        self.jobs[slot].place[rank] += u8::from(next != (slot, rank));
        Some(next)
    }

    /// Whether a pool has both a free lane and a sub-job that could start on it.
    pub fn can_dispatch(&self) -> bool {
        let head = |slot, pool| self.head_of(slot, pool).map(|rank| (self.rank_key(slot, rank), slot, rank));
        self.pool_numbers().filter(|pool| self.pools[*pool].free != 0).any(|pool| {
            let first = self.slots().filter_map(|slot| head(slot, pool)).min();
            first.and_then(|(_, slot, rank)| self.goes(pool, slot, rank)).is_some_and(|(slot, rank)| {
                self.next_that_fits(pool, slot, rank).is_some() || self.is_drained(pool)
            })
        })
    }

    /// The head if it fits; else the most pressing ready node of the pool that does, where it may be overtaken.
    fn next_that_fits(&self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        if self.fits(pool, slot, rank) {
            return Some((slot, rank));
        }
        if u32::from(self.jobs[slot].place[rank]) >= self.pools[pool].lanes.count_ones() {
            return None;
        }
        self.most_pressing(pool, |slot, rank| self.fits(pool, slot, rank) && self.may_start(pool, slot, rank))
    }

    pub(super) fn most_pressing(
        &self,
        pool: usize,
        will_do: impl Fn(usize, usize) -> bool,
    ) -> Option<(usize, usize)> {
        let first = |slot: usize| {
            let ready = self.jobs[slot].ready.and(&self.version(slot).in_pool[pool]);
            let rank = ready.iter().find(|rank| will_do(slot, *rank))?;
            Some((self.rank_key(slot, rank), slot, rank))
        };
        self.slots().filter_map(first).min().map(|(_, slot, rank)| (slot, rank))
    }

    fn is_drained(&self, pool: usize) -> bool {
        self.pools[pool].free == self.pools[pool].lanes
    }

    pub(super) fn fits(&self, pool: usize, slot: usize, rank: usize) -> bool {
        let p = &self.pools[pool];
        p.used.saturating_add(self.node(slot, rank).memory.0) <= p.budget
    }

    /// Nothing runs and the head does not fit. It may be another one afterwards: evicted encoders are ready.
    #[cold]
    fn make_room(&mut self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        self.evict_all(pool, |s, place| {
            !s.slots().any(|slot| s.jobs[slot].ready.iter().any(|rank| s.reads(slot, rank, place)))
        });
        if self.can_start(pool, slot, rank) {
            return Some((slot, rank));
        }
        let head = self.first(pool)?;
        let is_encoder = self.version(head.0).encoders.contains(head.1);
        let decoder = |slot, rank| is_encoder && self.version(slot).decoders.contains(rank);
        let (slot, rank) = self.most_pressing(pool, decoder).unwrap_or(head);
        self.evict_all(pool, |s, place| !s.reads(slot, rank, place));
        if self.can_start(pool, slot, rank) {
            return Some((slot, rank));
        }
        self.evict_all(pool, |_, _| true);
        self.first(pool)
    }

    fn can_start(&self, pool: usize, slot: usize, rank: usize) -> bool {
        self.jobs[slot].ready.contains(rank) && self.fits(pool, slot, rank)
    }

    fn reads(&self, slot: usize, rank: usize, place: usize) -> bool {
        let encoder = self.version(slot).encoder_of(rank);
        encoder.is_some_and(|e| usize::from(self.jobs[slot].place[e]) == place + 1)
    }

    fn evict_all(&mut self, pool: usize, may_go: impl Fn(&Self, usize) -> bool) {
        for place in 0..C::NODES {
            let o = &self.outputs[place];
            if o.state == OutputState::Kept && usize::from(o.pool) == pool && may_go(self, place) {
                self.evict(place);
            }
        }
    }

    /// Throws a kept result away: encoders whose decoders still need it are ready again.
    fn evict(&mut self, place: usize) {
        self.counters.evictions += 1;
        for slot in self.slots() {
            while let Some(e) = self.reader(slot, place) {
                self.note(EventKind::Evicted, slot, e, 0);
                let job = &mut self.jobs[slot];
                let version = self.tasks[job.task.index()].version_of(job);
                job.done.remove(e);
                (job.place[e], job.left) = (0, job.left + 1);
                // The encoder's second end counts every successor down again, done ones too.
                version.successors[e].each(|s| job.waiting_for[s] += 1);
                job.ready = job.ready.without(&version.successors[e]);
                job.parked = job.parked.without(&version.successors[e]);
                // An encoder before it may have gone too.
                job.ready.insert_if(e, job.waiting_for[e] == 0);
                job.reruns = true;
                self.requeue(slot);
            }
        }
        self.free_output(place);
        // Also for jobs that would have taken the result.
        self.worsened();
    }
}
