//! The four reference graphs and the body that their nodes run.

use std::collections::HashSet;
use std::hint::black_box;
use std::time::Instant;

/// A task graph whose edges always lead from a lower node to a higher one.
#[derive(Clone)]
pub(crate) struct Graph {
    pub(crate) name: &'static str,
    /// Successors of each node.
    pub(crate) successors: Vec<Vec<u32>>,
    /// Number of predecessors of each node.
    pub(crate) indegree: Vec<u32>,
    /// Longest path, in edges, from a source to each node.
    pub(crate) height: Vec<u32>,
}

impl Graph {
    fn new(name: &'static str, nodes: usize, edges: &[(usize, usize)]) -> Self {
        let mut successors = vec![Vec::new(); nodes];
        let mut indegree = vec![0; nodes];
        for &(from, to) in edges {
            successors[from].push(to as u32);
            indegree[to] += 1;
        }
        let mut height = vec![0u32; nodes];
        for from in 0..nodes {
            for &to in &successors[from] {
                height[to as usize] = height[to as usize].max(height[from] + 1);
            }
        }
        Self { name, successors, indegree, height }
    }

    /// chain256, forkjoin64, layered256 and mimonet6, in this order.
    pub(crate) fn all() -> Vec<Self> {
        vec![
            Self::new("chain256", 256, &chain(256)),
            Self::new("forkjoin64", 66, &fork_join(64)),
            Self::new("layered256", 256, &layered()),
            Self::new("mimonet6", 6, &fork_join(4)),
        ]
    }

    /// So many nodes, one after the other.
    pub(crate) fn chain(nodes: usize) -> Self {
        Self::new("chain", nodes, &chain(nodes))
    }

    /// Layers of `width` nodes, each with an edge from its own place and from the one beside it in the layer
    /// before: the edges per node do not grow with the graph.
    pub(crate) fn lattice(nodes: usize, width: usize) -> Self {
        let into = |to: usize| {
            let layer = (to / width - 1) * width;
            [(layer + to % width, to), (layer + (to + 1) % width, to)]
        };
        Self::new("lattice", nodes, &(width..nodes).flat_map(into).collect::<Vec<_>>())
    }

    /// The reference graph of that name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|graph| graph.name == name)
    }

    pub(crate) fn nodes(&self) -> usize {
        self.indegree.len()
    }

    /// Nodes without a predecessor.
    pub(crate) fn roots(&self) -> Vec<u32> {
        (0..self.nodes() as u32).filter(|&node| self.indegree[node as usize] == 0).collect()
    }

    /// The deadline of a node in ticks: nodes of one height share it, as under an assignment by levels.
    pub(crate) fn deadline(&self, node: usize) -> u64 {
        1_000 + 10 * u64::from(self.height[node])
    }

    /// Length of the best schedule on `lanes` lanes, in bodies, when heights run one after the other. Exact
    /// for the fork-joins, which are what two lanes are measured on.
    pub(crate) fn makespan(&self, lanes: usize) -> usize {
        let top = self.height.iter().max().copied().unwrap_or(0);
        (0..=top)
            .map(|height| self.height.iter().filter(|&&of_node| of_node == height).count().div_ceil(lanes))
            .sum()
    }
}

fn chain(nodes: usize) -> Vec<(usize, usize)> {
    (1..nodes).map(|node| (node - 1, node)).collect()
}

/// One source, `width` nodes, one sink.
fn fork_join(width: usize) -> Vec<(usize, usize)> {
    (1..=width).flat_map(|node| [(0, node), (node, width + 1)]).collect()
}

/// 16 layers of 16 nodes: four random predecessors each from the layer before, and 64 edges that skip a layer.
fn layered() -> Vec<(usize, usize)> {
    let mut state = 42;
    let mut draw = |bound: u64| (splitmix64(&mut state) % bound) as usize;
    let mut seen = HashSet::new();
    let mut edges = Vec::new();
    for to in 16..256 {
        let mut found = 0;
        while found < 4 {
            let from = (to / 16 - 1) * 16 + draw(16);
            if seen.insert((from, to)) {
                edges.push((from, to));
                found += 1;
            }
        }
    }
    let mut found = 0;
    while found < 64 {
        let layer = 2 + draw(14);
        let to = layer * 16 + draw(16);
        let from = (layer - 2) * 16 + draw(16);
        if seen.insert((from, to)) {
            edges.push((from, to));
            found += 1;
        }
    }
    edges
}

/// The splitmix64 generator: advances `state` and returns the next value.
pub(crate) fn splitmix64(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut mixed = *state;
    mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    mixed ^ (mixed >> 31)
}

/// What a node does: a chain of dependent multiplications, so that its time is set by their latency and is the
/// same in C++ and beside a busy hardware sibling. No clock is read inside.
#[derive(Clone, Copy)]
pub(crate) struct Body {
    /// Links of the chain; 0 = an empty body.
    pub(crate) steps: u64,
}

impl Body {
    pub(crate) const EMPTY: Self = Self { steps: 0 };

    /// A body of about `nanoseconds` on this machine, now. What it really costs in a round is measured again
    /// beside every contestant.
    pub(crate) fn calibrated(nanoseconds: u64) -> Self {
        const PROBE: u64 = 200_000;
        let fastest = (0..20)
            .map(|_| {
                let start = Instant::now();
                Self { steps: PROBE }.run(1);
                start.elapsed().as_nanos() as u64
            })
            .min()
            .unwrap_or(1)
            .max(1);
        Self { steps: (PROBE * nanoseconds / fastest).max(1) }
    }

    /// Runs the body of one node.
    #[inline(always)]
    pub(crate) fn run(self, node: usize) {
        black_box(node);
        if self.steps != 0 {
            multiply(self.steps, node);
        }
    }

    /// The body behind a pointer that the optimiser cannot see through, for executors that would otherwise
    /// have it inlined into their loop, which no executor of foreign bodies can have.
    pub(crate) fn behind_pointer(self) -> fn(Self, usize) {
        black_box(Self::run as fn(Self, usize))
    }
}

#[inline(never)]
fn multiply(steps: u64, node: usize) {
    let mut value = node as u64 | 1;
    for _ in 0..steps {
        value = (value ^ (value >> 29)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }
    black_box(value);
}

#[cfg(test)]
mod tests;
