//! Preemption, for hosts whose lanes can give a unit back: the simulator, and analysis by simulation.
//!
//! *Rule.* When no lane is free and the head's key is smaller than the largest key that runs, that unit loses
//! its lane and is ready again with what it has done. Atomic nodes and encoders keep their lanes: an encoder's
//! result may already be waited for. As many sub-jobs as there are lanes may be suspended at a time.

use super::Scheduler;
use super::action::{Action, Dispatch};
use super::event::EventKind;
use crate::capacity::{Capacity, Empty};
use crate::id::LaneId;
use crate::time::Duration;

crate::capacity::stored! {
    /// A preempted sub-job and how long it has run.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Suspended {
        /// Job slot plus one; 0 is a free place.
        slot: u8,
        rank: u8,
        executed: Duration,
    }
}

impl<C: Capacity> Scheduler<C> {
    /// Takes a lane of a full pool for its head, if a larger key runs there. The next `poll` starts the head.
    #[cold]
    pub(super) fn preempt(&mut self, pool: usize) -> Option<Action> {
        let slot = self.pick(pool)?;
        let rank = self.head_of(slot, pool)?;
        let head = self.rank_key(slot, rank);
        let running = |lane: &usize| {
            let l = &self.lanes[*lane];
            let (slot, rank) = (usize::from(l.slot), usize::from(l.rank));
            let pinned = l.is_encoder || l.merged || l.members == 0;
            !pinned && !self.node(slot, rank).atomic
        };
        let key = |lane: &usize| {
            let l = &self.lanes[*lane];
            (self.rank_key(usize::from(l.slot), usize::from(l.rank)), l.rank)
        };
        let lanes = super::bits(self.pools[pool].lanes.into());
        let lane = lanes.filter(running).max_by_key(key)?;
        let place = self.suspended.as_ref().iter().position(|s| s.slot == 0)?;
        let l = self.lanes[lane];
        let (victim, its_rank) = (usize::from(l.slot), usize::from(l.rank));
        if self.rank_key(victim, its_rank) <= head {
            return None;
        }
        let executed = self.executed_on(lane);
        self.suspended[place] = Suspended { slot: l.slot + 1, rank: l.rank, executed };
        self.note(EventKind::Preempted, victim, its_rank, lane);
        self.free(lane);
        let job = &mut self.jobs[victim];
        job.running.remove(its_rank);
        job.ready.insert(its_rank);
        job.place[its_rank] = 0;
        self.requeue(victim);
        Some(Action::Preempt(Dispatch { unit: l.unit, lane: LaneId::new(lane as u8) }))
    }

    /// How long the unit on a lane has run, earlier turns of a preempted one included.
    pub(super) fn executed_on(&self, lane: usize) -> Duration {
        let l = &self.lanes[lane];
        self.now.since(l.started).saturating_add(l.carried)
    }

    /// How long a suspended rank has run.
    pub(super) fn suspended_after(&self, slot: usize, rank: usize) -> Option<Duration> {
        if !self.config.preempt {
            return None;
        }
        Some(self.suspended[self.suspended_place(slot, rank)?].executed)
    }

    /// Takes a rank out of the table when it starts again.
    pub(super) fn resume(&mut self, slot: usize, rank: usize) -> Duration {
        let place = self.suspended_place(slot, rank).map(|place| &mut self.suspended[place]);
        place.map_or(Duration::ZERO, |s| core::mem::replace(s, Suspended::EMPTY).executed)
    }

    pub(super) fn forget_suspended(&mut self, slot: usize) {
        if self.config.preempt {
            let gone = |s: &&mut Suspended| usize::from(s.slot) == slot + 1;
            self.suspended.as_mut().iter_mut().filter(gone).for_each(|s| *s = Suspended::EMPTY);
        }
    }

    fn suspended_place(&self, slot: usize, rank: usize) -> Option<usize> {
        let here = |s: &Suspended| usize::from(s.slot) == slot + 1 && usize::from(s.rank) == rank;
        self.suspended.as_ref().iter().position(here)
    }
}
