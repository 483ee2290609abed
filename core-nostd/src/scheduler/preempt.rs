//! Preemption, for hosts whose lanes can give a unit back: the simulator, and analysis by simulation.
//!
//! *Rule.* When no lane is free and the head's key is smaller than the largest key that runs, that unit loses its
//! lane and is ready again with what it has done. Atomic nodes and encoders keep lanes: an encoder's result may be
//! waited for. Where memory is short encoders take none: their result may have to go for the unit that lost it.
//! As many sub-jobs as there are lanes may be suspended at a time.

use super::action::{Action, Dispatch};
use super::units::Beside;
use super::{Scheduler, bits, event::EventKind};
use crate::capacity::{Capacity, Empty};
use crate::time::Duration;

impl<C: Capacity> Scheduler<C> {
    /// Takes a lane of a full pool for its head, if a larger key runs there. The next `poll` starts the head.
    #[cold]
    pub(super) fn preempt(&mut self, pool: usize) -> Option<Action> {
        let (job, first) = self.first(pool)?;
        let (head, is_encoder) = (self.rank_key(job, first), self.version(job).encoders.contains(first));
        let running = |lane: usize| {
            let l = &self.lanes[lane];
            let (slot, rank) = (usize::from(l.slot), usize::from(l.rank));
            let keeps_lane = self.node(slot, rank).atomic || l.is_encoder || l.merged || l.members == 0;
            (!keeps_lane).then(|| (self.rank_key(slot, rank), rank, slot, lane))
        };
        let (key, rank, slot, lane) = bits(self.pools[pool].lanes.into()).filter_map(running).max()?;
        let place = self.beside.as_ref().iter().position(|s| s.slot == 0)?;
        if key <= head || is_encoder && self.pools[pool].limited {
            return None;
        }
        let word = self.executed_on(lane).as_nanos();
        self.beside[place] = Beside { word, slot: slot as u8 + 1, rank: rank as u8, ..Beside::EMPTY };
        self.note(EventKind::Preempted, slot, rank, lane);
        let unit = self.lanes[lane].unit;
        self.free(lane);
        let job = &mut self.jobs[slot];
        job.running.remove(rank);
        job.ready.insert(rank);
        job.place[rank] = 0;
        self.requeue(slot);
        Some(Action::Preempt(Dispatch { unit, lane: unit.lane() }))
    }

    /// How long the unit on a lane has run, earlier turns of a preempted one included.
    pub(super) fn executed_on(&self, lane: usize) -> Duration {
        let l = &self.lanes[lane];
        self.now.since(l.started).saturating_add(l.carried)
    }

    pub(super) fn suspended_after(&self, slot: usize, rank: usize) -> Option<Duration> {
        let place = if self.config.preempt { self.suspended_place(slot, rank)? } else { return None };
        Some(Duration::from_nanos(self.beside[place].word))
    }

    pub(super) fn resume(&mut self, slot: usize, rank: usize) -> Duration {
        let place = if self.config.preempt { self.suspended_place(slot, rank) } else { None };
        let place = place.map(|place| &mut self.beside[place]);
        let word = place.map_or(0, |s| core::mem::replace(s, Beside::EMPTY).word);
        Duration::from_nanos(word)
    }

    pub(super) fn forget_suspended(&mut self, slot: usize) {
        if self.config.preempt {
            let gone = |s: &&mut Beside| usize::from(s.slot) == slot + 1;
            self.beside.as_mut().iter_mut().filter(gone).for_each(|s| *s = Beside::EMPTY);
        }
    }

    fn suspended_place(&self, slot: usize, rank: usize) -> Option<usize> {
        let here = |s: &Beside| usize::from(s.slot) == slot + 1 && usize::from(s.rank) == rank;
        self.beside.as_ref().iter().position(here)
    }
}
