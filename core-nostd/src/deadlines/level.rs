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
use crate::graph::{Dag, Levels};
use crate::id::NodeId;
use crate::time::Duration;

/// Where each level's share ends, relative to the release.
#[derive(Clone, Copy, Debug)]
pub struct LevelShares<C: Capacity> {
    ends: C::Nodes<u64>,
    costs: C::Nodes<u64>,
    graham: C::Nodes<u64>,
    count: usize,
}

impl<C: Capacity> LevelShares<C> {
    /// Number of levels.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// End of level `h`, in nanoseconds after the release.
    pub fn end(&self, h: usize) -> i64 {
        self.ends[h].cast_signed()
    }

    /// Length of level `h`'s share in nanoseconds.
    pub fn share(&self, h: usize) -> u64 {
        self.ends[h] - if h == 0 { 0 } else { self.ends[h - 1] }
    }

    /// Cost of level `h`: S_h in nanoseconds.
    pub fn cost(&self, h: usize) -> u64 {
        self.costs[h]
    }

    /// Graham's bound of level `h`: g_h in nanoseconds.
    pub fn graham(&self, h: usize) -> u64 {
        self.graham[h]
    }
}

/// Divides `deadline` among the levels by `rule` (LevelGraham, else LevelSum). Time bound: O(nodes * pools).
pub fn shares<C: Capacity>(
    dag: &Dag<C>,
    levels: &Levels<C>,
    rule: DeadlineRule,
    deadline: Duration,
    lanes: &[u8],
) -> LevelShares<C> {
    let d = deadline.as_nanos();
    let count = levels.count();
    let mut weights = <C::Nodes<u128>>::EMPTY;
    let mut shares =
        LevelShares::<C> { ends: Empty::EMPTY, costs: Empty::EMPTY, graham: Empty::EMPTY, count };
    for i in levels.places() {
        shares.costs[levels.height(NodeId::new(i as u8))] += dag.at(i).cost();
    }
    graham_bounds(dag, levels, lanes, &mut shares, &mut weights);
    let bound: u128 = (0..count).map(|h| u128::from(shares.graham[h])).sum();
    let guaranteed = rule == DeadlineRule::LevelGraham && bound <= u128::from(d);
    if rule != DeadlineRule::LevelGraham {
        (0..count).for_each(|h| weights[h] = u128::from(shares.costs[h]));
    }
    if (0..count).all(|h| weights[h] == 0) {
        (0..count).for_each(|h| weights[h] = 1);
    }
    let total: u128 = (0..count).map(|h| weights[h]).sum();
    let spare = if guaranteed { d - bound as u64 } else { d };
    let (mut prefix, mut base) = (0, 0);
    for h in 0..count {
        prefix += weights[h];
        base += if guaranteed { shares.graham[h] } else { 0 };
        shares.ends[h] = base + share(spare, prefix, total);
    }
    shares
}

/// g_h and w_h of every level, the maximum over the pools that the graph uses.
fn graham_bounds<C: Capacity>(
    dag: &Dag<C>,
    levels: &Levels<C>,
    lanes: &[u8],
    shares: &mut LevelShares<C>,
    weights: &mut C::Nodes<u128>,
) {
    let uses = |pool: usize| levels.places().any(|i| dag.at(i).pool.index() == pool);
    let several = (0..C::POOLS).filter(|p| uses(*p)).count() > 1;
    for pool in (0..C::POOLS).filter(|p| uses(*p)) {
        let (mut sum, mut longest) = (<C::Nodes<u64>>::EMPTY, <C::Nodes<u64>>::EMPTY);
        for i in levels.places().filter(|i| dag.at(*i).pool.index() == pool) {
            let h = levels.height(NodeId::new(i as u8));
            sum[h] += dag.at(i).cost();
            longest[h] = longest[h].max(dag.at(i).cost());
        }
        let m = lanes.get(pool).map_or(1, |m| u64::from((*m).max(1)));
        for h in 0..levels.count() {
            let bound = longest[h] + (sum[h] - longest[h]).div_ceil(m);
            let weight = u128::from(m) * u128::from(longest[h]) + u128::from(sum[h] - longest[h]);
            shares.graham[h] = shares.graham[h].max(bound);
            weights[h] = if several { u128::from(shares.graham[h]) } else { weight };
        }
    }
}

#[cfg(test)]
mod tests;
