//! What was dispatched ahead, in a forward schedule: its lane is nobody else's.

use super::course::{Course, Taken};
use crate::capacity::Capacity;
use crate::scheduler::{Scheduler, bits, outlook::Case, units::Beside};

/// A unit that waits on a lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::scheduler) struct Promised {
    slot: usize,
    rank: usize,
    /// Lanes whose units it waits for, a bit each; its own, if it is busy.
    pub(in crate::scheduler) after: u32,
    /// How long it takes by its estimate, in nanoseconds.
    left: u64,
}

impl<C: Capacity> Scheduler<C> {
    /// What waits on a lane; `None`: nothing that is wanted.
    pub(in crate::scheduler) fn promise_on(&self, lane: usize) -> Option<Promised> {
        let Beside { slot, rank, broken, .. } = self.beside[lane];
        let (slot, rank) = (usize::from(slot), usize::from(rank));
        let is_wanted = self.promised >> lane & 1 != 0 && !broken;
        is_wanted.then(|| {
            let own = u32::from(self.lanes[lane].is_busy()) << lane;
            let left = self.left_of(&self.jobs[slot], slot, rank, Case::Expected);
            Promised { slot, rank, after: own | self.leaders(slot, rank).1, left }
        })
    }
}

impl<C: Capacity> Course<'_, C> {
    /// What waits on a lane has it next, once all that it waits for has ended.
    pub(super) fn reserve(&mut self, lane: usize) {
        let Some(Promised { slot, rank, after, left }) = self.scheduler.promise_on(lane) else { return };
        let start = bits(after.into()).map(|before| self.lanes[before].end).fold(self.now, u64::max);
        let is_nobodys = self.group >> slot & 1 == 0;
        if !is_nobodys {
            self.jobs[slot].gone.insert(rank);
        }
        let end = start.saturating_add(left);
        self.next[lane] = Taken { end, slot: slot as u8, rank: rank as u8, is_new: true, is_nobodys };
        self.followed |= 1 << lane;
        if self.busy >> lane & 1 == 0 {
            self.follow(lane);
        }
    }

    /// A free lane goes on with what waits on it.
    pub(super) fn follow(&mut self, lane: usize) {
        if self.followed >> lane & 1 != 0 {
            self.lanes[lane] = self.next[lane];
            self.followed &= !(1 << lane);
            self.busy |= 1 << lane;
        }
    }
}
