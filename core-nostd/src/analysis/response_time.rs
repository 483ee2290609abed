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
use crate::graph::{Dag, Levels, NodeSet, Role};
use crate::time::{Bytes, Duration};

/// Bounds the response time of a graph. `limit` is min(D, T); `lanes` and `budgets` are by pool.
///
/// ```
/// use red_core::{Caps, Dag, Duration, Levels, Node, Wcet, response_time};
/// let mut dag = Dag::<Caps<1, 8, 1>>::new();
/// for _ in 0..4 {
///     dag.add_node(Node::new(Wcet::from_millis(3)))?;
/// }
/// let proof = response_time(&Levels::of(&dag), Duration::from_millis(10), &[2], &[None]);
/// assert!(proof.fits());
/// assert_eq!(proof.response.as_nanos(), 7_500_000); // Graham: 3 + (12 - 3) / 2
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn response_time<C: Capacity>(
    levels: &Levels<'_, C>,
    limit: Duration,
    lanes: &[u8],
    budgets: &[Option<Bytes>],
) -> Certificate {
    let (dag, longest) = (levels.dag, levels.critical_path());
    let lanes_of = |pool: usize| lanes.get(pool).map_or(1, |m| u64::from((*m).max(1)));
    let mut work = <C::Pools<u64>>::EMPTY;
    let mut used = 0;
    for node in levels.places().map(|i| dag.at(i)) {
        work[node.pool.index()] += node.cost();
        used |= 1u32 << node.pool.index();
    }
    let pools = || (0..C::POOLS).filter(move |p| used >> p & 1 != 0);
    let widest = pools().map(lanes_of).max().unwrap_or(1);
    let (bound, response) = if used.count_ones() > 1 {
        let scaled = u128::from(longest) * u128::from(widest - 1) / u128::from(widest);
        let shares = pools().fold(0u64, |sum, p| sum.saturating_add(work[p].div_ceil(lanes_of(p))));
        (Bound::SeveralPools, (scaled as u64 + 1).saturating_add(shares))
    } else {
        let graham = (Bound::Graham, longest + (dag.work() - longest).div_ceil(widest));
        if widest == 1 { graham } else { long_path(levels, widest, graham) }
    };
    let holds = |p| {
        let budget = budgets.get(p).copied().flatten();
        budget.is_none_or(|budget| never_waits_for_memory(dag, p, lanes_of(p), budget))
    };
    Certificate {
        bound,
        lanes: widest as u8,
        work: Duration::from_nanos(dag.work()),
        critical_path: Duration::from_nanos(longest),
        response: Duration::from_nanos(response),
        limit,
        memory_holds: pools().all(holds),
    }
}

/// The long-path bound of the number of paths that makes it least, where it is below `graham`.
fn long_path<C: Capacity>(levels: &Levels<'_, C>, m: u64, graham: (Bound, u64)) -> (Bound, u64) {
    let (dag, first) = (levels.dag, levels.critical_path());
    let (mut cost, mut path) = (<C::Nodes<u64>>::EMPTY, levels.path);
    levels.places().for_each(|i| cost[i] = dag.at(i).cost());
    let (mut length, mut rest, mut best) = (first, dag.work() - first, graham);
    for j in 1..m {
        // Takes the longest path away; ties go to the lowest node id. A path visits a node at most once.
        let mut at = dag.present.iter().find(|i| path[*i] == length);
        while let Some(i) = at {
            let left = path[i] - cost[i];
            cost[i] = 0;
            at = dag.out(i).iter().find(|j| path[*j] == left);
        }
        levels.places().rev().for_each(|i| path[i] = cost[i] + dag.out(i).largest(&path));
        length = dag.present.largest(&path);
        rest -= length;
        let value = first + rest.div_ceil(m - j);
        if value < best.1 {
            best = (Bound::LongPath { paths: j as u8 }, value);
        }
    }
    best
}

/// Whether the pool's `lanes` largest footprints and every output that could be cached fit together.
fn never_waits_for_memory<C: Capacity>(dag: &Dag<C>, pool: usize, lanes: u64, budget: Bytes) -> bool {
    let bytes = |i: usize| u128::from(dag.at(i).memory.0);
    let mut left = NodeSet::<C>::EMPTY;
    dag.present.each(|i| left.insert_if(i, dag.at(i).pool.index() == pool));
    let is_encoder = |i: &usize| matches!(dag.at(*i).role, Role::SharedEncoder(_));
    let mut needed: u128 = left.iter().filter(is_encoder).map(bytes).sum();
    for _ in 0..lanes {
        let Some(i) = left.iter().max_by_key(|i| bytes(*i)) else { break };
        needed += bytes(i);
        left.remove(i);
    }
    needed <= u128::from(budget.0)
}
