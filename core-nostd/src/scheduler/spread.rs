//! A job alone on its pools: how many lanes of one it needs, from when and until when.
//!
//! *Rule.* The first ready node by rank goes on a lane as soon as one is free, of several on the one that was busy last. Nodes of
//! other pools start when they are ready. A job takes as few lanes as end it by its deadline; all, if no number does.

use super::version::Version;
use crate::capacity::{Capacity, Empty};
use crate::graph::Node;

crate::capacity::stored! {
    /// When a job needs a lane for the first time, and until when, after its release in nanoseconds; 0 and 0: never.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Held {
        pub(super) from: u64,
        pub(super) until: u64,
    }
}

crate::capacity::stored! {
    /// The lanes of the pool, and when the job ends.
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Spread<C: Capacity> {
        pub(super) held: C::Lanes<Held>,
        pub(super) end: u64,
    }
}

impl<C: Capacity> Version<C> {
    /// The lanes of a pool that a job needs so as to end within `due`. Time bound: O(lanes * nodes * (nodes + lanes)).
    pub(super) fn spread(&self, pool: usize, lanes: usize, due: u64, nodes: &C::Nodes<Node>) -> Spread<C> {
        let least = self.work[pool].div_ceil(due.max(1)).max(1) as usize;
        let on = |count: usize| self.spread_on(pool, count, nodes);
        (least..lanes).map(on).find(|spread| spread.end <= due).unwrap_or_else(|| on(lanes))
    }

    fn spread_on(&self, pool: usize, count: usize, nodes: &C::Nodes<Node>) -> Spread<C> {
        let (mut new, mut ready) = (Spread::<C>::EMPTY, <C::Nodes<u64>>::EMPTY);
        let (mut open, mut waiting_for, here) = (self.sources, self.indegree, &self.in_pool[pool]);
        // Each round starts a node.
        loop {
            let free = new.held.as_ref().iter().take(count).map(|lane| lane.until).min().unwrap_or_default();
            let start = |rank| (ready[rank].max(if here.contains(rank) { free } else { 0 }), rank);
            let Some((start, rank)) = open.iter().map(start).min() else { return new };
            let end = start.saturating_add(nodes[usize::from(self.order[rank])].cost());
            let lanes = new.held.as_mut().iter_mut().take(count);
            let lane = lanes.filter(|lane| lane.until <= start).max_by_key(|lane| lane.until);
            if let Some(lane) = lane.filter(|_| here.contains(rank)) {
                *lane = Held { from: if lane.until == 0 { start } else { lane.from }, until: end };
            }
            new.end = new.end.max(end);
            open.remove(rank);
            self.successors[rank].each(|next| {
                ready[next] = ready[next].max(end);
                waiting_for[next] = waiting_for[next].saturating_sub(1);
                open.insert_if(next, waiting_for[next] == 0);
            });
        }
    }
}
