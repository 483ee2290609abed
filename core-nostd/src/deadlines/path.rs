//! Path rules: latest finish, latest start, path-proportional.
//!
//! *Background.* The backward pass of critical-path scheduling, anchored at the end-to-end deadline.
//! *Rule.* Latest finish d = D - tail; latest start d - c; path-proportional d = floor(D * head / (head +
//! tail)), sinks and nodes with head + tail = 0 get D.
//! *Why it holds.* Along every source-to-sink path the shares d_v - d_pred telescope to exactly D, and d_v -
//! d_u >= c_v on each edge; missing d_v proves, at WCET, that the job is lost. No division, no rounding.

use super::exact::share;
use crate::capacity::Capacity;
use crate::graph::{Dag, Levels, heads, tails};

/// `at - span`, for spans beyond the signed range too.
pub(crate) const fn before(at: i64, span: u64) -> i64 {
    at.saturating_sub_unsigned(span)
}

pub(super) fn latest_finish<C: Capacity>(dag: &Dag<C>, levels: &Levels<C>, d: u64, due: &mut C::Nodes<i64>) {
    let tail = |i: usize| levels.paths()[i] - dag.at(i).cost();
    levels.places().for_each(|i| due[i] = before(d.cast_signed(), tail(i)));
}

pub(super) fn proportional<C: Capacity>(dag: &Dag<C>, levels: &Levels<C>, d: u64, due: &mut C::Nodes<i64>) {
    let (head, tail) = (heads(dag, levels), tails(dag, levels));
    for i in levels.places() {
        let path = u128::from(head[i]) + u128::from(tail[i]);
        let is_last = dag.out(i).is_empty() || path == 0;
        due[i] = if is_last { d } else { share(d, u128::from(head[i]), path) }.cast_signed();
    }
}
