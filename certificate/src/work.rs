//! How much the jobs of one task can do in one cluster, whichever of its graphs each of them has.

use crate::graph::Shape;

/// Later than everything. Times of a certificate have 64 bits, and sums of a few of them stay below it.
pub(crate) const FAR: i128 = 1 << 100;

/// A task in a cluster.
pub(crate) struct Load {
    lanes: i128,
    /// Largest lengths of chains over all graphs, longest first.
    chains: Vec<i128>,
    /// A key, and the work of no later ones in one graph; of every key of every graph. Fewer and larger groups are sound,
    /// too, but never sharper: each of them is above one of these in both numbers.
    groups: Vec<(i128, i128)>,
    /// Cost and key of all nodes of all graphs.
    nodes: Vec<(i128, i128)>,
    /// Work of the graph with most of it.
    most: i128,
    /// [`FAR`]: released once.
    period: i128,
    /// No job does anything later after its release.
    pub(crate) response: i128,
}

impl Load {
    /// Of graphs and the chains of each in the cluster.
    pub(crate) fn of(
        versions: &[(&Shape, &[i128])],
        (cluster, lanes): (usize, u32),
        period: Option<u64>,
        response: i128,
    ) -> Self {
        let period = period.map_or(FAR, i128::from);
        let (mut chains, mut groups, mut nodes, mut most) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for (shape, lengths) in versions.iter().copied() {
            let here = shape.nodes.iter().filter(|node| node.cluster == cluster);
            let mut costs: Vec<(i128, i128)> = here.map(|node| (node.cost, node.key)).collect();
            costs.sort_unstable_by_key(|(_, key)| *key);
            let mut work = 0;
            for (n, (cost, key)) in costs.iter().enumerate() {
                work += cost;
                if costs.get(n + 1).is_none_or(|(_, next)| next > key) {
                    groups.push((*key, work));
                }
            }
            most = work.max(most);
            nodes.append(&mut costs);
            chains.resize(chains.len().max(lengths.len()), 0);
            chains.iter_mut().zip(lengths).for_each(|(most, length)| *most = *length.max(most));
        }
        Self { lanes: i128::from(lanes), chains, groups, nodes, most, period, response }
    }

    /// f: work of one job in any time of this measure.
    fn one(&self, time: i128) -> i128 {
        let chains: i128 = self.chains.iter().map(|length| *length.min(&time)).sum();
        chains.min(self.lanes * time)
    }

    /// ci: work of all jobs that overlap a window, released up to `last` after its begin, each within `cap`; the last one
    /// does `rest` at most.
    pub(crate) fn overlapping(&self, window: i128, last: i128, cap: i128, rest: i128) -> i128 {
        let limit = last.min(window - 1) + self.response;
        if limit <= 0 {
            return 0;
        }
        let one = |time: i128| self.one(time.min(cap).min(self.response).min(window));
        let jobs = limit / self.period;
        let mut most = one(limit).min(rest);
        // With fewer jobs before the last it is never more than with `jobs`.
        for jobs in [jobs, jobs - 1].into_iter().filter(|jobs| *jobs >= 1) {
            let apart = jobs * self.period;
            let ends = window + self.response - apart;
            let last = (ends / 2).min(limit - apart);
            let both = (one(last) + one(ends - last)).min(one(limit - apart) + rest);
            most = most.max((jobs - 1) * one(self.response) + both);
        }
        most
    }

    /// NC: the same of jobs that are released inside the window.
    pub(crate) fn inside(&self, window: i128, last: i128, cap: i128, rest: i128) -> i128 {
        let last = last.min(window - 1);
        if last < 0 {
            return 0;
        }
        let jobs = last / self.period;
        let most = cap.min(self.response);
        // These have time for all that a job does. The others are as many as the task has jobs at once.
        let early = if window < most { 0 } else { ((window - most) / self.period).min(jobs) + 1 };
        let late: i128 = (early..=jobs).map(|job| self.one((window - job * self.period).min(most))).sum();
        (early * self.one(most) + late).min(jobs * self.one(most) + rest)
    }

    /// The larger by what a job's keys allow: `bound` of the latest release and of the last job's work.
    pub(crate) fn by_key(&self, latest: i128, bound: impl Fn(i128, i128) -> i128) -> i128 {
        self.groups.iter().map(|(key, work)| bound(latest - key, *work)).max().unwrap_or(0)
    }

    /// What other jobs of a job's own task do while it lives, `later` after its release: the earlier ones and those of the
    /// later ones that may have a key up to `last_key`; and the later ones that do not. There is none where D <= T.
    pub(crate) fn siblings(&self, window: i128, cap: i128, last_key: i128) -> (i128, i128) {
        let (mut high, mut low) = (0, 0);
        let first_key = self.nodes.iter().map(|(_, key)| *key).min().unwrap_or(FAR);
        // As many times as the task has jobs at once.
        for job in (1..).take_while(|job| job * self.period < self.response.max(window)) {
            let after = job * self.period;
            high += self.one((self.response - after).clamp(0, cap));
            let later = self.one((window - after).clamp(0, cap));
            *if after <= last_key - first_key { &mut high } else { &mut low } += later;
        }
        (high, low)
    }

    /// Those of its later jobs that have only later keys than `last_key`.
    pub(crate) fn low_siblings(&self, window: i128, last_key: i128) -> i128 {
        let first_key = self.nodes.iter().map(|(_, key)| *key).min().unwrap_or(FAR);
        let high = (last_key - first_key).max(0) / self.period;
        ((window - 1) / self.period - high).max(0)
    }

    /// Least time between releases.
    pub(crate) const fn period(&self) -> i128 {
        self.period
    }

    /// Jobs that may be under way at once.
    pub(crate) fn at_once(&self) -> i128 {
        (self.response - 1) / self.period + 1
    }

    /// Costs of nodes that may hold lanes against a job of `last_key` that is released at 0, where theirs
    /// were at `before` at the latest; each with how often.
    pub(crate) fn holders(&self, lanes: i128, jobs: i128, last_key: i128, before: i128) -> Vec<(i128, i128)> {
        // Whoever was released at `before` at the latest has a later key only then.
        let low = self.nodes.iter().filter(|(_, key)| last_key - key < before);
        let low = low.map(|(cost, _)| (*cost, jobs)).collect();
        largest(low, lanes.min(jobs * self.chains.len() as i128))
    }

    /// Work per time, in 2^-32, rounded up; and the work that a window of no length may have beside that, with what is done
    /// in `response`.
    pub(crate) fn rate(&self, response: i128) -> (i128, i128) {
        let part = |time: i128| {
            if self.period == FAR { 0 } else { (self.most * time + self.period - 1) / self.period }
        };
        (part(1 << 32), part(self.response + response) + 2 * self.most)
    }

    /// par: what a job's chains here can do while one of their nodes waits so long.
    pub(crate) fn beside(lengths: &[i128], wait: i128) -> i128 {
        let all: i128 = lengths.iter().map(|length| *length.min(&wait)).sum();
        let free: i128 = lengths.iter().map(|length| (wait - length).max(0)).sum();
        all - (wait - free).max(0)
    }
}

/// The largest of so many numbers, of each with how often it is there.
pub(crate) fn largest(mut numbers: Vec<(i128, i128)>, mut count: i128) -> Vec<(i128, i128)> {
    numbers.sort_unstable_by(|a, b| b.cmp(a));
    for (_, times) in &mut numbers {
        *times = count.min(*times).max(0);
        count -= *times;
    }
    numbers.retain(|(_, times)| *times > 0);
    numbers
}

#[cfg(test)]
mod tests;
