//! What a test needs to know of a graph: of the whole, and of its part in each cluster.
//!
//! *Rule.* Keys are latest starts: o = D - tail - c after the release. Chains are sets of nodes, each totally ordered by
//! reachability, taken greedily: the longest path, its nodes then cost nothing, and again. A chain never runs twice at once,
//! so the work of one job in any time set of measure x is at most f(x) = min(m x, sum of min(l_c, x)).

use red_certificate::{Cluster, Graph};

/// Runs of nodes by key that interference is told apart by, at most.
const GROUPS: usize = 4;

/// A graph as the tests see it. Times are in nanoseconds.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// W: sum of all costs.
    pub(crate) work: i128,
    /// L and Lmin: longest and shortest cost of a path from source to sink, over all clusters.
    pub(crate) longest: i128,
    pub(crate) shortest: i128,
    /// H: nodes of the path with the most of them.
    pub(crate) hops: i128,
    /// kap: the latest key.
    pub(crate) last_key: i128,
    /// Largest cost of a node.
    pub(crate) largest: i128,
    /// Chain of each node within its cluster.
    pub(crate) chain_of: Vec<usize>,
    /// What it has in each cluster; `None` where it has no node.
    pub(crate) parts: Vec<Option<Part>>,
}

/// What a graph has in one cluster.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) lanes: i128,
    pub(crate) work: i128,
    /// Least cost of this cluster's nodes over paths from source to sink.
    pub(crate) least: i128,
    /// Lengths of the chains, longest first.
    pub(crate) chains: Vec<i128>,
    /// Sums of the chains from each on to the last.
    pub(crate) suffixes: Vec<i128>,
    /// Nodes: key and cost, the most costly first.
    pub(crate) nodes: Vec<(i128, i128)>,
    /// Runs of nodes by key: first key, work of this and all earlier runs.
    pub(crate) groups: Vec<(i128, i128)>,
    /// Its nodes in topological order, each with whether a wait for it may find all lanes taken, and its predecessors.
    pub(crate) places: Vec<Place>,
}

/// A node on the way through a graph.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    /// Whether it has no predecessor, or one in another cluster: no lane of its own was freed for it then.
    pub(crate) enters: bool,
    /// Whether it is in this cluster.
    pub(crate) is_here: bool,
    /// Positions of its predecessors.
    pub(crate) before: Vec<usize>,
}

impl Part {
    /// Work of one job in a time set of measure `x`, at most.
    pub(crate) fn f(&self, x: i128) -> i128 {
        if x <= 0 { 0 } else { (self.lanes * x).min(self.capped(x)) }
    }

    /// Sum of min(l_c, x) over the chains.
    pub(crate) fn capped(&self, x: i128) -> i128 {
        let longer = self.chains.partition_point(|length| *length > x);
        longer as i128 * x.max(0) + self.suffixes[longer]
    }

    /// Sum of max(0, x - l_c) over the chains.
    pub(crate) fn beyond(&self, x: i128) -> i128 {
        self.chains.len() as i128 * x - self.capped(x)
    }
}

/// Predecessors, successors and an order of a graph.
struct Order {
    before: Vec<Vec<usize>>,
    after: Vec<Vec<usize>>,
    order: Vec<usize>,
}

impl Order {
    fn of(graph: &Graph) -> Self {
        let count = graph.nodes.len();
        let (mut before, mut after) = (vec![Vec::new(); count], vec![Vec::new(); count]);
        for (from, to) in &graph.edges {
            before[*to].push(*from);
            after[*from].push(*to);
        }
        let mut left: Vec<usize> = before.iter().map(Vec::len).collect();
        let mut order: Vec<usize> = (0..count).filter(|node| left[*node] == 0).collect();
        let mut next = 0;
        while let Some(node) = order.get(next).copied() {
            next += 1;
            for successor in &after[node] {
                left[*successor] -= 1;
                if left[*successor] == 0 {
                    order.push(*successor);
                }
            }
        }
        Self { before, after, order }
    }

    /// Sums of `cost` along paths up to each node, its own included; `pick` chooses among the predecessors.
    fn heads(&self, cost: &[i128], pick: fn(i128, i128) -> i128) -> Vec<i128> {
        let mut heads = vec![0; cost.len()];
        for node in &self.order {
            let before = self.before[*node].iter().map(|from| heads[*from]).reduce(pick);
            heads[*node] = before.unwrap_or(0) + cost[*node];
        }
        heads
    }

    fn over_sinks(&self, heads: &[i128], pick: fn(i128, i128) -> i128) -> i128 {
        let sinks = self.order.iter().filter(|node| self.after[**node].is_empty());
        sinks.map(|node| heads[*node]).reduce(pick).unwrap_or(0)
    }

    /// Costs of the longest paths after each node, its own excluded.
    fn tails(&self, cost: &[i128]) -> Vec<i128> {
        let mut tails = vec![0; cost.len()];
        for node in self.order.iter().rev() {
            tails[*node] = self.after[*node].iter().map(|to| tails[*to] + cost[*to]).max().unwrap_or(0);
        }
        tails
    }

