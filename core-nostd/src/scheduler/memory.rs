//! Pools with a memory budget.
//!
//! *Rule.* A node fits if running footprints + kept results + its own are within the budget. When the head does
//! not fit, at most as many later nodes as the pool has lanes may overtake it; then the pool starts nothing
//! until the head fits. If nothing runs and it still does not fit, kept results without a ready decoder go, and
//! if that is not enough, every kept result that the head itself does not read; their encoders run again.
//! *Why the head cannot starve.* After `lanes` overtakings every lane drains; then only results stand in its
//! way, and a node fits beside its own encoder's result, which admission checked.

use super::{Scheduler, event::EventKind};
use crate::capacity::Capacity;
use crate::policy::frame_cache::OutputState;

/// Which kept results may go.
#[derive(Clone, Copy)]
enum Rest {
    WithoutReadyDecoder,
    NotReadByHead,
    All,
}

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
            first.is_some_and(|(_, slot, rank)| {
                self.next_that_fits(pool, slot, rank).is_some() || self.is_drained(pool)
            })
        })
    }

    /// The head if it fits; else the most pressing ready node of the pool that fits, where it may be overtaken.
    fn next_that_fits(&self, pool: usize, slot: usize, rank: usize) -> Option<(usize, usize)> {
        if self.fits(pool, slot, rank) {
            return Some((slot, rank));
        }
        if u32::from(self.jobs[slot].place[rank]) >= self.pools[pool].lanes.count_ones() {
            return None;
        }
        let fitting = |slot: usize| {
            let ready = self.jobs[slot].ready.and(&self.version(slot).in_pool[pool]);
            let rank = ready.iter().find(|rank| self.fits(pool, slot, *rank))?;
            Some((self.rank_key(slot, rank), slot, rank))
        };
        self.slots().filter_map(fitting).min().map(|(_, slot, rank)| (slot, rank))
    }

    fn is_drained(&self, pool: usize) -> bool {
        self.pools[pool].free == self.pools[pool].lanes
    }

    fn fits(&self, pool: usize, slot: usize, rank: usize) -> bool {
        let p = &self.pools[pool];
        p.used.saturating_add(self.node(slot, rank).memory.0) <= p.budget
    }

    /// Nothing runs in the pool and its head does not fit: results have to go. The head may be another one
    /// afterwards, because evicted encoders are ready again.
    #[cold]
    fn make_room(&mut self, pool: usize, mut slot: usize, mut rank: usize) -> Option<(usize, usize)> {
        // A head that fits now starts at once; evicted encoders that are ready again come after it.
        for rest in [Rest::WithoutReadyDecoder, Rest::NotReadByHead, Rest::All] {
            for place in 0..C::NODES {
                let output = &self.outputs[place];
                let here = output.state == OutputState::Kept && usize::from(output.pool) == pool;
                if here && self.may_go(place, rest, slot, rank) {
                    self.evict(place);
                }
            }
            if self.jobs[slot].ready.contains(rank) && self.fits(pool, slot, rank) {
                return Some((slot, rank));
            }
            slot = self.pick(pool)?;
            rank = self.head_of(slot, pool)?;
        }
        self.fits(pool, slot, rank).then_some((slot, rank))
    }

    fn may_go(&self, place: usize, rest: Rest, slot: usize, rank: usize) -> bool {
        let reads = |slot: usize, rank: usize| {
            let encoder = self.version(slot).encoder_of(rank);
            encoder.is_some_and(|e| usize::from(self.jobs[slot].place[e]) == place + 1)
        };
        match rest {
            Rest::WithoutReadyDecoder => !self.slots().any(|s| {
                let decoders = self.jobs[s].ready.and(&self.version(s).decoders);
                decoders.iter().any(|d| reads(s, d))
            }),
            Rest::NotReadByHead => !reads(slot, rank),
            Rest::All => true,
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
                job.place[e] = 0;
                job.left += 1;
                // The encoder's second end counts every successor down again, done ones too.
                version.successors[e].each(|s| job.waiting_for[s] += 1);
                job.ready = job.ready.without(&version.successors[e]);
                job.ready.insert(e);
                job.reruns = true;
                self.requeue(slot);
            }
        }
        self.free_output(place);
        // Also of jobs that would have taken the result.
        self.look_soon(|_, _| true);
    }
}
