//! A forward schedule on its way: lanes and jobs as they are taken up, filled and freed.

use super::Forward;
use super::heads::Heads;
use super::stop::Stopped;
use crate::capacity::{Capacity, Empty};
use crate::graph::NodeSet;
use crate::policy::frame_cache::OutputState;
use crate::scheduler::{Scheduler, bits, outlook::Case};

crate::capacity::stored! {
    /// A job on its way.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Going<C: Capacity> {
        pub(super) ready: NodeSet<C>,
        /// Started or done.
        pub(super) gone: NodeSet<C>,
        /// Encoders whose result is being computed, and those whose result is there.
        pub(super) held: NodeSet<C>,
        pub(super) served: NodeSet<C>,
        waiting_for: C::Nodes<u8>,
        left: u32,
    }
}

crate::capacity::stored! {
    /// What a lane is taken by.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Taken {
        pub(super) end: u64,
        pub(super) slot: u8,
        pub(super) rank: u8,
        /// Whether it started in the forward schedule; else it is the scheduler's own unit.
        pub(super) is_new: bool,
        /// Its job is not of the group.
        pub(super) is_nobodys: bool,
    }
}

/// A forward schedule on its way.
pub(super) struct Course<'a, C: Capacity> {
    pub(super) scheduler: &'a Scheduler<C>,
    pub(super) now: u64,
    pub(super) group: u64,
    behind: u64,
    pub(super) jobs: C::Jobs<Going<C>>,
    heads: Heads<C>,
    pub(super) lanes: C::Lanes<Taken>,
    pub(super) busy: u32,
    /// What was dispatched ahead on lanes that are busy, a bit each in `followed`.
    pub(super) next: C::Lanes<Taken>,
    pub(super) followed: u32,
    pub(super) stopped: C::Lanes<Stopped>,
    /// Whether encoders of different jobs may share a result.
    pub(super) shares: bool,
    forward: Forward<C>,
}

impl<'a, C: Capacity> Course<'a, C> {
    /// At its beginning, with nobody's end known.
    pub(super) fn new(scheduler: &'a Scheduler<C>, group: u64, behind: u64) -> Self {
        let has_encoders = |slot: usize| !scheduler.version(slot).encoders.is_empty();
        let mut new = Self {
            scheduler,
            now: scheduler.now.as_nanos(),
            group,
            behind,
            jobs: Empty::EMPTY,
            heads: Heads::of(scheduler, group),
            lanes: Empty::EMPTY,
            busy: 0,
            next: Empty::EMPTY,
            followed: 0,
            stopped: Empty::EMPTY,
            shares: scheduler.config.frame_cache && bits(group).any(has_encoders),
            forward: Forward::NEW,
        };
        new.set_out();
        new
    }

    /// Until nothing runs any more.
    pub(super) fn run(mut self) -> Forward<C> {
        while self.step(u64::MAX) {}
        self.forward.judged(self.scheduler, self.group)
    }

    /// Whether a job ends by its deadline; no longer than until that is known.
    pub(super) fn ends_in_time(mut self, slot: usize) -> bool {
        let due = self.scheduler.jobs[slot].deadline.as_nanos();
        while self.forward.end[slot] == u64::MAX && self.step(due) {}
        self.forward.end[slot] <= due
    }

    /// Fills the lanes, and goes on to the next end of a unit: false where there is none by `until`. Each step ends a
    /// unit: there are at most as many as nodes, lanes and losses of a lane.
    fn step(&mut self, until: u64) -> bool {
        self.scheduler.pool_numbers().for_each(|pool| self.fill(pool));
        let next = bits(self.busy.into()).map(|lane| self.lanes[lane].end).min();
        let Some(next) = next.filter(|next| *next <= until) else { return false };
        self.now = next;
        for lane in bits(self.busy.into()) {
            if self.lanes[lane].end == next {
                self.finish(lane);
            }
        }
        true
    }

    /// Takes everything up as it is now.
    fn set_out(&mut self) {
        let s = self.scheduler;
        for slot in bits(self.group) {
            let (job, going) = (&s.jobs[slot], &mut self.jobs[slot]);
            (going.ready, going.gone) = (job.ready, job.done);
            going.ready.extend(&job.parked);
            going.gone.extend(&job.running);
            (going.waiting_for, going.left) = (job.waiting_for, job.left);
            (self.forward.first[slot], self.forward.end[slot]) = (u64::MAX, u64::MAX);
            if self.shares {
                for encoder in s.version(slot).encoders.without(&going.gone).iter() {
                    match s.output_of(job, encoder) {
                        Some((_, OutputState::Kept)) => going.served.insert(encoder),
                        Some(_) => going.held.insert(encoder),
                        None => {}
                    }
                }
            }
        }
        for lane in (0..s.lanes()).filter(|lane| s.lanes[*lane].is_busy()) {
            self.lanes[lane] = Taken { end: self.now.saturating_add(s.left_on(lane)), ..Taken::EMPTY };
            self.busy |= 1 << lane;
        }
        for lane in bits(s.promised.into()) {
            self.reserve(lane);
        }
        for slot in bits(self.group) {
            self.serve(slot);
        }
    }