    /// Takes longest paths away until nothing is left. Lengths of the chains, and the chain of each node that costs.
    fn chains(&self, mut cost: Vec<i128>, chain_of: &mut [usize]) -> Vec<i128> {
        let mut chains = Vec::new();
        loop {
            let heads = self.heads(&cost, i128::max);
            let end = (0..cost.len()).max_by_key(|node| (heads[*node], std::cmp::Reverse(*node)));
            let Some(mut node) = end.filter(|node| heads[*node] > 0) else { return chains };
            let mut length = 0;
            loop {
                if cost[node] > 0 {
                    chain_of[node] = chains.len();
                    length += cost[node];
                }
                let rest = heads[node] - cost[node];
                cost[node] = 0;
                match self.before[node].iter().find(|from| rest > 0 && heads[**from] == rest) {
                    Some(from) => node = *from,
                    None => break,
                }
            }
            chains.push(length);
        }
    }
}

impl Shape {
    pub(crate) fn of(clusters: &[Cluster], deadline: i128, graph: &Graph) -> Self {
        let order = Order::of(graph);
        // What the dispatcher orders by.
        let exact: Vec<i128> = graph.nodes.iter().map(|node| node.cost_ns.into()).collect();
        let tails = order.tails(&exact);
        let keys: Vec<i128> = (0..exact.len()).map(|node| deadline - tails[node] - exact[node]).collect();
        // A node of no cost has to wait for a lane, too. An unfinished job has executed less than a path only where each of
        // its nodes costs something; one nanosecond is above what such a node takes.
        let cost: Vec<i128> = exact.into_iter().map(|cost| cost.max(1)).collect();
        let heads = order.heads(&cost, i128::max);
        let hops = order.heads(&vec![1; cost.len()], i128::max);
        let mut chain_of = vec![0; cost.len()];
        let parts = (0..clusters.len())
            .map(|cluster| {
                let is_here = |node: usize| graph.nodes[node].cluster == cluster;
                if !(0..cost.len()).any(is_here) {
                    return None;
                }
                let lanes = clusters[cluster].lanes.into();
                Some(Part::of(&order, &cost, &keys, lanes, is_here, &mut chain_of))
            })
            .collect();
        Self {
            work: cost.iter().sum(),
            longest: order.over_sinks(&heads, i128::max),
            shortest: order.over_sinks(&order.heads(&cost, i128::min), i128::min),
            hops: hops.into_iter().max().unwrap_or(0),
            last_key: keys.iter().copied().max().unwrap_or(0),
            largest: cost.iter().copied().max().unwrap_or(0),
            chain_of,
            parts,
        }
    }
}

impl Part {
    fn of(
        order: &Order,
        cost: &[i128],
        keys: &[i128],
        lanes: i128,
        is_here: impl Fn(usize) -> bool,
        chain_of: &mut [usize],
    ) -> Self {
        let here: Vec<i128> = (0..cost.len()).map(|n| if is_here(n) { cost[n] } else { 0 }).collect();
        let mut chains = order.chains(here.clone(), chain_of);
        let work = here.iter().sum();
        // A part without cost is one chain of no length.
        if chains.is_empty() {
            chains.push(0);
        }
        let suffixes = suffixes(&chains);
        let mut by_key: Vec<(i128, i128)> =
            (0..cost.len()).filter(|n| is_here(*n)).map(|n| (keys[n], cost[n])).collect();
        by_key.sort_unstable();
        let groups = groups(&by_key);
        let mut nodes = by_key;
        nodes.sort_unstable_by_key(|(_, cost)| std::cmp::Reverse(*cost));
        let mut at = vec![0; cost.len()];
        order.order.iter().enumerate().for_each(|(position, node)| at[*node] = position);
        let place = |node: &usize| Place {
            enters: order.before[*node].is_empty() || order.before[*node].iter().any(|from| !is_here(*from)),
            is_here: is_here(*node),
            before: order.before[*node].iter().map(|from| at[*from]).collect(),
        };
        let least = order.over_sinks(&order.heads(&here, i128::min), i128::min);
        let places = order.order.iter().map(place).collect();
        Self { lanes, work, least, chains, suffixes, nodes, groups, places }
    }
}

/// Sums of each chain and all after it.
pub(crate) fn suffixes(chains: &[i128]) -> Vec<i128> {
    let mut suffixes = vec![0; chains.len() + 1];
    for (at, length) in chains.iter().enumerate().rev() {
        suffixes[at] = suffixes[at + 1] + length;
    }
    suffixes
}

/// Nodes by key, cut into at most [`GROUPS`] runs of about the same number; equal keys stay together.
fn groups(by_key: &[(i128, i128)]) -> Vec<(i128, i128)> {
    let size = by_key.len().div_ceil(GROUPS).max(1);
    let mut groups: Vec<(i128, i128)> = Vec::new();
    let (mut sum, mut in_group, mut last) = (0, 0, None);
    for (key, cost) in by_key {
        sum += cost;
        if groups.is_empty() || in_group >= size && last != Some(*key) {
            groups.push((*key, 0));
            in_group = 0;
        }
        in_group += 1;
        last = Some(*key);
        if let Some(group) = groups.last_mut() {
            group.1 = sum;
        }
    }
    groups
}

#[cfg(test)]
mod tests;
