//! What keeps a job from its lanes: the right sides of the inequalities.

use crate::Keys;
use crate::graph::Shape;
use crate::work::{FAR, Load, largest};

/// Everything else in a cluster where a job waits.
pub(crate) struct Rivals<'a> {
    pub(crate) lanes: i128,
    /// Other tasks.
    pub(crate) others: Vec<&'a Load>,
    /// The job's own task.
    pub(crate) own: &'a Load,
    /// The job's graph.
    pub(crate) shape: &'a Shape,
}

impl Rivals<'_> {
    /// A0: in `cap` of a window that begins with the job's release, of which it waits `wait` beside its critical chain.
    pub(crate) fn after_release(&self, keys: Keys, window: i128, cap: i128, wait: i128) -> i128 {
        let blocking = self.low(self.lanes, -1, &[]) + self.later(window, wait);
        self.all(keys, window, cap, blocking)
    }

    /// Of several clusters: each entry into this one may meet a later key on every lane, and each other node on all but
    /// the one that its predecessor freed.
    pub(crate) fn on_entry(&self, keys: Keys, cluster: usize, window: i128, cap: i128) -> i128 {
        let entry = self.low(self.lanes, window - 1, &[]);
        let inside = self.low(self.lanes - 1, window - 1, &[]);
        let blocking = self.shape.most(|node| match self.shape.nodes[node].cluster == cluster {
            false => 0,
            true if self.shape.enters(node) => entry,
            true => inside,
        });
        self.all(keys, window, cap, blocking)
    }

    /// PREFIX: of windows that begin at least `begin` and at most `end` before the release, with the response time R.
    pub(crate) fn before_release(
        &self,
        keys: Keys,
        response: i128,
        (begin, end): (i128, i128),
        cap: i128,
        wait: i128,
    ) -> i128 {
        let window = end + response;
        let earlier = end - self.own.period();
        let inside_of_own = self.own.inside(window, earlier, cap, FAR);
        let mut inside = inside_of_own;
        let mut carried = vec![(self.own.overlapping(window, earlier, cap, FAR) - inside_of_own).max(0)];
        for other in &self.others {
            let of = |bound: &dyn Fn(i128, i128) -> i128| match keys {
                Keys::Any => bound(FAR, FAR),
                Keys::Key => other.by_key(end + self.shape.last_key, bound),
            };
            let released = of(&|last, rest| other.inside(window, last, cap, rest));
            let all = of(&|last, rest| other.overlapping(window, last, cap, rest));
            inside += released;
            carried.push((all - released).max(0));
        }
        carried.sort_unstable_by(|a, b| b.cmp(a));
        // Lanes that are with tasks that carry work into the window are not with later keys at its begin.
        let mut most = 0;
        let mut sum = 0;
        for (lanes, carries) in (1..=self.lanes).rev().zip(carried.into_iter().chain([0])) {
            let blocking = if keys == Keys::Key { self.low(lanes, -1 - begin, &[]) } else { 0 };
            most = most.max(sum + blocking);
            sum += carries;
        }
        inside + most + if keys == Keys::Key { self.later(response, wait) } else { 0 }
    }

    /// Whether windows that begin earlier than `begin` can hold no more than the lanes do in them, where a job does `own`
    /// beside its critical chain while that waits `wait`: both sides of the inequality.
    pub(crate) fn closing(
        &self,
        keys: Keys,
        response: i128,
        begin: i128,
        own: i128,
        wait: i128,
    ) -> (i128, i128) {
        let (mut rate, mut constant) = self.own.rate(response);
        for other in &self.others {
            let (more, beside) = other.rate(response);
            (rate, constant) = (rate + more, constant + beside);
        }
        if keys == Keys::Key {
            constant += self.low(self.lanes, -1, &[]) + self.later(response, wait);
        }
        // Without spare time this is not above zero, and the right side is. Where it does not fit, the right side is far below.
        let left = begin.saturating_mul((self.lanes << 32) - rate);
        (left, (constant + own - self.lanes * wait) << 32)
    }

    /// All that others do, or what has no later keys and as much of the rest as can hold lanes.
    fn all(&self, keys: Keys, window: i128, cap: i128, blocking: i128) -> i128 {
        let last_key = self.shape.last_key;
        let (mut high, mut low) = self.own.siblings(window, cap, last_key);
        for other in &self.others {
            let any = other.overlapping(window, FAR, cap, FAR);
            let by_key = other.by_key(last_key, |last, rest| other.overlapping(window, last, cap, rest));
            high += by_key.min(any);
            low += any - by_key.min(any);
        }
        high + if keys == Keys::Key { low.min(blocking) } else { low }
    }

    /// Work of later keys that the job meets after its first node: they began while an earlier node of it ran, on the other
    /// lanes; and one lane at least does none in any of the waiting. Waiting of more than `wait` needs no more of it: it adds
    /// as much to the left side of the inequality as to this and the chain together.
    fn later(&self, window: i128, wait: i128) -> i128 {
        let jobs = self.own.low_siblings(window, self.shape.last_key);
        let own = self.own.holders(self.lanes - 1, jobs, self.shape.last_key, window - 1);
        let low = self.low(self.lanes - 1, window - 1, &own);
        ((self.shape.hops - 1) * low).min((self.lanes - 1) * wait)
    }

    /// pick: work of later keys on so many lanes, of jobs that were released before `before`.
    fn low(&self, lanes: i128, before: i128, own: &[(i128, i128)]) -> i128 {
        let of = |other: &&Load| other.holders(lanes, other.at_once(), self.shape.last_key, before);
        let all = self.others.iter().flat_map(of).chain(own.iter().copied()).collect();
        largest(all, lanes).into_iter().map(|(cost, times)| cost * times).sum()
    }
}
