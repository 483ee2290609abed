//! `poll`: the only place that picks what runs.

use super::Scheduler;
use super::action::Action;
use crate::capacity::Capacity;
use crate::id::UnitId;
use crate::scheduler::complete::CompleteError;
use crate::time::Instant;

impl<C: Capacity> Scheduler<C> {
    /// The next thing to do, or `None` until something happens or `poll_at` comes. Never blocks; between two
    /// events it answers at most once per lane and ended job.
    ///
    /// Time bound: O(log jobs) per dispatched node; see the table of the crate for the rest.
    #[must_use = "an action that is not carried out is lost"]
    #[inline]
    pub fn poll(&mut self, now: Instant) -> Option<Action> {
        let now = self.advance(now);
        self.next(now, 0)
    }

    /// `complete` and the first `poll` in one, for a lane that asks for its own next unit: that lane is
    /// preferred, so a chain stays where its data is.
    ///
    /// # Errors
    /// As `complete`; nothing was polled then.
    #[inline]
    pub fn complete_and_poll(&mut self, unit: UnitId, now: Instant) -> Result<Option<Action>, CompleteError> {
        self.complete(unit, now)?;
        let now = self.now;
        Ok(self.next(now, 1 << unit.lane().index()))
    }

    #[inline(always)]
    fn next(&mut self, now: Instant, prefer: u32) -> Option<Action> {
        if now >= self.alarm {
            self.monitor_and_shed();
        }
        if self.ended != 0 {
            return self.take_outcome().map(Action::Ended);
        }
        // Each round starts a unit or closes a pool until the next event: at most LANES + POOLS rounds.
        while self.active != 0 {
            let pool = if C::POOLS == 1 { 0 } else { self.active.trailing_zeros() as usize };
            if let Some(action) = self.fill(pool, prefer) {
                return Some(action);
            }
            self.active &= !(1 << pool);
        }
        None
    }

    /// Re-assignment before a dispatch: every job's ready nodes by what remains of it now.
    #[cold]
    fn reassign(&mut self) {
        for slot in self.slots() {
            self.residual_key(slot);
            self.requeue(slot);
        }
        self.stale_keys = false;
    }

    /// Starts one unit in a pool.
    #[inline(always)]
    fn fill(&mut self, pool: usize, prefer: u32) -> Option<Action> {
        let free = self.pools[pool].free;
        if free == 0 {
            return if self.config.preempt { self.preempt(pool) } else { None };
        }
        if self.stale_keys && self.queued_in(pool) > 0 {
            self.reassign();
        }
        let slot = self.pick(pool)?;
        let rank = self.head_of(slot, pool)?;
        let wanted = free & prefer;
        let lane = if wanted != 0 { wanted.trailing_zeros() } else { free.trailing_zeros() } as usize;
        let version = self.version(slot);
        if version.encoders.contains(rank) || version.decoders.contains(rank) || self.pools[pool].limited {
            return self.start_with_care(pool, slot, rank, lane);
        }
        Some(self.start(slot, rank, lane))
    }

    /// The job whose head is first, made the pool's current one.
    #[inline(always)]
    pub(super) fn pick(&mut self, pool: usize) -> Option<usize> {
        let p = &self.pools[pool];
        let current = usize::from(p.current);
        if p.queue.is_empty() {
            return current.checked_sub(1);
        }
        self.pick_among(pool)
    }

    fn pick_among(&mut self, pool: usize) -> Option<usize> {
        let (queued, key) = self.pools[pool].queue.peek()?;
        if let Some(current) = usize::from(self.pools[pool].current).checked_sub(1)
            && let Some(rank) = self.head_of(current, pool)
        {
            let own = self.rank_key(current, rank);
            if own < key {
                return Some(current);
            }
            self.pools[pool].queue.pop();
            self.pools[pool].queue.push(current, own);
        } else {
            self.pools[pool].queue.pop();
        }
        self.pools[pool].current = queued as u8 + 1;
        Some(queued)
    }
}
