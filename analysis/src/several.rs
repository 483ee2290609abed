//! The test for a task with nodes in several clusters.
//!
//! *Rule.* Choose waits Y by cluster, R = L + sum of Y. If in each cluster p that it uses m_p (Y_p + 1) > own_p(Y_p + 1) +
//! I_p(R, Y_p + 1), no job responds later than R.
//! *Why it holds.* A job that is unfinished at R has waited for sum Y + 1 at least, so in some cluster for Y_p + 1: there all
//! lanes were busy, which is a contradiction. A node that comes from another cluster frees no lane here, so all of them may
//! have nodes of lower rank at each such entry. Han et al. (TPDS 2019), with interference.

use crate::interference::{Keys, Looked, Window};
use crate::shape::Part;

/// A task's part in one cluster, and who else is there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InCluster<'a> {
    pub(crate) cluster: usize,
    pub(crate) looked: Looked<'a>,
    pub(crate) part: &'a Part,
}

/// Waits by cluster that prove a response time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Waits {
    pub(crate) response: i128,
    pub(crate) keys: Keys,
    /// Of each cluster that the task uses.
    pub(crate) waits: Vec<(usize, i128)>,
}

const ROUNDS: usize = 200;

impl InCluster<'_> {
    fn own(&self, y: i128) -> i128 {
        let hidden = (y - self.part.beyond(y)).max(0);
        (self.part.work - self.part.least).min(self.part.capped(y) - hidden)
    }

    /// The right side, for a response time and a wait.
    fn demand(&self, keys: Keys, response: i128, y: i128) -> i128 {
        let w = Window { win: response, cap: y };
        let sum = |keys| {
            self.looked.others.iter().map(|other| self.looked.carried(other, w, 0, keys)).sum::<i128>()
        };
        let all = sum(Keys::Any);
        self.own(y)
            + match keys {
                Keys::Any => all,
                Keys::Key => {
                    let before = sum(Keys::Key);
                    before + (all - before).min(self.later(response))
                }
            }
    }

    /// Nodes of lower rank along the path that meets most of them.
    fn later(&self, response: i128) -> i128 {
        let at_entry = self.looked.pick(self.looked.lanes, response - 1);
        let inside = self.looked.pick(self.looked.lanes - 1, response - 1);
        let mut sums: Vec<i128> = Vec::with_capacity(self.part.places.len());
        for place in &self.part.places {
            let before = place.before.iter().map(|at| sums[*at]).max().unwrap_or(0);
            let here = match (place.is_here, place.enters) {
                (false, _) => 0,
                (true, true) => at_entry,
                (true, false) => inside,
            };
            sums.push(before + here);
        }
        sums.into_iter().max().unwrap_or(0)
    }
}

/// The least waits that are stable, if the response time with them is within `limit`.
pub(crate) fn waits(parts: &[InCluster<'_>], longest: i128, limit: i128) -> Option<Waits> {
    let of = |keys| -> Option<Waits> {
        let mut waits = vec![0; parts.len()];
        let mut last_steps = vec![None; parts.len()];
        for _ in 0..ROUNDS {
            let response = longest + waits.iter().sum::<i128>();
            if response > limit {
                return None;
            }
            let needed = |((part, wait), last): ((&InCluster<'_>, &i128), &mut Option<i128>)| {
                let needed = part.demand(keys, response, wait + 1) / part.looked.lanes;
                if needed <= *wait { *wait } else { part.looked.next_wait(part.part, *wait, needed, last) }
            };
            let next: Vec<i128> = parts.iter().zip(&waits).zip(&mut last_steps).map(needed).collect();
            if next == waits {
                let waits = parts.iter().map(|part| part.cluster).zip(waits).collect();
                return Some(Waits { response, keys, waits });
            }
            waits = next;
        }
        None
    };
    [Keys::Key, Keys::Any].into_iter().filter_map(of).min_by_key(|found| found.response)
}

#[cfg(test)]
mod tests;
