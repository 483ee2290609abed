//! Preemption in a forward schedule, by the rule of the scheduler.

use super::course::Course;
use crate::capacity::{Capacity, Empty};
use crate::scheduler::{bits, pools::Rank};

crate::capacity::stored! {
    /// A sub-job that lost its lane on the way, and what is left of it.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Stopped {
        pub(super) left: u64,
        /// Plus one; 0 is a free place.
        pub(super) slot: u8,
        pub(super) rank: u8,
    }
}

impl<C: Capacity> Course<'_, C> {
    /// What is left of a sub-job that lost its lane, which has one again now.
    pub(super) fn resume(&mut self, slot: usize, rank: usize) -> Option<u64> {
        let is_it = |x: &&mut Stopped| usize::from(x.slot) == slot + 1 && usize::from(x.rank) == rank;
        let stopped = self.stopped.as_mut().iter_mut().find(is_it)?;
        Some(core::mem::replace(stopped, Stopped::EMPTY).left)
    }

    /// Takes a lane of a full pool for a head, if a larger key runs there.
    pub(super) fn stop_one(&mut self, pool: usize, head: usize) -> bool {
        let s = self.scheduler;
        let rank_of = |slot: usize, rank: usize| -> Rank { s.rank_key(slot, rank) };
        let Some(first) = self.head_of(pool, head).map(|rank| rank_of(head, rank)) else { return false };
        let running = |lane: usize| {
            let (taken, l) = (&self.lanes[lane], &s.lanes[lane]);
            let (slot, rank) = if taken.is_new { (taken.slot, taken.rank) } else { (l.slot, l.rank) };
            let (slot, rank) = (usize::from(slot), usize::from(rank));
            let keeps_lane = !taken.is_new && (l.is_encoder || l.merged || l.members & self.group == 0);
            let keeps_lane =
                keeps_lane || s.node(slot, rank).atomic || s.version(slot).encoders.contains(rank);
            (!keeps_lane).then(|| (rank_of(slot, rank), rank, slot, lane))
        };
        let last = bits((s.pools[pool].lanes & self.busy).into()).filter_map(running).max();
        let place = self.stopped.as_ref().iter().position(|stopped| stopped.slot == 0);
        let (Some((key, rank, slot, lane)), Some(place)) = (last, place) else { return false };
        if key <= first {
            return false;
        }
        let left = self.lanes[lane].end.saturating_sub(self.now);
        self.stopped[place] = Stopped { left, slot: slot as u8 + 1, rank: rank as u8 };
        self.busy &= !(1 << lane);
        self.jobs[slot].gone.remove(rank);
        self.jobs[slot].ready.insert(rank);
        self.requeue(slot);
        true
    }
}