    /// Fills the free lanes of a pool in order of dispatch; with preemption, takes lanes from larger keys too.
    fn fill(&mut self, pool: usize) {
        // Each round starts a node.
        loop {
            let free = self.scheduler.pools[pool].lanes & !self.busy;
            if free == 0 && !self.scheduler.config.preempt {
                return;
            }
            let Some(slot) = self.heads.first(pool) else { return };
            if free == 0 && !self.stop_one(pool, slot) {
                return;
            }
            let free = self.scheduler.pools[pool].lanes & !self.busy;
            self.start(pool, slot, free.trailing_zeros() as usize);
        }
    }

    pub(super) fn head_of(&self, pool: usize, slot: usize) -> Option<usize> {
        self.jobs[slot].ready.first_in(&self.scheduler.version(slot).in_pool[pool])
    }

    /// Brings the heads of a job up to date after its ready set changed.
    pub(super) fn requeue(&mut self, slot: usize) {
        let (s, version) = (self.scheduler, self.scheduler.version(slot));
        let comes_first = |other: usize| {
            self.forward.end[other] == u64::MAX && s.version(other).pool_mask & version.pool_mask != 0
        };
        let is_held = self.behind >> slot & 1 != 0 && bits(self.group & !self.behind).any(comes_first);
        for pool in bits(version.pool_mask.into()) {
            let key = |rank| s.jobs[slot].queue_key(version, rank, s.residual);
            self.heads.set(pool, slot, self.head_of(pool, slot).filter(|_| !is_held).map(key));
        }
    }

    /// Starts the head of a job on a free lane.
    fn start(&mut self, pool: usize, slot: usize, lane: usize) {
        let Some(rank) = self.head_of(pool, slot) else { return };
        let s = self.scheduler;
        let estimate = || s.left_of(&s.jobs[slot], slot, rank, Case::Expected);
        let left = self.resume(slot, rank).unwrap_or_else(estimate);
        let going = &mut self.jobs[slot];
        going.ready.remove(rank);
        going.gone.insert(rank);
        let end = self.now.saturating_add(left);
        self.lanes[lane] = Taken { end, slot: slot as u8, rank: rank as u8, is_new: true, is_nobodys: false };
        self.busy |= 1 << lane;
        self.forward.first[slot] = self.forward.first[slot].min(self.now);
        self.forward.pools[slot] |= 1 << pool;
        if self.shares
            && let Some(key) = s.frame_key(&s.jobs[slot], rank)
        {
            self.each_of(key, |going, encoder| {
                going.held.insert(encoder);
                going.ready.remove(encoder);
            });
        }
        self.requeue(slot);
    }

    /// The unit on a lane ends.
    fn finish(&mut self, lane: usize) {
        let (s, taken) = (self.scheduler, self.lanes[lane]);
        self.busy &= !(1 << lane);
        self.follow(lane);
        let key = if taken.is_nobodys {
            None
        } else if taken.is_new {
            let (slot, rank) = (usize::from(taken.slot), usize::from(taken.rank));
            self.settle(slot, rank);
            self.serve(slot);
            s.frame_key(&s.jobs[slot], rank)
        } else {
            let l = &s.lanes[lane];
            for slot in bits(l.members & self.group) {
                s.ranks_on(slot, lane).for_each(|rank| self.settle(slot, rank));
                self.serve(slot);
            }
            let written = usize::from(l.output).checked_sub(1).filter(|_| l.is_encoder);
            written.map(|place| s.outputs[place].key())
        };
        if self.shares
            && let Some(key) = key
        {
            self.each_of(key, |going, encoder| {
                going.held.remove(encoder);
                going.served.insert(encoder);
                going.ready.insert_if(encoder, going.waiting_for[encoder] == 0);
            });
            bits(self.group).for_each(|slot| self.serve(slot));
        }
    }

    /// A sub-job is done: its successors may become ready, its job may end.
    pub(super) fn settle(&mut self, slot: usize, rank: usize) {
        let going = &mut self.jobs[slot];
        going.left = going.left.saturating_sub(1);
        if going.left == 0 {
            self.forward.end[slot] = self.now;
            bits(self.behind & self.group).for_each(|held| self.requeue(held));
        }
        let going = &mut self.jobs[slot];
        self.scheduler.version(slot).successors[rank].each(|s| {
            going.waiting_for[s] = going.waiting_for[s].saturating_sub(1);
            going.ready.insert_if(s, going.waiting_for[s] == 0 && !going.gone.contains(s));
        });
    }
}
