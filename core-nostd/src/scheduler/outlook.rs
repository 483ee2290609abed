//! How much of a job is left: longest remaining path, remaining work, the residual key.
//!
//! *Rule.* One reverse topological pass over nodes that are not done. A node that runs counts what is left of it. By
//! best case and by estimate an encoder whose result is kept, or is being computed, counts 0.
//! *Why the best case is a proof.* No schedule can end a job before now plus its longest path, nor before now plus the
//! work it leaves to a pool over that pool's lanes. A job for which that is after the deadline is lost whatever is done.

use super::{Scheduler, bits, jobs::Job};
use crate::capacity::{Capacity, Empty};
use crate::config::BestCase;
use crate::deadlines::Estimator;
use crate::deadlines::exact::share;
use crate::graph::Node;
use crate::time::{CostEstimate, Duration};

/// Which execution times to count with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Case {
    /// The shortest that is declared, or was seen in a whole window.
    Best,
    /// The mean of the window, of a job that has not started halfway from there to the longest; the WCET before the first.
    Expected,
    /// WCET plus contention, and every encoder runs.
    Worst,
}

impl<C: Capacity> Scheduler<C> {
    /// Visits a job's ranks from the sinks on; `visit` gets a rank and the longest path after it, and returns the
    /// longest from it on. Time bound: O(nodes + edges).
    fn backwards(&self, job: &Job<C>, mut visit: impl FnMut(usize, u64) -> u64) {
        let version = self.tasks[job.task.index()].version_of(job);
        let mut path = <C::Nodes<u64>>::EMPTY;
        for at in (0..usize::from(version.len)).rev() {
            let rank = usize::from(version.topological[at]);
            path[rank] = visit(rank, version.successors[rank].largest(&path));
        }
    }

    /// Longest path after a rank at WCET, in nanoseconds.
    pub(super) fn tail_after(&self, slot: usize, rank: usize) -> u64 {
        let mut tail = 0;
        self.backwards(&self.jobs[slot], |at, after| {
            tail = if at == rank { after } else { tail };
            after + self.node(slot, at).cost()
        });
        tail
    }

    /// The least time from now in which a job can end, in nanoseconds: its longest remaining path, and for each pool
    /// the work left there over its lanes, but for encoders. `slot` is where the job is, or none where it is only about to be.
    pub(super) fn bound(&self, job: &Job<C>, slot: usize, case: Case) -> u64 {
        let (mut longest, mut work) = (0u64, <C::Pools<u64>>::EMPTY);
        let encoders = &self.tasks[job.task.index()].version_of(job).encoders;
        self.backwards(job, |rank, after| {
            if job.done.contains(rank) {
                return 0;
            }
            let (left, pool) = (self.left_of(job, slot, rank, case), self.node_of(job, rank).pool.index());
            // One run of an encoder may serve others, here or in another pool.
            let own = if encoders.contains(rank) { 0 } else { left };
            work[pool] = work[pool].saturating_add(own);
            longest = longest.max(after.saturating_add(left));
            after.saturating_add(left)
        });
        let lanes = |pool: &usize| self.pools[*pool].lanes.count_ones();
        let share = |pool: usize| work[pool].div_ceil(lanes(&pool).max(1).into());
        self.pool_numbers().filter(|pool| lanes(pool) > 0).map(share).fold(longest, u64::max)
    }

    /// What is left of a rank that is not done, in nanoseconds. Of a probe that is due, no estimate is believed.
    pub(super) fn left_of(&self, job: &Job<C>, slot: usize, rank: usize, case: Case) -> u64 {
        let (node, ref window) = self.history(job, rank);
        let case = if case == Case::Expected && self.is_due(job) { Case::Best } else { case };
        let whole = match case {
            Case::Best => self.best_case(job, node, window),
            Case::Expected => {
                if job.started {
                    mean_of(node, window)
                } else {
                    before_start(node, window)
                }
            }
            Case::Worst => node.cost(),
        };
        if let Some(executed) = self.executed(job, slot, rank) {
            let executed = executed.as_nanos();
            let is_outrun = case == Case::Expected && executed > whole;
            let whole = if is_outrun { longest(window) } else { whole };
            return whole.saturating_sub(executed);
        }
        let is_there = case != Case::Worst
            && self.tasks[job.task.index()].version_of(job).encoders.contains(rank)
            && self.output_of(job, rank).is_some();
        if is_there { 0 } else { whole }
    }

