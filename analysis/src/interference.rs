//! What other jobs do to one: interference, and nodes of lower rank that cannot be stopped any more.
//!
//! A job J of task k is released at `e` within a window of length `win`, and is due to end at the window's end. Times are in
//! nanoseconds; measures of time sets may be below zero, and hold nothing then.

use crate::shape::{Part, Shape};
use std::iter::repeat_n;

/// A task as others in its cluster see it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Other<'a> {
    /// `None`: released once.
    pub(crate) period: Option<i128>,
    /// What bounds every graph of it.
    pub(crate) part: &'a Part,
    /// No job of it has work that long after its release.
    pub(crate) bound: i128,
}

/// The job that is looked at.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Looked<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) others: &'a [Other<'a>],
    /// Lanes of the cluster.
    pub(crate) lanes: i128,
}

/// Which nodes of others count as going before J's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Keys {
    /// All.
    Any,
    /// Those of no later keys.
    Key,
}

/// Limits of a window: its length, the measure that the work of one job falls into.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    pub(crate) win: i128,
    pub(crate) cap: i128,
}

impl Other<'_> {
    /// Jobs that may have work at the same time.
    pub(crate) fn at_once(&self) -> usize {
        let more = self.period.map_or(0, |period| (self.bound - 1).max(0) / period);
        usize::try_from(more).unwrap_or(usize::MAX).saturating_add(1)
    }

    /// Work of jobs that overlap the window, released no later than `z` after its start; the last has at most `last` of it.
    /// `None`: no such limit.
    pub(crate) fn carried(&self, w: Window, z: Option<i128>, last: Option<i128>) -> i128 {
        let z = z.map_or(w.win - 1, |z| z.min(w.win - 1));
        let limit = z + self.bound;
        if limit <= 0 {
            return 0;
        }
        let f = |x: i128| self.part.f(x.min(w.cap).min(self.bound).min(w.win));
        let of_last = |x: i128| last.map_or(x, |last| x.min(last));
        let mut most = of_last(f(limit));
        let Some(period) = self.period else { return most };
        let whole = limit / period;
        for n in [whole, whole - 1] {
            if n < 1 {
                continue;
            }
            let both = w.win + self.bound - n * period;
            let first = (both / 2).min(limit - n * period);
            let ends = f(first) + f(both - first);
            let ends = last.map_or(ends, |last| ends.min(f(limit - n * period) + last));
            most = most.max((n - 1) * f(self.bound) + ends);
        }
        most
    }

    /// Work of jobs released inside the window, the first at its start, up to `z` after it.
    pub(crate) fn inside(&self, w: Window, z: Option<i128>, last: Option<i128>) -> i128 {
        let z = z.map_or(w.win - 1, |z| z.min(w.win - 1));
        if z < 0 {
            return 0;
        }
        let later = self.period.map_or(0, |period| z / period);
        let period = self.period.unwrap_or(0);
        let whole = |j: i128| self.part.f((w.win - j * period).min(w.cap).min(self.bound));
        // Far from the window's end all jobs have the same; only those near it are cut.
        let usual = self.part.f(w.cap.min(self.bound));
        let cut_at = w.cap.min(self.bound);
        let uncut =
            if period == 0 { 0 } else { ((w.win - cut_at).div_euclid(period) + 1).clamp(0, later + 1) };
        let sum = uncut * usual + (uncut..=later).map(whole).sum::<i128>();
        last.map_or(sum, |last| sum.min(later * usual + last))
    }
}

impl Looked<'_> {
    /// [`Other::carried`] of nodes that go before J's; J is released at `e`.
    pub(crate) fn carried(&self, other: &Other<'_>, w: Window, e: i128, keys: Keys) -> i128 {
        let any = other.carried(w, None, None);
        match keys {
            Keys::Any => any,
            Keys::Key => {
                let of_group = |(key, work): &(i128, i128)| {
                    other.carried(w, Some(e + self.shape.last_key - key), Some(*work))
                };
                other.part.groups.iter().map(of_group).max().unwrap_or(0).min(any)
            }
        }
    }

    /// [`Other::inside`] of nodes that go before J's.
    pub(crate) fn inside(&self, other: &Other<'_>, w: Window, e: i128, keys: Keys) -> i128 {
        let any = other.inside(w, None, None);
        match keys {
            Keys::Any => any,
            Keys::Key => {
                let of_group = |(key, work): &(i128, i128)| {
                    other.inside(w, Some(e + self.shape.last_key - key), Some(*work))
                };
                other.part.groups.iter().map(of_group).max().unwrap_or(0).min(any)
            }
        }
    }

    /// The shortest chain that is longer than `y`, of others and of `own`. Up to there more waiting lets in as much more work.
    fn next_chain(&self, own: &Part, y: i128) -> Option<i128> {
        let parts = self.others.iter().map(|other| other.part).chain([own]);
        let next = |part: &Part| {
            let longer = part.chains.partition_point(|length| *length > y);
            longer.checked_sub(1).map(|at| part.chains[at])
        };
        parts.filter_map(next).min()
    }

    /// Where a search that has come to `wait`, and needs `needed`, goes on. Where each round adds as much as the one before it,
    /// demand grows with the wait nanosecond by nanosecond, and no wait in between is enough.
    pub(crate) fn next_wait(
        &self,
        own: &Part,
        wait: i128,
        needed: i128,
        last_step: &mut Option<i128>,
    ) -> i128 {
        let step = needed - wait;
        let as_much = last_step.is_some_and(|last| step <= last && 16 * step >= 15 * last);
        *last_step = Some(step);
        match self.next_chain(own, needed).filter(|_| as_much) {
            Some(length) => needed.max(length - 1),
            None => needed,
        }
    }

    /// The `count` largest nodes of others whose keys are later than J's if their jobs are released before `before`; of one
    /// job no more than it has chains. Where bounds exceed periods, several jobs of a task hold lanes by the same node.
    pub(crate) fn pick(&self, count: i128, before: i128) -> i128 {
        let count = usize::try_from(count.max(0)).unwrap_or(usize::MAX);
        let mut largest: Vec<i128> = Vec::new();
        for other in self.others {
            let low = other.part.nodes.iter().filter(|(key, _)| self.shape.last_key - key < before);
            let jobs = other.at_once();
            let at_once = count.min(jobs.saturating_mul(other.part.chains.len()));
            largest.extend(low.flat_map(|(_, cost)| repeat_n(*cost, jobs)).take(at_once));
        }
        largest.sort_unstable_by(|a, b| b.cmp(a));
        largest.iter().take(count).sum()
    }

    /// Nodes of lower rank that may run at J's release.
    pub(crate) fn first(&self) -> i128 {
        self.pick(self.lanes, -1)
    }

    /// Nodes of lower rank that may run when later nodes of J become ready, in so much waiting: the lane that J's last node
    /// left is given to none of them. `own`: the largest of J's task beside them.
    pub(crate) fn later(&self, response: i128, waiting: i128, own: i128) -> i128 {
        let at_once = self.pick(self.lanes - 1, response - 1) + own;
        ((self.shape.hops - 1).max(0) * at_once).min((self.lanes - 1) * waiting.max(0))
    }
}
