//! Dispatch ahead: a node is handed out while its predecessors still run, for lanes that order work by themselves, such
//! as the streams of a GPU.
//!
//! *Rule.* When nothing more can start in a pool that dispatches ahead, a node whose unfinished predecessors all run in
//! that pool is promised a lane, if it precedes every node that is ready there and all others of its kind: behind that
//! predecessor which should end last and has nothing behind it yet, else on an idle lane. A lane has one promise.
//! Encoders get none, because their result may be there by then, nor does what follows an encoder that has ended, nor a
//! job that is known to be late, because it may be given up.
//! *What it means.* The host gives the unit to its lane at once, and the lane starts it after what it runs and after
//! [`Scheduler::waits_for`]. To the scheduler the sub-job waits on: its lane is taken and its memory held, nothing
//! else. It starts with the report that its last predecessor ended. Whoever reports the unit itself first says with that
//! that its predecessors ended. If its job is given up meanwhile, the lane stays busy with nobody's unit until that is
//! reported, as with one that runs.
//! *Why Lemma 1 holds.* A lane and what the host makes of `waits_for` start a unit after its predecessors, and the
//! scheduler counts it as started only after them.
//! *What it costs.* A lane that waits for predecessors elsewhere works for nobody: at most as long as the longest of
//! them takes, which certificates add to the node's cost.

use super::{
    Scheduler,
    action::ShedReason,
    bits,
    complete::CompleteError,
    units::{Beside, Unit},
};
use crate::capacity::{Capacity, Empty};
use crate::config::Gate;
use crate::graph::NodeSet;
use crate::id::{PoolId, UnitId};

impl<C: Capacity> Scheduler<C> {
    /// Has a pool dispatch ahead: `poll` answers [`Action::Ahead`](crate::Action::Ahead) there, and certificates take it
    /// into account. `false`, and nothing changed: no such pool, or the configuration preempts or opens graphs level by
    /// level.
    pub fn dispatch_ahead(&mut self, pool: PoolId) -> bool {
        let can = !self.config.preempt && self.config.gate == Gate::Precedence;
        can && self.pool_mut(pool).map(|pool| pool.ahead = true).is_some()
    }

