//! Path rules: latest finish, latest start, path-proportional.
//!
//! *Background.* The backward pass of critical-path scheduling, anchored at the end-to-end deadline.
//! *Rule.* Latest finish d = D - tail; latest start d - c; path-proportional d = floor(D * head / (head +
//! tail)), sinks and nodes with head + tail = 0 get D.
//! *Why it holds.* Along every source-to-sink path the shares d_v - d_pred telescope to exactly D, and d_v -
//! d_u >= c_v on each edge; missing d_v proves, at WCET, that the job is lost. No division, no rounding.

use super::exact::share;
use crate::capacity::Capacity;
use crate::graph::Levels;

pub(super) fn latest_finish<C: Capacity>(levels: &Levels<'_, C>, d: u64, due: &mut C::Nodes<i64>) {
    levels.places().for_each(|i| due[i] = d.cast_signed().saturating_sub_unsigned(levels.tail_at(i)));
}

pub(super) fn proportional<C: Capacity>(levels: &Levels<'_, C>, d: u64, due: &mut C::Nodes<i64>) {
    let heads = levels.heads();
    for i in levels.places() {
        let (head, tail) = (u128::from(heads[i]), u128::from(levels.tail_at(i)));
        let is_last = levels.dag.out(i).is_empty() || head + tail == 0;
        due[i] = if is_last { d } else { share(d, head, head + tail) }.cast_signed();
    }
}
