//! What the check computes of one graph anew, along its edges.

use crate::{Graph, Set};

/// A node. No cost counts as 1 ns, since a node of no cost has to wait for a lane, too; its key is exact.
pub(crate) struct Point {
    pub(crate) cost: i128,
    pub(crate) key: i128,
    pub(crate) cluster: usize,
    before: Vec<usize>,
}

/// A graph as the inequalities see it. Sums of 64-bit numbers are in 128 bits.
pub(crate) struct Shape {
    pub(crate) nodes: Vec<Point>,
    pub(crate) work: i128,
    pub(crate) longest: i128,
    pub(crate) shortest: i128,
    pub(crate) hops: i128,
    pub(crate) last_key: i128,
    /// Nodes, each after all that lead to it.
    order: Vec<usize>,
    /// Whether nothing follows.
    is_sink: Vec<bool>,
}

impl Shape {
    /// Of a graph whose jobs have so long; or what is wrong with it.
    pub(crate) fn of(graph: &Graph, deadline_ns: u64, set: &Set) -> Result<Self, &'static str> {
        let count = graph.nodes.len();
        if count == 0 {
            return Err("a graph without nodes");
        }
        if graph.nodes.iter().any(|node| node.cluster >= set.clusters.len()) {
            return Err("a node on a cluster that is not there");
        }
        let (mut before, mut after) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for &(from, to) in &graph.edges {
            if from >= count || to >= count {
                return Err("an edge of a node that is not there");
            }
            before[to].push(from);
            after[from].push(to);
        }
        let mut open: Vec<usize> = before.iter().map(Vec::len).collect();
        let mut order: Vec<usize> = (0..count).filter(|node| open[*node] == 0).collect();
        let mut done = 0;
        // Each node enters the order once, when its last predecessor has.
        while let Some(&node) = order.get(done) {
            done += 1;
            for &next in &after[node] {
                open[next] -= 1;
                if open[next] == 0 {
                    order.push(next);
                }
            }
        }
        if order.len() < count {
            return Err("a graph with a cycle");
        }
        // Keys are of the costs as they are.
        let mut tails = vec![0i128; count];
        for &node in order.iter().rev() {
            let tail = |next: &usize| tails[*next] + i128::from(graph.nodes[*next].cost_ns);
            tails[node] = after[node].iter().map(tail).max().unwrap_or(0);
        }
        let nodes = graph.nodes.iter().zip(before).zip(&tails).map(|((node, before), tail)| Point {
            cost: i128::from(node.cost_ns.max(1)),
            key: i128::from(deadline_ns) - tail - i128::from(node.cost_ns),
            cluster: node.cluster,
            before,
        });
        let is_sink = after.iter().map(Vec::is_empty).collect();
        let nodes = nodes.collect();
        let mut shape =
            Self { nodes, work: 0, longest: 0, shortest: 0, hops: 0, last_key: 0, order, is_sink };
        shape.work = shape.nodes.iter().map(|node| node.cost).sum();
        shape.longest = shape.most(|node| shape.nodes[node].cost);
        shape.shortest = shape.least(|node| shape.nodes[node].cost);
        shape.hops = shape.most(|_| 1);
        shape.last_key = shape.nodes.iter().map(|node| node.key).max().unwrap_or(0);
        Ok(shape)
    }

    /// Whether all nodes are on one cluster, and which.
    pub(crate) fn only_cluster(&self) -> Option<usize> {
        let cluster = self.nodes.first()?.cluster;
        self.nodes.iter().all(|node| node.cluster == cluster).then_some(cluster)
    }

    /// The heaviest path.
    pub(crate) fn most(&self, weight: impl Fn(usize) -> i128) -> i128 {
        self.paths(weight, i128::max).into_iter().max().unwrap_or(0)
    }

    /// The lightest path from a source to a sink.
    pub(crate) fn least(&self, weight: impl Fn(usize) -> i128) -> i128 {
        let ends = self.paths(weight, i128::min).into_iter().zip(&self.is_sink);
        ends.filter(|(_, is_sink)| **is_sink).map(|(path, _)| path).min().unwrap_or(0)
    }

    /// Whether a job comes into this node's cluster with it: at its release, or from a node on another.
    pub(crate) fn enters(&self, node: usize) -> bool {
        let Point { cluster, before, .. } = &self.nodes[node];
        before.is_empty() || before.iter().any(|from| self.nodes[*from].cluster != *cluster)
    }

    /// Lengths of the chains of a cluster, longest first; or a node that is not ordered with the others of its chain.
    pub(crate) fn chains(&self, chain_of: &[usize], cluster: usize) -> Result<Vec<i128>, usize> {
        let words = self.nodes.len().div_ceil(64);
        let mut above = vec![vec![0u64; words]; self.nodes.len()];
        // Chain, its last node so far, and its length so far.
        let mut chains: Vec<(usize, usize, i128)> = Vec::new();
        for &node in &self.order {
            let mut row = vec![0u64; words];
            for &from in &self.nodes[node].before {
                row[from / 64] |= 1 << (from % 64);
                row.iter_mut().zip(&above[from]).for_each(|(word, more)| *word |= more);
            }
            if self.nodes[node].cluster == cluster {
                let cost = self.nodes[node].cost;
                match chains.iter_mut().find(|(chain, ..)| *chain == chain_of[node]) {
                    None => chains.push((chain_of[node], node, cost)),
                    // Along an order of the edges, being connected with the last one is being connected with all.
                    Some((_, last, length)) if row[*last / 64] & 1 << (*last % 64) != 0 => {
                        (*last, *length) = (node, *length + cost);
                    }
                    Some(_) => return Err(node),
                }
            }
            above[node] = row;
        }
        let mut lengths: Vec<i128> = chains.into_iter().map(|(.., length)| length).collect();
        lengths.sort_unstable_by(|a, b| b.cmp(a));
        Ok(lengths)
    }

    /// Weight of the path to each node that `better` prefers, with the node's own.
    fn paths(&self, weight: impl Fn(usize) -> i128, better: impl Fn(i128, i128) -> i128) -> Vec<i128> {
        let mut paths = vec![0; self.nodes.len()];
        for &node in &self.order {
            let before = self.nodes[node].before.iter().map(|from| paths[*from]);
            paths[node] = before.reduce(&better).unwrap_or(0) + weight(node);
        }
        paths
    }
}
