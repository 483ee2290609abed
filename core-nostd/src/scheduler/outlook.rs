//! How much of a job is left: longest remaining path, remaining work, the residual key.
//!
//! *Rule.* One reverse topological pass over nodes that are not done. A running node counts what is left of
//! it. In the best case an encoder whose result is kept counts 0, and one whose key is running ends with that
//! unit, whatever it would take itself.
//! *Why the best case is a proof.* No schedule can end a job before now plus its longest path at best-case
//! costs, so a job for which that is after the deadline is lost whatever is done.

use super::Scheduler;
use crate::capacity::{Capacity, Empty};
use crate::deadlines::exact::share;
use crate::policy::frame_cache::OutputState;
use crate::time::Duration;

/// Which execution times to count with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Case {
    Best,
    Worst,
}

/// Which kept results may go when memory is short.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rest {
    WithoutReadyDecoder,
    NotReadByHead,
    All,
}

impl<C: Capacity> Scheduler<C> {
    /// Longest path of what is left of a job, in nanoseconds. Time bound: O(nodes + edges).
    pub(super) fn remaining_path(&self, slot: usize, case: Case) -> u64 {
        let (job, version) = (&self.jobs[slot], self.version(slot));
        let mut path = <C::Nodes<u64>>::EMPTY;
        let mut longest = 0;
        for i in (0..usize::from(version.len)).rev() {
            let rank = usize::from(version.topological[i]);
            if job.done.contains(rank) {
                continue;
            }
            let mut after = 0;
            version.successors[rank].each(|s| after = after.max(path[s]));
            let (chained, alone) = self.left_of(slot, rank, case);
            path[rank] = after.saturating_add(chained);
            longest = longest.max(after.saturating_add(alone));
        }
        longest
    }

    /// What is left of a rank that is not done, in nanoseconds: behind its predecessors, and from now on.
    ///
    /// They differ for an encoder whose key runs elsewhere: it ends when both its predecessors and that unit
    /// have, so behind its predecessors it may cost nothing.
    fn left_of(&self, slot: usize, rank: usize, case: Case) -> (u64, u64) {
        let whole = match case {
            Case::Best => self.best_case(slot, rank),
            Case::Worst => self.node(slot, rank).cost(),
        };
        if let Some(executed) = self.executed(slot, rank) {
            let left = whole.saturating_sub(executed.as_nanos());
            return (left, left);
        }
        match (case, self.output_of(slot, rank)) {
            (Case::Best, Some(OutputState::Kept)) => (0, 0),
            (Case::Best, Some(OutputState::Running(lane))) => (0, self.left_on(usize::from(lane))),
            _ => (whole, whole),
        }
    }

    /// What is left, at best, of the encoder's unit that runs on a lane, in nanoseconds.
    fn left_on(&self, lane: usize) -> u64 {
        self.lanes[lane].best.saturating_sub(self.executed_on(lane).as_nanos())
    }

    /// Whether an encoder of the job has to wait for a running one of its key that takes longer than itself would:
    /// its best case is then beyond its worst case alone.
    pub(super) fn waits_longer(&self, slot: usize) -> bool {
        let job = &self.jobs[slot];
        let open = self.version(slot).encoders.without(&job.done).without(&job.running);
        let runs = |lane: &usize| self.lanes[*lane].is_busy() && self.lanes[*lane].is_encoder;
        let longest = (0..usize::from(self.lane_count)).filter(runs).map(|lane| self.left_on(lane)).max();
        // Costs first: looking for a key takes longer, and encoders of one key seldom differ.
        open.iter().filter(|e| Some(self.node(slot, *e).cost()) < longest).any(|e| {
            let cost = self.node(slot, e).cost();
            matches!(self.output_of(slot, e), Some(OutputState::Running(l)) if self.left_on(usize::from(l)) > cost)
        })
    }

    /// How long a rank has run. `None`: not at all.
    fn executed(&self, slot: usize, rank: usize) -> Option<Duration> {
        let job = &self.jobs[slot];
        if job.running.contains(rank) {
            return Some(self.executed_on(usize::from(job.place[rank])));
        }
        self.suspended_after(slot, rank)
    }

    /// The result that an encoder would take.
    fn output_of(&self, slot: usize, rank: usize) -> Option<OutputState> {
        let key = self.frame_key(slot, rank).filter(|_| self.config.frame_cache)?;
        self.find_output(key).map(|(_, state)| state)
    }

    /// Longest path after a rank at WCET, in nanoseconds.
    pub(super) fn tail_after(&self, slot: usize, rank: usize) -> u64 {
        let version = self.version(slot);
        let mut path = <C::Nodes<u64>>::EMPTY;
        for i in (0..usize::from(version.len)).rev() {
            let at = usize::from(version.topological[i]);
            let mut after = 0;
            version.successors[at].each(|s| after = after.max(path[s]));
            if at == rank {
                return after;
            }
            path[at] = after + self.node(slot, at).cost();
        }
        0
    }

    /// Work that is left of a job at WCET, in nanoseconds.
    pub(super) fn remaining_work(&self, slot: usize) -> u64 {
        let undone = self.jobs[slot].undone(self.version(slot));
        undone.iter().map(|rank| self.left_of(slot, rank, Case::Worst).1).fold(0, u64::saturating_add)
    }

    /// Level share of the residual graph's first level, anchored at now: the key of every ready node.
    ///
    /// Nodes whose predecessors are all done are the sources of what remains, so they are its first level, and
    /// none of the other levels is needed. A budget that is gone makes everything due at the deadline.
    pub(super) fn residual_key(&mut self, slot: usize) {
        let job = &self.jobs[slot];
        let (mut first, mut all) = (0u128, 0u128);
        for rank in job.undone(self.version(slot)).iter() {
            let mut cost = u128::from(self.expected(slot, rank));
            if let Some(executed) = self.executed(slot, rank) {
                cost = cost.saturating_sub(executed.as_nanos().into()).max(1);
            }
            all += cost;
            if job.waiting_for[rank] == 0 {
                first += cost;
            }
        }
        let budget = job.deadline.since(self.now);
        let due = if budget == Duration::ZERO || all == 0 {
            job.deadline
        } else {
            self.now.saturating_add(Duration::from_nanos(share(budget.as_nanos(), first, all)))
        };
        self.jobs[slot].key = due.as_nanos().cast_signed();
    }
}
