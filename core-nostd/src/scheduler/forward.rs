//! The forward schedule: what happens from now on if nothing else comes and every node takes its estimate.
//!
//! *Rule.* Lanes are taken up as they are: each is free when what is left of its unit has passed. Then the rule that
//! dispatches is run forward by the keys of now, over a group of jobs in flight. An encoder whose result is kept, or
//! is computed on the way, runs once for all of the group. What another job holds of a lane stays held until it ends.
//! *What it leaves out.* Memory budgets, merging beyond one run per result, level gates, lanes that wait, promises.
//! *Time bound.* O(jobs + lanes + successors) for each node that starts or ends, with encoders O(jobs * encoders).

use super::{Scheduler, bits, outlook::Case, pools::Rank};
use crate::capacity::{Capacity, Empty};
use crate::graph::NodeSet;
use crate::policy::frame_cache::{FrameKey, OutputState};

/// How the jobs of a group end in a forward schedule. Instants are in nanoseconds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Forward<C: Capacity> {
    /// When each job ends; the end of time where it never does.
    pub(super) end: C::Jobs<u64>,
    /// When each job next starts a node; the end of time where it starts none.
    first: C::Jobs<u64>,
    /// The pools in which it starts any.
    pools: C::Jobs<u32>,
    /// Jobs that end after their deadline, a bit each.
    pub(super) late: u64,
    /// The least time between the end and the deadline of a job that is not late; the longest time without one.
    pub(super) laxity: u64,
}

impl<C: Capacity> Forward<C> {
    /// Of some jobs, those that start a node before another one ends, in a pool that this one still needs.
    pub(super) fn in_the_way(&self, of: usize, among: u64) -> u64 {
        let meets = |slot: &usize| self.first[*slot] < self.end[of] && self.share_a_pool(of, *slot);
        bits(among).filter(meets).fold(0, |set, slot| set | 1 << slot)
    }

    /// Whether two jobs start nodes in a common pool.
    pub(super) fn share_a_pool(&self, one: usize, other: usize) -> bool {
        self.pools[one] & self.pools[other] != 0
    }
}

crate::capacity::stored! {
    /// A job on its way.
    #[derive(Clone, Copy, Debug)]
    struct Going<C: Capacity> {
        ready: NodeSet<C>,
        /// Started or done.
        gone: NodeSet<C>,
        /// Encoders whose result is being computed, and those whose result is there.
        held: NodeSet<C>,
        served: NodeSet<C>,
        waiting_for: C::Nodes<u8>,
        left: u32,
    }
}

crate::capacity::stored! {
    /// What a lane is taken by.
    #[derive(Clone, Copy, Debug)]
    struct Taken {
        end: u64,
        slot: u8,
        rank: u8,
        /// Whether it started in the forward schedule; else it is the scheduler's own unit.
        is_new: bool,
    }
}

crate::capacity::stored! {
    /// A sub-job that lost its lane on the way, and what is left of it.
    #[derive(Clone, Copy, Debug)]
    struct Stopped {
        left: u64,
        /// Plus one; 0 is a free place.
        slot: u8,
        rank: u8,
    }
}

/// A forward schedule on its way.
struct Course<'a, C: Capacity> {
    scheduler: &'a Scheduler<C>,
    now: u64,
    group: u64,
    jobs: C::Jobs<Going<C>>,
    /// By pool and job: key of the first ready node, the largest where nothing is ready.
    heads: C::Pools<C::Jobs<i64>>,
    lanes: C::Lanes<Taken>,
    busy: u32,
    stopped: C::Lanes<Stopped>,
    /// Whether encoders of different jobs may share a result.
    shares: bool,
    forward: Forward<C>,
}

const NOTHING: i64 = i64::MAX;

impl<C: Capacity> Scheduler<C> {
    /// The forward schedule of a group of jobs in flight, a bit each.
    #[cold]
    pub(super) fn forward(&self, group: u64) -> Forward<C> {
        let forward = Forward {
            end: Empty::EMPTY,
            first: Empty::EMPTY,
            pools: Empty::EMPTY,
            late: 0,
            laxity: u64::MAX,
        };
        let mut course = Course {
            scheduler: self,
            now: self.now.as_nanos(),
            group,
            jobs: Empty::EMPTY,
            heads: Empty::EMPTY,
            lanes: Empty::EMPTY,
            busy: 0,
            stopped: Empty::EMPTY,
            shares: self.config.frame_cache
                && bits(group).any(|slot| !self.version(slot).encoders.is_empty()),
            forward,
        };
        course.set_out();
        // Each round ends a unit: at most as many rounds as nodes, lanes and losses of a lane.
        loop {
            self.pool_numbers().for_each(|pool| course.fill(pool));
            let Some(next) = bits(course.busy.into()).map(|lane| course.lanes[lane].end).min() else { break };
            course.now = next;
            for lane in bits(course.busy.into()) {
                if course.lanes[lane].end == next {
                    course.finish(lane);
                }
            }
        }
        course.judge()
    }
}

