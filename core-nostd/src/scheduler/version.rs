//! One version of a task's graph, laid out for dispatch.
//!
//! Nodes are renumbered by (key, node id): their *rank*. Every rule that is not re-assigned gives a node the
//! key release + constant, so inside a job the next node is the lowest set bit of its ready ranks, and no heap
//! is needed below the level of jobs. Under residual re-assignment all ready nodes of a job share one key
//! (they are the sources of what remains), so ranks go by node id there.

use crate::capacity::{Capacity, Empty};
use crate::config::{Config, Gate};
use crate::deadlines::SubDeadlines;
use crate::graph::{Dag, Levels, Node, NodeSet, Role};
use crate::time::Duration;
use core::hint::select_unpredictable;

crate::capacity::stored! {
    #[derive(Clone, Copy, Debug)]
    pub(super) struct Version<C: Capacity> {
        /// Hot: what completing and dispatching a node reads.
        pub(super) len: u16,
        /// Jobs in flight that have this version.
        pub(super) users: u8,
        /// Whether precedence alone readies its nodes: no encoder, no decoder, no other gate.
        pub(super) is_plain: bool,
        /// Pools that its nodes use, a bit each.
        pub(super) pool_mask: u32,
        /// What a job has left at its release: D less the least time in which it can end at WCET.
        pub(super) slack: i64,
        /// Work by pool at WCET, in nanoseconds.
        pub(super) work: C::Pools<u64>,
        pub(super) sources: NodeSet<C>,
        pub(super) encoders: NodeSet<C>,
        pub(super) decoders: NodeSet<C>,
        /// Ranks by pool.
        pub(super) in_pool: C::Pools<NodeSet<C>>,
        /// By rank: successors, key relative to the release, node id, number of predecessors, height.
        pub(super) successors: C::Nodes<NodeSet<C>>,
        pub(super) key: C::Nodes<i64>,
        pub(super) order: C::Nodes<u8>,
        pub(super) indegree: C::Nodes<u8>,
        pub(super) height: C::Nodes<u8>,
        /// Ranks in topological order.
        pub(super) topological: C::Nodes<u8>,
    }
}

impl<C: Capacity> Version<C> {
    /// Lays a graph out in place, which is large. Time bound: O(nodes log nodes + edges).
    pub(super) fn lay_out(&mut self, levels: &Levels<'_, C>, config: &Config, due: Duration, lanes: &[u8]) {
        let (new, dag) = (self, levels.dag);
        // What is stored by rank is overwritten below, as far as anybody looks; the sets are filled.
        (new.sources, new.encoders, new.decoders) = (NodeSet::EMPTY, NodeSet::EMPTY, NodeSet::EMPTY);
        (new.in_pool, new.pool_mask, new.users) = (Empty::EMPTY, 0, 0);
        new.work = Empty::EMPTY;
        let assigned = SubDeadlines::assign(levels, config.rule, due, lanes);
        let sorted = Self::sorted(levels, |node| if config.residual() { 0 } else { assigned.key[node] });
        let len = dag.len();
        new.len = len as u16;
        let mut rank_of = <C::Nodes<u8>>::EMPTY;
        for rank in 0..len {
            let node = usize::from(sorted[rank] as u8);
            rank_of[node] = rank as u8;
            new.order[rank] = node as u8;
            new.key[rank] = assigned.key[node];
            new.indegree[rank] = dag.indegree[node];
            new.height[rank] = levels.height[node];
            let pool = dag.at(node).pool.index();
            new.in_pool[pool].insert(rank);
            new.work[pool] = new.work[pool].saturating_add(dag.at(node).cost());
            new.pool_mask |= 1 << pool;
            new.sources.insert_if(rank, new.indegree[rank] == 0);
            match dag.at(node).role {
                Role::SharedEncoder(_) => new.encoders.insert(rank),
                Role::Decoder => new.decoders.insert(rank),
                Role::Ordinary => {}
            }
        }
        let all_ordinary = new.encoders.is_empty() && new.decoders.is_empty();
        new.is_plain = all_ordinary && config.gate == Gate::Precedence;
        for rank in 0..len {
            let successors = &mut new.successors[rank];
            *successors = NodeSet::EMPTY;
            dag.out(usize::from(new.order[rank])).each(|j| successors.insert(usize::from(rank_of[j])));
        }
        for (i, node) in levels.places().enumerate() {
            new.topological[i] = rank_of[node];
        }
        new.bound_slack(levels.critical_path(), lanes, due);
    }

    /// What a job has to spare, in nanoseconds, by its longest path and by its work on so many lanes of each pool. Time bound: O(pools).
    pub(super) fn bound_slack(&mut self, path: u64, lanes: &[u8], due: Duration) {
        let lanes = lanes.iter().map(|lanes| u64::from((*lanes).max(1)));
        let shares = self.work.as_ref().iter().zip(lanes).map(|(work, lanes)| work.div_ceil(lanes));
        self.slack = due.as_nanos().cast_signed().saturating_sub_unsigned(shares.fold(path, u64::max));
    }

    /// The least time in which a job can end on all lanes, at WCET, in nanoseconds.
    pub(super) fn least(&self, due: Duration) -> u64 {
        due.as_nanos().cast_signed().abs_diff(self.slack)
    }

    /// Nodes by (key, node id); the node id is in the low 8 bits. Merges runs of 1, 2, 4, ... nodes in pairs: the
    /// library's sort panics where an order contradicts itself.
    fn sorted(levels: &Levels<'_, C>, key: impl Fn(usize) -> i64) -> C::Nodes<u128> {
        let (mut sorted, mut len, mut run) = (<C::Nodes<u128>>::EMPTY, 0, 1);
        levels.places().for_each(|i| {
            // With its sign bit turned, a negative key is below the others.
            sorted[len] = u128::from(key(i).cast_unsigned() ^ 1 << 63) << 8 | i as u128;
            len += 1;
        });
        while run < len {
            let (runs, mut middle) = (sorted, run);
            while middle < len {
                let (mut at, mut left, mut right) = (middle - run, middle - run, middle);
                let end = len.min(middle + run);
                // Most runs follow each other already.
                let in_order = runs[middle - 1] < runs[middle];
                while !in_order && left < middle {
                    let is_right = right < end && runs[right] < runs[left];
                    sorted[at] = select_unpredictable(is_right, runs[right.min(end - 1)], runs[left]);
                    (left, right) = (left + usize::from(!is_right), right + usize::from(is_right));
                    at += 1;
                }
                // What remains of the right run is in its place.
                middle += 2 * run;
            }
            run *= 2;
        }
        sorted
    }

    /// The graph again, in node ids.
    pub(super) fn dag(&self, nodes: &C::Nodes<Node>) -> Dag<C> {
        Dag::restore(nodes, &self.order, usize::from(self.len), &self.successors)
    }

    /// Node ids that this version uses.
    pub(super) fn nodes(&self) -> NodeSet<C> {
        let mut set = NodeSet::EMPTY;
        (0..usize::from(self.len)).for_each(|rank| set.insert(usize::from(self.order[rank])));
        set
    }

    /// The encoder whose decoder `rank` is, by the edge between them.
    pub(super) fn encoder_of(&self, rank: usize) -> Option<usize> {
        self.encoders.iter().find(|e| self.successors[*e].contains(rank))
    }

    pub(super) fn decoders_of(&self, encoder: usize) -> NodeSet<C> {
        self.successors[encoder].and(&self.decoders)
    }
}
