//! What soon takes a lane, in the order in which it does.

use super::spread::Need;
use crate::capacity::{Capacity, Empty};

crate::capacity::stored! {
    /// A node that takes a lane, and when it is ready, in nanoseconds.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub(super) struct Soon {
        pub(super) key: i64,
        pub(super) at: u64,
        pub(super) cost: u64,
        /// Whether its job is of a higher rank than the head's.
        pub(super) outranks: bool,
        /// Of the head, or of all of a job of a higher rank that has not started, in bytes.
        pub(super) memory: u64,
    }
}

/// What comes before the head ends; as many as jobs have places, the first by key.
#[derive(Debug)]
pub(super) struct Coming<C: Capacity> {
    soon: C::Jobs<Soon>,
    count: usize,
    head: Soon,
    /// Whether what is ready counts too, of a higher rank: it wants no lane of the head's, but it may want its memory.
    is_limited: bool,
}

impl<C: Capacity> Coming<C> {
    pub(super) fn new(head: Soon, is_limited: bool) -> Self {
        Self { soon: Empty::EMPTY, count: 0, head, is_limited }
    }

    /// When the head ends.
    pub(super) fn end(&self) -> u64 {
        self.head.at.saturating_add(self.head.cost)
    }

    pub(super) fn meet(&mut self, mut node: Soon) {
        let (now, end) = (self.head.at, self.end());
        let before = if node.outranks { signed(end) } else { self.head.key.min(signed(end)) };
        let is_soon = node.at > now || self.is_limited && node.outranks;
        if is_soon && node.at < end && node.key < before {
            for place in self.soon.as_mut().iter_mut().take(self.count) {
                (*place, node) = (node.min(*place), node.max(*place));
            }
            if self.count < C::JOBS {
                self.soon[self.count] = node;
                self.count += 1;
            }
        }
    }

    /// Of a job of a higher rank all lanes that it needs after some instant, at the earliest from another one on; `may_replace`: where
    /// there is no place, of a later key.
    pub(super) fn meet_need(&mut self, after: u64, earliest: u64, need: &Need<C>, may_replace: bool) {
        for (from, cost) in need.lanes() {
            if !may_replace && self.count == C::JOBS {
                return;
            }
            let from = after.saturating_add(from);
            let at = from.max(earliest);
            let key = signed(from).saturating_add(need.spare).max(signed(at));
            self.meet(Soon { key, at, cost, outranks: true, memory: need.memory });
        }
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &Soon> {
        self.soon.as_ref().iter().take(self.count)
    }
}

/// Takes the lane that is free first; when the node starts there.
pub(super) fn take<C: Capacity>(free: &mut C::Lanes<u64>, node: &Soon) -> i64 {
    let Some(lane) = free.as_mut().iter_mut().min() else { return i64::MAX };
    let start = node.at.max(*lane);
    *lane = start.saturating_add(node.cost);
    signed(start)
}

pub(super) fn signed(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX)
}