    /// What is left of the unit on a lane by estimates, in nanoseconds: the longest of its members', those included
    /// whose jobs were given up.
    pub(super) fn left_on(&self, lane: usize) -> u64 {
        let l = &self.lanes[lane];
        let of_gone = if l.merged { l.expects.saturating_sub(self.executed_on(lane).as_nanos()) } else { 0 };
        let left = |slot: usize, rank| self.left_of(&self.jobs[slot], slot, rank, Case::Expected);
        let members =
            bits(l.members).flat_map(|slot| self.ranks_on(slot, lane).map(move |rank| left(slot, rank)));
        members.fold(of_gone, u64::max)
    }

    /// The estimate of the unit on a lane, and the longest of its last executions, in nanoseconds: of its members the
    /// largest, as `left_on` has it.
    pub(super) fn expected_on(&self, lane: usize) -> (u64, u64) {
        let l = &self.lanes[lane];
        let of_gone = if l.merged { l.expects } else { 0 };
        let of = |slot: usize, rank| {
            let (node, window) = self.history(&self.jobs[slot], rank);
            (mean_of(node, &window), longest(&window))
        };
        let members =
            bits(l.members).flat_map(|slot| self.ranks_on(slot, lane).map(move |rank| of(slot, rank)));
        members.fold((of_gone, 0), |(mean, most), (own, longest)| (mean.max(own), most.max(longest)))
    }

    fn history(&self, job: &Job<C>, rank: usize) -> (&Node, Estimator) {
        let task = &self.tasks[job.task.index()];
        let node = usize::from(task.version_of(job).order[rank]);
        (&task.nodes[node], Estimator::of(task.shifts[node], &task.samples[node]))
    }

    /// Best case, in nanoseconds; never above the cost, so that on time at WCET is on time at best.
    fn best_case(&self, job: &Job<C>, node: &Node, window: &Estimator) -> u64 {
        let is_observed = self.config.best_case == BestCase::Observed && !self.is_doubted(job);
        let seen = if is_observed { window.best_case() } else { None };
        seen.unwrap_or_default().max(node.best).as_nanos().min(node.cost())
    }

    /// Expected cost of a rank for keys: mean of the window plus contention, WCET plus contention before a sample.
    pub(super) fn expected(&self, slot: usize, rank: usize) -> u64 {
        let (node, window) = self.history(&self.jobs[slot], rank);
        mean_of(node, &window).saturating_add(node.contention.as_nanos())
    }

    /// The longest of the last executions of a rank, plus contention; WCET plus contention before a sample, and no more where that is forgiven.
    pub(super) fn at_most(&self, slot: usize, rank: usize) -> u64 {
        let job = &self.jobs[slot];
        let (node, window) = self.history(job, rank);
        let (wcet, seen) = (node.wcet.get(), window.maximum());
        let most = seen.map_or(wcet, |seen| if self.is_forgiven(job) { seen.min(wcet) } else { seen });
        most.as_nanos().saturating_add(node.contention.as_nanos())
    }

    /// How long a rank has run. `None`: not at all.
    fn executed(&self, job: &Job<C>, slot: usize, rank: usize) -> Option<Duration> {
        if job.running.contains(rank) {
            return Some(self.executed_on(usize::from(job.place[rank])));
        }
        self.suspended_after(slot, rank)
    }

    /// Work that is left of a job by estimates, in nanoseconds.
    pub(super) fn remaining_work(&self, job: &Job<C>, slot: usize) -> u64 {
        let undone = job.undone(self.tasks[job.task.index()].version_of(job));
        undone.iter().map(|rank| self.left_of(job, slot, rank, Case::Expected)).fold(0, u64::saturating_add)
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
            if let Some(executed) = self.executed(job, slot, rank) {
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

/// The mean of the last executions, in nanoseconds; WCET before the first.
pub(super) fn mean_of(node: &Node, window: &Estimator) -> u64 {
    window.mean().map_or(node.wcet.as_nanos(), CostEstimate::as_nanos)
}

/// The estimate of a node whose job has not started, in nanoseconds: with care, as the lanes that it takes are lost if it is late.
pub(super) fn before_start(node: &Node, window: &Estimator) -> u64 {
    let mean = mean_of(node, window);
    mean + longest(window).saturating_sub(mean) / 2
}

/// The longest of the last executions, in nanoseconds; 0 before the first.
fn longest(window: &Estimator) -> u64 {
    window.maximum().unwrap_or_default().as_nanos()
}