    /// Units of other lanes after which this one, dispatched ahead, has to start. None once it counts as started.
    pub fn waits_for(&self, unit: UnitId) -> impl Iterator<Item = UnitId> + '_ {
        let lanes = self.promise_of(unit).filter(|lane| !self.beside[*lane].broken).map_or(0, |lane| {
            let Beside { slot, rank, .. } = self.beside[lane];
            self.leaders(slot.into(), rank.into()).1 & !(1 << lane)
        });
        bits(lanes.into()).map(|lane| self.lanes[lane].unit)
    }

    /// The lane on which a unit waits.
    pub(super) fn promise_of(&self, unit: UnitId) -> Option<usize> {
        let lane = unit.lane().index();
        (lane < C::LANES && self.promised >> lane & 1 != 0 && self.beside[lane].word == unit.to_bits())
            .then_some(lane)
    }

    pub(super) fn unit_ahead(&self, unit: UnitId) -> Option<Unit> {
        let lane = self.promise_of(unit).filter(|lane| !self.beside[*lane].broken)?;
        let (slot, rank) = (usize::from(self.beside[lane].slot), usize::from(self.beside[lane].rank));
        let version = self.version(slot);
        let encoder = version.encoder_of(rank).filter(|_| version.decoders.contains(rank));
        let output =
            encoder.map_or(0, |encoder| self.lanes[usize::from(self.jobs[slot].place[encoder])].output);
        Some(self.told(slot, rank, lane, self.now, output))
    }

    /// The cost of what waits on a lane; 0 of what nobody needs any more.
    pub(super) fn promised_cost(&self, lane: usize) -> u64 {
        let Beside { slot, rank, broken, .. } = self.beside[lane];
        if broken { 0 } else { self.node(slot.into(), rank.into()).cost() }
    }

    /// How many predecessors of a rank run, and on which lanes.
    pub(super) fn leaders(&self, slot: usize, rank: usize) -> (u8, u32) {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let leads = job.running.iter().filter(|leader| version.successors[*leader].contains(rank));
        leads.fold((0, 0), |(count, lanes), leader| (count + 1, lanes | 1 << (job.place[leader] % 32)))
    }

    /// Promises a lane, if there is a node for it. Time bound: O(lanes * nodes + jobs).
    #[cold]
    pub(super) fn promise(&mut self, pool: usize) -> Option<UnitId> {
        let (slot, rank, lane) =
            self.foreseen(pool).filter(|(slot, rank, _)| self.may_start(pool, *slot, *rank))?;
        let node = self.version(slot).order[rank];
        let memory = self.footprint(slot, rank, pool);
        self.counters.units += 1;
        let unit = UnitId::new(self.counters.units, node, lane);
        self.beside[lane] =
            Beside { word: unit.to_bits(), slot: slot as u8, rank: rank as u8, broken: false };
        self.promised |= 1 << lane;
        // Their ends, and that of what runs before it, keep the promise.
        bits(self.leaders(slot, rank).1.into()).for_each(|leader| self.lanes[leader].leads = true);
        let pool = &mut self.pools[pool];
        pool.free &= !(1 << lane);
        pool.used += memory;
        Some(unit)
    }

    /// The most pressing node that may go ahead: job, rank, and the lane for it.
    fn foreseen(&self, pool: usize) -> Option<(usize, usize, usize)> {
        let mut first = None;
        for leader in bits(self.pools[pool].lanes.into()).filter(|lane| self.lanes[*lane].is_busy()) {
            // Who will be late may have to go, and a stream gives nothing back.
            for slot in bits(self.lanes[leader].members).filter(|slot| !self.is_warned_of(*slot)) {
                let version = self.version(slot);
                let mut after = NodeSet::EMPTY;
                self.ranks_on(slot, leader).for_each(|rank| after.extend(&version.successors[rank]));
                // Of an encoder that runs again, some are done or run.
                let (done, running) = (&self.jobs[slot].done, &self.jobs[slot].running);
                let after = after.and(&version.in_pool[pool]).without(&version.encoders);
                for rank in after.without(done).without(running).iter() {
                    if self.may_go_ahead(pool, slot, rank) {
                        let this = (self.rank_key(slot, rank), rank, slot);
                        first = Some(first.map_or(this, |first| this.min(first)));
                    }
                }
            }
        }
        let (key, rank, slot) = first?;
        let ready = self.most_pressing(pool, |_, _| true);
        let is_first = ready.is_none_or(|(slot, rank)| key < self.rank_key(slot, rank));
        let lane = if is_first { self.place_ahead(pool, slot, rank) } else { None };
        lane.map(|lane| (slot, rank, lane))
    }

    fn may_go_ahead(&self, pool: usize, slot: usize, rank: usize) -> bool {
        let (p, job, version) = (&self.pools[pool], &self.jobs[slot], self.version(slot));
        let (count, lanes) = self.leaders(slot, rank);
        let is_next = count == job.waiting_for[rank] && lanes & !p.lanes == 0;
        let is_promised = |lane: usize| {
            let promise = &self.beside[lane];
            usize::from(promise.slot) == slot && usize::from(promise.rank) == rank && !promise.broken
        };
        // A result may have to go before the last of the others has ended, and is computed again then.
        let has_result =
            version.encoders.and(&job.done).iter().any(|encoder| version.successors[encoder].contains(rank));
        is_next && !has_result && !bits(self.promised.into()).any(is_promised) && self.fits(pool, slot, rank)
    }

    /// The lane for a rank that may go ahead.
    fn place_ahead(&self, pool: usize, slot: usize, rank: usize) -> Option<usize> {
        let (p, lanes) = (&self.pools[pool], self.leaders(slot, rank).1);
        let ends = |lane: &usize| {
            let l = &self.lanes[*lane];
            l.started.saturating_add(self.node(l.slot.into(), l.rank.into()).wcet.get())
        };
        // Of equal ends the lowest lane.
        let behind = bits((lanes & !self.promised).into()).fold(None, |last: Option<usize>, lane| {
            last.filter(|last| ends(last) >= ends(&lane)).or(Some(lane))
        });
        behind.or_else(|| bits(p.free.into()).next())
    }

    /// Starts what waits on idle lanes and has nothing to wait for any more.
    pub(super) fn keep_promises(&mut self) {
        for lane in bits(self.promised.into()) {
            let Beside { slot, rank, broken, .. } = self.beside[lane];
            if !self.lanes[lane].is_busy()
                && (broken || self.jobs[usize::from(slot)].ready.contains(rank.into()))
            {
                self.start_promised(lane);
            }
        }
    }

    fn start_promised(&mut self, lane: usize) {
        let Beside { word, slot, rank, broken } = self.take_promise(lane);
        let unit = UnitId::from_bits(word);
        let (slot, rank) = (usize::from(slot), usize::from(rank));
        if broken {
            let l = &mut self.lanes[lane];
            (l.unit, l.started, l.members, l.merged, l.output) = (unit, self.now, 0, true, 0);
            return;
        }
        self.start_as(unit, slot, rank, lane);
        let encoder = self.version(slot).encoder_of(rank);
        let reads = encoder.filter(|_| self.version(slot).decoders.contains(rank));
        self.lanes[lane].output = reads.map_or(0, |encoder| self.jobs[slot].place[encoder].into());
        self.lanes[lane].memory = self.footprint(slot, rank, usize::from(self.lanes[lane].pool));
        self.requeue(slot);
    }

    /// What a rank holds of its pool, where that has a budget.
    fn footprint(&self, slot: usize, rank: usize, pool: usize) -> u64 {
        if self.pools[pool].limited { self.node(slot, rank).memory.0 } else { 0 }
    }

    fn take_promise(&mut self, lane: usize) -> Beside {
        self.promised &= !(1 << lane);
        core::mem::replace(&mut self.beside[lane], Beside::EMPTY)
    }

    /// A job was given up: what it was promised goes back but for the lane, which has it until that is reported.
    pub(super) fn break_promises(&mut self, slot: usize) {
        for lane in bits(self.promised.into()) {
            let Beside { slot: of, rank, .. } = self.beside[lane];
            if usize::from(of) != slot || self.beside[lane].broken {
                continue;
            }
            let pool = usize::from(self.lanes[lane].pool);
            self.pools[pool].used -= self.footprint(slot, rank.into(), pool);
            self.beside[lane].broken = true;
            if !self.lanes[lane].is_busy() {
                self.start_promised(lane);
            }
        }
    }

    /// A unit that does not run was reported as done: if it waited on its lane, then so is what it waited for.
    #[cold]
    pub(super) fn complete_ahead(&mut self, unit: UnitId) -> Result<(), CompleteError> {
        let lane = self.promise_of(unit).ok_or_else(|| self.refuse(unit))?;
        let Beside { slot, rank, broken, .. } = self.beside[lane];
        let before = if broken {
            u32::from(self.lanes[lane].is_busy()) << lane
        } else {
            self.leaders(slot.into(), rank.into()).1
        };
        for leader in bits(before.into()) {
            // Late, where nobody wanted it any more.
            let _counted = self.complete_shared(leader);
        }
        debug_assert!(self.lanes[lane].unit == unit, "nothing else keeps it from starting");
        self.complete_shared(lane)
    }

    /// A unit that does not run failed.
    #[cold]
    pub(super) fn fail_ahead(&mut self, unit: UnitId) -> Result<(), CompleteError> {
        let lane = self.promise_of(unit).ok_or_else(|| self.refuse(unit))?;
        let Beside { slot, rank, broken, .. } = self.take_promise(lane);
        let pool = usize::from(self.lanes[lane].pool);
        if !broken {
            self.pools[pool].used -= self.footprint(slot.into(), rank.into(), pool);
        }
        self.pools[pool].free |= u32::from(!self.lanes[lane].is_busy()) << lane;
        self.activate(pool);
        if !broken {
            self.end_job(slot.into(), Some(ShedReason::Fault));
        }
        self.was_wanted(u64::from(!broken))
    }
}
