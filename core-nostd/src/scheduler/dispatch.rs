//! `poll`: the only place that picks what runs.

use super::action::{Action, Dispatch};
use super::{Scheduler, complete::CompleteError};
use crate::capacity::Capacity;
use crate::id::{LaneId, UnitId};
use crate::time::Instant;
use core::convert::identity;
use core::hint::cold_path;

impl<C: Capacity> Scheduler<C> {
    /// The next thing to do, or `None` until something happens or `poll_at` comes. Between two events it answers
    /// at most once per lane and ended job, and once more per lane where a pool dispatches ahead. Time bound: O(log jobs) per dispatched node, else the module's table.
    #[must_use = "an action that is not carried out is lost"]
    #[inline]
    pub fn poll(&mut self, now: Instant) -> Option<Action> {
        let now = self.advance(now);
        self.next(now, 0, identity)
    }

    /// `poll` for a lane that asks for itself: it is preferred among the free lanes of its pool.
    #[must_use = "an action that is not carried out is lost"]
    #[inline]
    pub fn poll_on(&mut self, lane: LaneId, now: Instant) -> Option<Action> {
        let now = self.advance(now);
        self.next(now, 1u32.checked_shl(lane.index() as u32).unwrap_or(0), identity)
    }

    /// `complete` and the first `poll` in one, for a lane that asks for its own next unit: that lane is
    /// preferred, so a chain stays where its data is. Always inlined: it belongs in one place, the loop of a lane.
    /// Errors: as `complete`; nothing was polled then.
    #[inline(always)]
    pub fn complete_and_poll(&mut self, unit: UnitId, now: Instant) -> Result<Option<Action>, CompleteError> {
        self.complete(unit, now)?;
        self.next(self.now, 1 << unit.lane().index(), Ok)
    }

    // `answer` wraps the action where it is made: wrapped afterwards it would be copied.
    #[inline(always)]
    fn next<R>(&mut self, now: Instant, prefer: u32, answer: impl Fn(Option<Action>) -> R) -> R {
        if now >= self.alarm {
            cold_path();
            self.monitor_and_shed();
        }
        if self.ended != 0 || self.displaced.shed.is_some() {
            cold_path();
            return answer(self.take_outcome().map(Action::Ended));
        }
        // Each round starts a unit or closes a pool until the next event: at most LANES + POOLS rounds.
        while self.active != 0 {
            let pool = if C::POOLS == 1 { 0 } else { self.active.trailing_zeros() as usize };
            let free = self.pools[pool].free;
            if free != 0 {
                if let Some(unit) = self.fill(pool, free, prefer) {
                    return answer(Some(Action::Dispatch(Dispatch { unit, lane: unit.lane() })));
                }
            } else if self.config.preempt {
                cold_path();
                if let Some(action) = self.preempt(pool) {
                    return answer(Some(action));
                }
            }
            if self.pools[pool].ahead
                && let Some(unit) = self.promise(pool)
            {
                return answer(Some(Action::Ahead(Dispatch { unit, lane: unit.lane() })));
            }
            self.active &= !(1 << pool);
        }
        answer(None)
    }

    /// Re-assignment before a dispatch or a drop: every job's ready nodes by what remains of it now.
    #[cold]
    pub(super) fn reassign(&mut self) {
        for slot in self.slots() {
            self.residual_key(slot);
            self.requeue(slot);
        }
        self.stale_keys = false;
    }

    /// Starts one unit in a pool that has `free` lanes.
    #[inline(always)]
    fn fill(&mut self, pool: usize, free: u32, prefer: u32) -> Option<UnitId> {
        if self.stale_keys && self.queued_in(pool) > 0 {
            self.reassign();
        }
        let (slot, rank) = self.first(pool)?;
        let wanted = free & prefer;
        let lane = if wanted != 0 { wanted.trailing_zeros() } else { free.trailing_zeros() };
        let lane = if C::LANES == 1 { 0 } else { lane as usize };
        let version = self.version(slot);
        if !version.is_plain || !self.pools[pool].is_plain {
            cold_path();
            return self.start_with_care(pool, slot, rank, lane);
        }
        Some(self.start(slot, rank, version.order[rank], lane))
    }

    /// The head of the pool.
    #[inline(always)]
    pub(super) fn first(&mut self, pool: usize) -> Option<(usize, usize)> {
        let slot = self.pick(pool)?;
        Some((slot, self.head_of(slot, pool)?))
    }

    /// The job whose head is first, made the pool's current one.
    #[inline(always)]
    fn pick(&mut self, pool: usize) -> Option<usize> {
        let p = &self.pools[pool];
        if p.queue.is_empty() {
            return usize::from(p.current).checked_sub(1);
        }
        cold_path();
        self.pick_among(pool)
    }

    fn pick_among(&mut self, pool: usize) -> Option<usize> {
        let (queued, key) = self.pools[pool].queue.peek()?;
        let current = usize::from(self.pools[pool].current).checked_sub(1);
        let own = current.and_then(|slot| Some((self.rank_key(slot, self.head_of(slot, pool)?), slot)));
        if let Some((own, current)) = own
            && own < key
        {
            return Some(current);
        }
        let pool = &mut self.pools[pool];
        pool.queue.pop();
        if let Some((own, current)) = own {
            pool.queue.push(current, own);
        }
        pool.current = queued as u8 + 1;
        Some(queued)
    }
}