impl<C: Capacity> Course<'_, C> {
    /// Takes everything up as it is now.
    fn set_out(&mut self) {
        let s = self.scheduler;
        for slot in bits(self.group) {
            s.pool_numbers().for_each(|pool| self.heads[pool][slot] = NOTHING);
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
        for slot in bits(self.group) {
            self.serve(slot);
        }
    }

    /// Fills the free lanes of a pool in order of dispatch; with preemption, takes lanes from larger keys too.
    fn fill(&mut self, pool: usize) {
        while let Some(slot) = self.first_in(pool) {
            let free = self.scheduler.pools[pool].lanes & !self.busy;
            if free == 0 && !(self.scheduler.config.preempt && self.stop_one(pool, slot)) {
                return;
            }
            let free = self.scheduler.pools[pool].lanes & !self.busy;
            self.start(pool, slot, free.trailing_zeros() as usize);
        }
    }

    /// The job whose head is first in a pool.
    fn first_in(&self, pool: usize) -> Option<usize> {
        let heads = &self.heads[pool];
        let tie = |slot: usize| {
            let job = &self.scheduler.jobs[slot];
            (job.release, job.task.index(), job.index)
        };
        let mut first: Option<usize> = None;
        for slot in bits(self.group) {
            let key = heads[slot];
            let is_first = match first {
                _ if key == NOTHING => false,
                Some(least) => key < heads[least] || key == heads[least] && tie(slot) < tie(least),
                None => true,
            };
            first = if is_first { Some(slot) } else { first };
        }
        first
    }

    fn head_of(&self, pool: usize, slot: usize) -> Option<usize> {
        self.jobs[slot].ready.first_in(&self.scheduler.version(slot).in_pool[pool])
    }

    /// Brings the heads of a job up to date after its ready set changed.
    fn requeue(&mut self, slot: usize) {
        let (s, version) = (self.scheduler, self.scheduler.version(slot));
        for pool in bits(version.pool_mask.into()) {
            let key = |rank| s.jobs[slot].key_of(version, rank, s.residual).min(NOTHING - 1);
            self.heads[pool][slot] = self.head_of(pool, slot).map_or(NOTHING, key);
        }
    }

    /// Starts the head of a job on a free lane.
    fn start(&mut self, pool: usize, slot: usize, lane: usize) {
        let Some(rank) = self.head_of(pool, slot) else { return };
        let s = self.scheduler;
        let place = self
            .stopped
            .as_ref()
            .iter()
            .position(|x| usize::from(x.slot) == slot + 1 && usize::from(x.rank) == rank);
        let left = match place {
            Some(place) => core::mem::replace(&mut self.stopped[place], Stopped::EMPTY).left,
            None => s.left_of(&s.jobs[slot], slot, rank, Case::Expected),
        };
        let going = &mut self.jobs[slot];
        going.ready.remove(rank);
        going.gone.insert(rank);
        let end = self.now.saturating_add(left);
        self.lanes[lane] = Taken { end, slot: slot as u8, rank: rank as u8, is_new: true };
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

    /// Does something to each encoder of a key that has not started, and brings its job's heads up to date.
    fn each_of(&mut self, key: FrameKey, mut act: impl FnMut(&mut Going<C>, usize)) {
        let s = self.scheduler;
        for slot in bits(self.group) {
            let mut is_changed = false;
            for encoder in s.version(slot).encoders.without(&self.jobs[slot].gone).iter() {
                if s.frame_key(&s.jobs[slot], encoder) == Some(key) {
                    act(&mut self.jobs[slot], encoder);
                    is_changed = true;
                }
            }
            if is_changed {
                self.requeue(slot);
            }
        }
    }

    /// The unit on a lane ends.
    fn finish(&mut self, lane: usize) {
        let (s, taken) = (self.scheduler, self.lanes[lane]);
        self.busy &= !(1 << lane);
        let key = if taken.is_new {
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
    fn settle(&mut self, slot: usize, rank: usize) {
        let going = &mut self.jobs[slot];
        going.left = going.left.saturating_sub(1);
        if going.left == 0 {
            self.forward.end[slot] = self.now;
        }
        self.scheduler.version(slot).successors[rank].each(|s| {
            going.waiting_for[s] = going.waiting_for[s].saturating_sub(1);
            going.ready.insert_if(s, going.waiting_for[s] == 0 && !going.gone.contains(s));
        });
    }

    /// Ready encoders of a job whose result is there are done, those whose result is being computed wait.
    fn serve(&mut self, slot: usize) {
        // Each round takes an encoder out of the ready set: at most as many rounds as nodes.
        while self.shares
            && let going = &mut self.jobs[slot]
            && let mut met = going.served
            && let () = met.extend(&going.held)
            && let Some(encoder) = going.ready.first_in(&met)
        {
            going.ready.remove(encoder);
            if going.served.contains(encoder) {
                going.gone.insert(encoder);
                self.settle(slot, encoder);
            }
        }
        self.requeue(slot);
    }

    /// Takes a lane of a full pool for a head, if a larger key runs there.
    fn stop_one(&mut self, pool: usize, head: usize) -> bool {
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

    /// Who is late, and how close the others are.
    fn judge(mut self) -> Forward<C> {
        for slot in bits(self.group) {
            let due = self.scheduler.jobs[slot].deadline.as_nanos();
            match due.checked_sub(self.forward.end[slot]) {
                Some(laxity) => self.forward.laxity = self.forward.laxity.min(laxity),
                None => self.forward.late |= 1 << slot,
            }
        }
        self.forward
    }
}
