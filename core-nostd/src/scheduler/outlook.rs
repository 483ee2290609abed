//! How much of a job is left: longest remaining path, remaining work, the residual key.
//!
//! *Rule.* One reverse topological pass over nodes that are not done. A running node counts what is left of
//! it. In the best case an encoder whose result is kept counts 0, and one whose key is running ends with that
//! unit, whatever it would take itself.
//! *Why the best case is a proof.* No schedule can end a job before now plus its longest path at best-case
//! costs, so a job for which that is after the deadline is lost whatever is done.

use super::Scheduler;
use crate::capacity::{Capacity, Empty};
use crate::config::BestCase;
use crate::deadlines::Estimator;
use crate::deadlines::exact::share;
use crate::graph::Node;
use crate::policy::frame_cache::OutputState;
use crate::time::{CostEstimate, Duration};

/// Which execution times to count with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Case {
    Best,
    Worst,
}

impl<C: Capacity> Scheduler<C> {
    /// Visits a job's ranks from the sinks on; `visit` gets a rank and the longest path after it, and returns the
    /// longest from it on. Time bound: O(nodes + edges).
    fn backwards(&self, slot: usize, mut visit: impl FnMut(usize, u64) -> u64) {
        let version = self.version(slot);
        let mut path = <C::Nodes<u64>>::EMPTY;
        for at in (0..usize::from(version.len)).rev() {
            let rank = usize::from(version.topological[at]);
            path[rank] = visit(rank, version.successors[rank].largest(&path));
        }
    }

    /// Longest path after a rank at WCET, in nanoseconds.
    pub(super) fn tail_after(&self, slot: usize, rank: usize) -> u64 {
        let mut tail = 0;
        self.backwards(slot, |at, after| {
            tail = if at == rank { after } else { tail };
            after + self.node(slot, at).cost()
        });
        tail
    }

    /// Longest path of what is left of a job, in nanoseconds.
    pub(super) fn remaining_path(&self, slot: usize, case: Case) -> u64 {
        let mut longest = 0;
        self.backwards(slot, |rank, after| {
            if self.jobs[slot].done.contains(rank) {
                return 0;
            }
            let (chained, alone) = self.left_of(slot, rank, case);
            longest = longest.max(after.saturating_add(alone));
            after.saturating_add(chained)
        });
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
            (Case::Best, Some((_, OutputState::Kept))) => (0, 0),
            (Case::Best, Some((_, OutputState::Running(lane)))) => (0, self.left_on(lane.into())),
            _ => (whole, whole),
        }
    }

    /// What is left, at best, of the encoder's unit that runs on a lane, in nanoseconds.
    fn left_on(&self, lane: usize) -> u64 {
        self.lanes[lane].best.saturating_sub(self.executed_on(lane).as_nanos())
    }

    /// Whether an encoder of the job has to wait for a running one of its key that takes longer than what the job
    /// was last looked at with: its best case is then beyond its worst case alone, or its best where it is behind.
    pub(super) fn waits_longer(&self, slot: usize) -> bool {
        let runs = |lane: &usize| self.lanes[*lane].is_busy() && self.lanes[*lane].is_encoder;
        let longest = (0..self.lanes()).filter(runs).map(|lane| self.left_on(lane)).max();
        // Costs first: looking for a key takes longer.
        self.open_encoders(slot).iter().any(|e| {
            let behind = self.jobs[slot].behind;
            let cost = if behind { self.best_case(slot, e) } else { self.node(slot, e).cost() };
            let waits =
                |(_, state)| matches!(state, OutputState::Running(l) if self.left_on(l.into()) > cost);
            Some(cost) < longest && self.output_of(slot, e).is_some_and(waits)
        })
    }

    fn history(&self, slot: usize, rank: usize) -> (&Node, &Estimator) {
        let task = &self.tasks[self.jobs[slot].task.index()];
        let node = usize::from(self.version(slot).order[rank]);
        (&task.nodes[node], &task.estimates[node])
    }

    /// Best case of a rank, in nanoseconds; never above its cost, so that on time at WCET is on time at best.
    pub(super) fn best_case(&self, slot: usize, rank: usize) -> u64 {
        let (node, window) = self.history(slot, rank);
        let is_observed = self.config.best_case == BestCase::Observed;
        let seen = if is_observed { window.minimum() } else { None };
        seen.unwrap_or(node.best).as_nanos().min(node.cost())
    }

    /// Expected cost of a rank: mean of the window plus contention, WCET plus contention before a sample.
    pub(super) fn expected(&self, slot: usize, rank: usize) -> u64 {
        let (node, window) = self.history(slot, rank);
        let mean = window.mean().map_or(node.wcet.as_nanos(), CostEstimate::as_nanos);
        mean.saturating_add(node.contention.as_nanos())
    }

    /// How long a rank has run. `None`: not at all.
    fn executed(&self, slot: usize, rank: usize) -> Option<Duration> {
        let job = &self.jobs[slot];
        if job.running.contains(rank) {
            return Some(self.executed_on(usize::from(job.place[rank])));
        }
        self.suspended_after(slot, rank)
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
