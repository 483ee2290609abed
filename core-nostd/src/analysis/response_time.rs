//! Response-time bounds of one DAG alone on its pools.
//!
//! *Background.* A work-conserving schedule is busy on all m lanes whenever no node of the critical chain runs.
//! *Rule.* Graham: L + ceil((W - L) / m). Long path: the minimum over j < m of L + ceil((W - len_0 - ... -
//! len_j) / (m - j)), paths peeled greedily, longest first; after each its nodes cost nothing but still
//! connect. Several pools: floor((1 - 1 / max m) * L) + 1 + the sum over pools of ceil(W_p / m_p).
//! *Why it holds.* Graham 1969; the multi-path bound of He et al. (RTSS 2022, arXiv 2310.15471); paper section
//! 3.5 states neither. *Time bound:* O(lanes * (nodes + edges)).

use super::{Bound, Certificate};
use crate::capacity::{Capacity, Empty};
use crate::graph::{Dag, Levels};
use crate::time::{Bytes, Duration};

/// Bounds the response time of `dag`. `limit` is min(D, T); `lanes` and `budgets` are by pool.
///
/// ```
/// use red_core::{Caps, Dag, Duration, Node, Wcet, response_time};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// for _ in 0..4 {
///     dag.add_node(Node::new(Wcet::from_millis(3)))?;
/// }
/// let proof = response_time(&dag, Duration::from_millis(10), &[2], &[None]);
/// assert!(proof.fits());
/// assert_eq!(proof.response.as_nanos(), 7_500_000); // Graham: 3 + (12 - 3) / 2
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn response_time<C: Capacity>(
    dag: &Dag<C>,
    limit: Duration,
    lanes: &[u8],
    budgets: &[Option<Bytes>],
) -> Certificate {
    bound_by_levels(dag, &Levels::of(dag), limit, lanes, budgets)
}

/// `response_time` for who has the levels already.
pub(crate) fn bound_by_levels<C: Capacity>(
    dag: &Dag<C>,
    levels: &Levels<C>,
    limit: Duration,
    lanes: &[u8],
    budgets: &[Option<Bytes>],
) -> Certificate {
    let lanes_of = |pool: usize| lanes.get(pool).map_or(1, |m| u64::from((*m).max(1)));
    let mut per_pool = <C::Pools<u64>>::EMPTY;
    let (mut used, mut longest) = (0u32, 0);
    for i in levels.places() {
        longest = longest.max(levels.paths()[i]);
        per_pool[dag.at(i).pool.index()] += dag.at(i).cost();
        used |= 1 << dag.at(i).pool.index();
    }
    let pools = || (0..C::POOLS).filter(move |p| used >> p & 1 != 0);
    let widest = pools().map(lanes_of).max().unwrap_or(1);
    let (bound, response) = if used.count_ones() > 1 {
        let scaled = u128::from(longest) * u128::from(widest - 1) / u128::from(widest);
        let shares = pools().fold(0u64, |sum, p| sum.saturating_add(per_pool[p].div_ceil(lanes_of(p))));
        (Bound::SeveralPools, (scaled as u64 + 1).saturating_add(shares))
    } else {
        let graham = (Bound::Graham, longest + (dag.work() - longest).div_ceil(widest));
        if widest == 1 { graham } else { long_path(dag, levels, widest, graham) }
    };
    Certificate {
        bound,
        lanes: widest as u8,
        work: Duration::from_nanos(dag.work()),
        critical_path: Duration::from_nanos(longest),
        response: Duration::from_nanos(response),
        limit,
        memory_holds: pools().all(|p| {
            budgets
                .get(p)
                .copied()
                .flatten()
                .is_none_or(|budget| never_waits_for_memory(dag, p, lanes_of(p), budget))
        }),
    }
}

/// The long-path bound of the number of paths that makes it least, where it is below `graham`.
fn long_path<C: Capacity>(
    dag: &Dag<C>,
    levels: &Levels<C>,
    widest: u64,
    graham: (Bound, u64),
) -> (Bound, u64) {
    let mut paths = Peeler::new(dag, levels);
    let longest = paths.longest(levels);
    let (mut rest, mut best) = (dag.work() - longest, graham);
    for j in 1..widest {
        rest -= paths.peel(dag, levels);
        let value = longest + rest.div_ceil(widest - j);
        if value < best.1 {
            best = (Bound::LongPath { paths: j as u8 }, value);
        }
    }
    best
}

/// Takes the longest path away again and again; nodes on it cost nothing afterwards.
struct Peeler<C: Capacity> {
    cost: C::Nodes<u64>,
    /// Longest path from each node on, itself included.
    path: C::Nodes<u64>,
}

impl<C: Capacity> Peeler<C> {
    fn new(dag: &Dag<C>, levels: &Levels<C>) -> Self {
        let mut cost = <C::Nodes<u64>>::EMPTY;
        levels.places().for_each(|i| cost[i] = dag.at(i).cost());
        Self { cost, path: *levels.paths() }
    }

    /// Length of the longest path, in nanoseconds.
    fn longest(&self, levels: &Levels<C>) -> u64 {
        levels.places().map(|i| self.path[i]).max().unwrap_or(0)
    }

    /// Takes the longest path away; returns the length of the longest that is left. Ties go to the lowest node
    /// id.
    fn peel(&mut self, dag: &Dag<C>, levels: &Levels<C>) -> u64 {
        let length = self.longest(levels);
        let mut at = dag.present().iter().find(|i| self.path[*i] == length);
        // A path visits a node at most once: at most C::NODES rounds.
        while let Some(i) = at {
            let left = self.path[i] - self.cost[i];
            self.cost[i] = 0;
            at = dag.out(i).iter().find(|j| self.path[*j] == left);
        }
        for i in levels.places().rev() {
            let mut after = 0;
            dag.out(i).each(|j| after = after.max(self.path[j]));
            self.path[i] = self.cost[i] + after;
        }
        self.longest(levels)
    }
}

/// Whether the pool's `lanes` largest footprints and every output that could be cached fit together.
fn never_waits_for_memory<C: Capacity>(dag: &Dag<C>, pool: usize, lanes: u64, budget: Bytes) -> bool {
    let here = |i: &usize| dag.at(*i).pool.index() == pool;
    let outputs: u128 = dag
        .present()
        .iter()
        .filter(here)
        .filter(|i| matches!(dag.at(*i).role, crate::graph::Role::SharedEncoder(_)))
        .map(|i| u128::from(dag.at(i).memory.0))
        .sum();
    let (mut largest, mut left) = (0u128, *dag.present());
    for _ in 0..lanes {
        let Some(i) = left.iter().filter(here).max_by_key(|i| dag.at(*i).memory.0) else { break };
        largest += u128::from(dag.at(i).memory.0);
        left.remove(i);
    }
    outputs + largest <= u128::from(budget.0)
}
