//! DynamicMerge (paper Alg. 1): which ready encoders join one dispatch unit.
//!
//! *Background.* The paper merges iff abs(r_u - r_v) <= gamma, which is not transitive, and lets a unit wait.
//! *Rule.* A unit is formed at dispatch from ready members of one pool and one frame key. Members sorted by
//! release fall into windows [r_first, r_first + gamma]; the unit is the window of the queue's head. A member
//! whose cost equals the unit's always joins; another joins only if the larger cost still ends by the
//! earliest latest finish of all. *Why it holds.* Equal costs change nobody's finish; the guard refuses every
//! other merge that could cost a deadline at the estimates used.

use crate::time::{Duration, Instant};

/// A unit under formation, or one member.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    pub(crate) cost: u64,
    /// a + D - tail; below zero for hopeless members.
    pub(crate) latest_finish: i64,
}

/// The unit with `member` in it, or `None` if the guard refuses.
pub(crate) fn join(unit: Candidate, member: Candidate, now: Instant) -> Option<Candidate> {
    let both = Candidate {
        cost: unit.cost.max(member.cost),
        latest_finish: unit.latest_finish.min(member.latest_finish),
    };
    let ends = i128::from(now.as_nanos()) + i128::from(both.cost);
    (unit.cost == member.cost || ends <= both.latest_finish.into()).then_some(both)
}

/// Start of the window that contains `head`: windows are laid from the earliest release on, each anchored at
/// its first member. `releases` may come in any order and any number of times.
pub(crate) fn window_of(
    head: Instant,
    skew: Duration,
    releases: &(impl Iterator<Item = Instant> + Clone),
) -> Instant {
    let mut anchor = releases.clone().min().unwrap_or(head).min(head);
    // Each round moves to a later release, so there are at most as many rounds as jobs.
    while head > anchor.saturating_add(skew) {
        let end = anchor.saturating_add(skew);
        anchor = releases.clone().filter(|r| *r > end).min().unwrap_or(head).min(head);
    }
    anchor
}

#[cfg(test)]
mod tests;
