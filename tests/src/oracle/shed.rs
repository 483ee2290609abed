//! The overload monitor of RED, and what gives jobs up (8.1, 8.3, 8.5).

use std::cmp::Reverse;

use super::band::LAST;
use super::dispatch::order;
use super::forward::Fate;
use super::job::Job;
use super::rank::{Name, Rank, Standing};
use super::{
    LEAVE_AT_MOST, OVERLOAD_TICKS, Policy, QUEUE_MAX, RECENT_JOBS, Reason, Sim, TICK_NS, UTILISATION_PPM,
};

/// Positions of the jobs in flight during a look.
struct Look {
    /// Of whom the forward schedule is.
    group: Vec<usize>,
    /// Late, and to stay.
    kept: Vec<usize>,
    /// They left the group, or are late: lost to their tasks.
    lost: Vec<Name>,
    /// They go behind the others, as they will wait.
    behind: Vec<usize>,
    /// They did, or could not.
    tried: Vec<usize>,
}

impl Sim<'_> {
    /// One tick of the monitor.
    pub(super) fn observe(&mut self, now: u64) {
        let pools = 0..self.workload.pools.len();
        let busy =
            pools.into_iter().any(|pool| self.queue(pool).len() > QUEUE_MAX || self.is_saturated(pool, now));
        self.over = if busy { self.over + 1 } else { 0 };
        self.executions.retain(|&(_, _, finish)| finish > now);
    }

    /// Whether the lanes were busy for more than the threshold during the last tick.
    fn is_saturated(&self, pool: usize, now: u64) -> bool {
        let window = now.saturating_sub(TICK_NS);
        let here = self.executions.iter().filter(|execution| execution.0 == pool);
        let busy: u64 =
            here.map(|&(_, start, finish)| finish.min(now).saturating_sub(start.max(window))).sum();
        let lanes = u128::from(self.workload.pools[pool].lanes);
        u128::from(busy) * 1_000_000 > UTILISATION_PPM * lanes * u128::from(TICK_NS)
    }

    /// Gives up jobs, by the policy's rule.
    pub(super) fn shed(&mut self, now: u64, tick: bool) {
        if self.policy.is_ours() {
            self.abort_hopeless(now);
        }
        if std::mem::take(&mut self.look_due) && self.policy.is_ours() {
            self.look(now);
        }
        if tick && self.over >= OVERLOAD_TICKS {
            self.drop_least_urgent(now);
        }
        self.drop_unused();
    }

    /// Aborts each job that cannot end in time even at its best (8.3).
    fn abort_hopeless(&mut self, now: u64) {
        let hopeless = self.jobs.iter().filter(|job| self.bound(job, now) > job.due);
        for (task, index) in hopeless.map(|job| (job.task, job.index)).collect::<Vec<_>>() {
            self.give_up(task, index, now, Reason::Hopeless);
        }
    }

    /// Gives up those who make others late, and looks again as long as so many of them are found at once (8.5).
    fn look(&mut self, now: u64) {
        loop {
            let lost = self.give_bands(now);
            let (outside, last, cut_short) = self.predict(lost, now);
            for &job in &last {
                self.jobs[job].band = LAST;
            }
            for &(task, index) in &outside {
                self.give_up(task, index, now, Reason::Overload);
            }
            if !cut_short || outside.is_empty() {
                return;
            }
        }
    }

    /// The jobs that have to go, the positions of those that go last, and whether as many left as one look lets go.
    fn predict(&mut self, lost: Vec<Name>, now: u64) -> (Vec<(usize, u64)>, Vec<usize>, bool) {
        let mut look = Look {
            group: (0..self.jobs.len()).collect(),
            kept: Vec::new(),
            lost,
            behind: Vec::new(),
            tried: Vec::new(),
        };
        // Those that left, by what they were when they did.
        let mut outside: Vec<(Standing, usize)> = Vec::new();
        while outside.len() < LEAVE_AT_MOST {
            let fates = self.forward_behind(&look.group, &look.behind, now);
            let Some(x) = self.first_late(&fates, |job| !look.kept.contains(&job)) else { break };
            if self.lets_one_wait(x, &fates, &mut look, now) {
                continue;
            }
            let loses = if let Some(goes) = self.who_goes(x, &fates, &look, now) {
                outside.push((self.standing(&self.jobs[goes], &look.lost, now), goes));
                look.group.retain(|&job| job != goes);
                goes
            } else {
                look.kept.push(x.job);
                x.job
            };
            if outside.len() < LEAVE_AT_MOST {
                self.lose(loses, &mut look, now);
            }
        }
        let cut_short = outside.len() == LEAVE_AT_MOST;
        outside.sort_unstable_by_key(|&left| Reverse(left));
        outside.retain(|&(_, job)| {
            look.group.push(job);
            let with_it = self.forward_behind(&look.group, &look.behind, now);
            let stays_out = self.first_late(&with_it, |job| !look.kept.contains(&job)).is_some();
            if stays_out {
                look.group.pop();
            }
            stays_out
        });
        let fates = self.forward_behind(&look.group, &look.behind, now);
        let may = |fate: &&Fate| self.is_late(fate) && self.policy == Policy::Redrt;
        let late = fates.iter().filter(may).map(|fate| fate.job);
        let last = late.filter(|&job| !self.jobs[job].started).collect();
        let name = |(_, job): (Standing, usize)| (self.jobs[job].task, self.jobs[job].index);
        (outside.into_iter().map(name).collect(), last, cut_short)
    }

    /// A job counts as lost from now on; where that makes another one of its task rank higher, bands are given again.
    fn lose(&mut self, job: usize, look: &mut Look, now: u64) {
        let task = self.jobs[job].task;
        let ranks = |look: &Look| -> Vec<Rank> {
            let own = look.group.iter().filter(|&&at| self.jobs[at].task == task);
            own.map(|&at| self.rank(&self.jobs[at], &look.lost, now)).collect()
        };
        let before = ranks(look);
        look.lost.push((task, self.jobs[job].index));
        if before.iter().zip(ranks(look)).any(|(before, after)| *before < after) {
            self.order(&look.group, &look.behind, &look.lost, now);
        }
    }

    /// Of these jobs that are late, the one that ends first.
    fn first_late<'a>(&self, fates: &'a [Fate], of: impl Fn(usize) -> bool) -> Option<&'a Fate> {
        let late = fates.iter().filter(|fate| self.is_late(fate) && of(fate.job));
        late.min_by_key(|fate| {
            let job = &self.jobs[fate.job];
            (fate.end, job.release, job.task, job.index)
        })
    }

    /// The jobs in the way of `x` that are below it.
    fn below(&self, x: &Fate, fates: &[Fate], look: &Look, now: u64) -> Vec<usize> {
        let standing = |job: usize| self.standing(&self.jobs[job], &look.lost, now);
        let in_the_way = |j: &&Fate| {
            let starts_before = j.first_start.is_some_and(|start| start < x.end);
            starts_before && j.meets(x) && standing(j.job) < standing(x.job)
        };
        fates.iter().filter(in_the_way).map(|j| j.job).collect()
    }

    /// Whether the least of those below `x` goes behind the others from now on: it will wait for `x`, and is in time all the same,
    /// and so is everybody else who was.
    fn lets_one_wait(&self, x: &Fate, fates: &[Fate], look: &mut Look, now: u64) -> bool {
        let below = self.below(x, fates, look, now).into_iter();
        let Some(least) = below.min_by_key(|&job| self.standing(&self.jobs[job], &look.lost, now)) else {
            return false;
        };
        let may_wait = !self.jobs[least].started
            && self.is_waited_for(&self.jobs[x.job], &[], &self.jobs[least], now)
            && !look.tried.contains(&least);
        if !may_wait {
            return false;
        }
        look.tried.push(least);
        look.behind.push(least);
        let was_late = |job: usize| fates.iter().any(|fate| fate.job == job && self.is_late(fate));
        let then = self.forward_behind(&look.group, &look.behind, now);
        let helps =
            then.iter().filter(|fate| self.is_late(fate)).all(|fate| fate.job != least && was_late(fate.job));
        if !helps {
            look.behind.pop();
        }
        helps
    }

    /// Who leaves because `x` would be late: one of those below it that are in its way, if it is in time
    /// without all that are below it; else `x`, if it harms others; else nobody.
    fn who_goes(&self, x: &Fate, fates: &[Fate], look: &Look, now: u64) -> Option<usize> {
        let standing = |job: usize| self.standing(&self.jobs[job], &look.lost, now);
        let below = self.below(x, fates, look, now);
        let is_above = |job: &usize| standing(*job) >= standing(x.job);
        let others: Vec<usize> = look.group.iter().copied().filter(is_above).collect();
        let late = |fate: &Fate| fate.job == x.job && self.is_late(fate);
        let helps = |_: &usize| !self.forward(&others, now).iter().any(late);
        let least = below.iter().copied().min_by_key(|&job| standing(job)).filter(helps);
        let one = least.map(|least| self.least_or_late(least, &below, fates, look, now));
        let harms = || self.harms(x, fates, look, now) || self.harms_next(x, fates, now);
        one.or_else(|| harms().then_some(x.job))
    }

    /// The least of those in the way, or the first of the others of its rank that are late, if fewer jobs are late
    /// without that one.
    fn least_or_late(&self, least: usize, below: &[usize], fates: &[Fate], look: &Look, now: u64) -> usize {
        let rank = |job: usize| self.rank(&self.jobs[job], &look.lost, now);
        let equal = |job: usize| job != least && below.contains(&job) && rank(job) == rank(least);
        let late_without = |left: usize| {
            let others: Vec<usize> = look.group.iter().copied().filter(|&job| job != left).collect();
            let then = self.forward_behind(&others, &look.behind, now);
            then.iter().filter(|fate| self.is_late(fate)).count()
        };
        let other = self.first_late(fates, equal).map(|fate| fate.job);
        other.filter(|&other| late_without(other) < late_without(least)).unwrap_or(least)
    }

    pub(super) fn is_late(&self, fate: &Fate) -> bool {
        fate.end > self.jobs[fate.job].due
    }

    /// Whether another job that could be in time is late where `x` takes lanes; one above `x`, if that is in doubt.
    fn harms(&self, x: &Fate, fates: &[Fate], look: &Look, now: u64) -> bool {
        let in_time = |y: &Fate| self.bound(&self.jobs[y.job], now) <= self.jobs[y.job].due;
        let standing = |job: usize| self.standing(&self.jobs[job], &look.lost, now);
        let counts = |y: &Fate| !self.is_in_doubt(&self.jobs[x.job]) || standing(y.job) > standing(x.job);
        let others = fates.iter().filter(|y| y.job != x.job && !look.kept.contains(&y.job) && counts(y));
        others.into_iter().any(|y| self.is_late(y) && in_time(y) && y.meets(x))
    }

    /// Whether a job is a probe of a task that lost more than its last 16 jobs and is late at its costs on lanes of its own.
    fn is_in_doubt(&self, job: &Job) -> bool {
        let graph = &self.tasks[job.task].graph;
        self.is_probe(job.task, job.index)
            && self.lost_in_row(job.task, &[]) > RECENT_JOBS
            && self.slack(job.task, graph) < 0
    }

    /// Whether `x`, which has not started and is no probe, ends too late for the next job of its task, and all others beside it do
    /// not.
    fn harms_next(&self, x: &Fate, fates: &[Fate], now: u64) -> bool {
        let job = &self.jobs[x.job];
        let Some((at, graph)) = self.expected_release(job.task).filter(|(at, _)| *at > now) else {
            return false;
        };
        let beside = fates.iter().filter(|y| y.job != x.job && y.meets(x) && y.end < i128::MAX);
        let others = beside.map(|y| y.end).max().unwrap_or(0);
        let latest = i128::from(at) + self.slack(job.task, &graph);
        let may_go = !job.started && !self.is_probe(job.task, job.index);
        may_go
            && self.can_gain(job.task, self.next_index(job.task), &graph)
            && others <= latest
            && latest < x.end
    }

    /// RED: drops the jobs of the queued sub-jobs of lowest urgency, at least one, until no queue is too long.
    fn drop_least_urgent(&mut self, now: u64) {
        self.reassign(now);
        loop {
            let candidates = self.jobs.iter().filter(|job| !self.floor_needs(job, &[]));
            let queued = candidates.flat_map(|job| {
                let ready = (0..job.state.len()).filter(|&node| job.is_ready(node, false));
                ready.map(move |node| (urgency(job, node, now), Reverse(order(job, node))))
            });
            let Some((_, Reverse((_, _, _, _, task, index, _)))) = queued.min() else { break };
            self.give_up(task, index, now, Reason::Urgency);
            if (0..self.workload.pools.len()).all(|pool| self.queue(pool).len() <= QUEUE_MAX) {
                break;
            }
        }
        self.over = 0;
    }

    /// Ends a job that is in flight. What runs for it runs on.
    pub(super) fn give_up(&mut self, task: usize, index: u64, now: u64, reason: Reason) {
        let at = self.jobs.iter().position(|job| (job.task, job.index) == (task, index));
        let job = self.jobs.remove(at.expect("only jobs in flight are given up"));
        self.outcome.shed(&job, now, reason);
    }
}

/// The paper's C in millionths: elapsed over relative sub-deadline, 1 at and beyond it.
fn urgency(job: &Job, node: usize, now: u64) -> i128 {
    let delta = job.keys[node] - i128::from(job.release);
    let elapsed = i128::from(now - job.release);
    if delta == 0 || elapsed >= delta { 1_000_000 } else { elapsed * 1_000_000 / delta }
}

#[cfg(test)]
mod tests;
