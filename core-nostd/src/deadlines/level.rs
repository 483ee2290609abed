//! Level shares: the paper's LevelSum (Def. 4) and LevelGraham, by cumulative integer division.
//!
//! *Background.* D is divided among the levels of a graph; a node is due when its level's share ends.
//! *Rule.* LevelSum: end(h) = floor(D * prefix(S)_h / W), S_h the cost of level h, W the work; W = 0: weight 1
//! per level. LevelGraham: w_h = m * max_h + (S_h - max_h) on m lanes, g_h = ceil(w_h / m) is Graham's bound
//! of the level; if the g_h fit into D, each level gets g_h and the rest is divided by w, else D is divided
//! by w. A task whose nodes lie in several pools: g_h = w_h = the maximum over its pools.
//! *Why it holds.* Prefixes are divided, not shares: the last end is D exactly, ends are monotone, and each
//! share is within one nanosecond of exact. Dividing level by level would lose time.

use super::DeadlineRule;
use super::exact::share;
use crate::capacity::{Capacity, Empty};
use crate::graph::Levels;
use crate::time::Duration;

crate::capacity::stored! {
    /// What one level asks for and what it gets, in nanoseconds.
    #[derive(Clone, Copy, Debug)]
    pub struct LevelShare {
        /// S_h: the cost of its nodes.
        pub cost: u64,
        /// g_h: Graham's bound.
        pub graham: u64,
        /// Length of its share of the deadline.
        pub share: u64,
        /// When its share ends, after the release.
        pub end: u64,
        weight: u128,
    }
}

/// Divides `deadline` among the levels by `rule` (LevelGraham, else LevelSum), level by level. `lanes` is by pool.
/// Time bound: O(nodes * pools).
pub fn shares<C: Capacity>(
    levels: &Levels<'_, C>,
    rule: DeadlineRule,
    deadline: Duration,
    lanes: &[u8],
) -> C::Nodes<LevelShare> {
    let (d, count) = (deadline.as_nanos(), levels.count());
    let mut shares = <C::Nodes<LevelShare>>::EMPTY;
    for i in levels.places() {
        shares[levels.height[i].into()].cost += levels.dag.at(i).cost();
    }
    graham_bounds(levels, lanes, &mut shares);
    let sum = |of: fn(&LevelShare) -> u128, shares: &C::Nodes<LevelShare>| -> u128 {
        shares.as_ref().iter().take(count).map(of).sum()
    };
    let bound = sum(|level| level.graham.into(), &shares);
    let guaranteed = rule == DeadlineRule::LevelGraham && bound <= u128::from(d);
    if rule != DeadlineRule::LevelGraham {
        (0..count).for_each(|h| shares[h].weight = shares[h].cost.into());
    }
    if sum(|level| level.weight, &shares) == 0 {
        (0..count).for_each(|h| shares[h].weight = 1);
    }
    let total = sum(|level| level.weight, &shares);
    let spare = if guaranteed { d - bound as u64 } else { d };
    let (mut prefix, mut base, mut before) = (0, 0, 0);
    for level in shares.as_mut().iter_mut().take(count) {
        prefix += level.weight;
        base += if guaranteed { level.graham } else { 0 };
        level.end = base + share(spare, prefix, total);
        level.share = level.end - before;
        before = level.end;
    }
    shares
}

/// g_h and w_h of every level, the maximum over the pools that the graph uses.
fn graham_bounds<C: Capacity>(levels: &Levels<'_, C>, lanes: &[u8], shares: &mut C::Nodes<LevelShare>) {
    let in_pool = |pool: usize| levels.places().filter(move |i| levels.dag.at(*i).pool.index() == pool);
    let used = || (0..C::POOLS).filter(|pool| in_pool(*pool).next().is_some());
    let several = used().count() > 1;
    for pool in used() {
        let (mut sum, mut longest) = (<C::Nodes<u64>>::EMPTY, <C::Nodes<u64>>::EMPTY);
        for i in in_pool(pool) {
            let (h, cost) = (levels.height[i].into(), levels.dag.at(i).cost());
            sum[h] += cost;
            longest[h] = longest[h].max(cost);
        }
        let m = lanes.get(pool).map_or(1, |m| u64::from((*m).max(1)));
        for h in 0..levels.count() {
            let (level, rest) = (&mut shares[h], sum[h] - longest[h]);
            level.graham = level.graham.max(longest[h] + rest.div_ceil(m));
            let weight = u128::from(m) * u128::from(longest[h]) + u128::from(rest);
            level.weight = if several { level.graham.into() } else { weight };
        }
    }
}

#[cfg(test)]
mod tests;
