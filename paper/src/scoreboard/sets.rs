//! Random sets of DAG tasks: layered or Erdos-Renyi graphs, utilisations by UUniFast.

use crate::rng::Rng;
use red_certificate as certificate;
use red_core::{Capacity, Caps, Dag, Duration, Node, NodeId, Timing, Wcet};

/// Capacities of every experiment of the scoreboard. As many preempted nodes may wait as there are lanes of capacity, so
/// these are more than the eight that run.
pub(crate) type Board = Caps<10, 128, 64, 32, 1, 2>;

/// How graphs are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// Layers of one to five nodes; each node has one or two predecessors in the layer before it.
    Layered,
    /// Any earlier node is a predecessor with the same probability.
    ErdosRenyi,
}

impl Family {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Layered, Self::ErdosRenyi];
}

/// A graph: costs in nanoseconds, and successors; edges lead from lower to higher numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// Cost of each node.
    pub(crate) costs: Vec<u64>,
    /// Successors of each node.
    pub(crate) successors: Vec<Vec<usize>>,
}

/// A task.
#[derive(Clone, Debug)]
pub(crate) struct Task {
    /// Its graph.
    pub(crate) graph: Graph,
    /// Period, in nanoseconds.
    pub(crate) period_ns: u64,
    /// Relative deadline, in nanoseconds.
    pub(crate) deadline_ns: u64,
}

/// Nodes of a graph.
const NODES: (u64, u64) = (8, 30);
/// Cost of a usual node, in nanoseconds; one of ten costs four times as much.
const COST_NS: (u64, u64) = (1_000, 10_000);
const HEAVY: f64 = 0.1;
const HEAVIER: u64 = 4;
/// Probability of an edge of Erdos and Renyi.
const EDGE: f64 = 0.2;
/// Nodes of a layer, and predecessors of a node in the layer before.
const LAYER: (u64, u64) = (1, 5);
const PREDECESSORS: (u64, u64) = (1, 2);

impl Graph {
    /// Draws one.
    pub(crate) fn draw(rng: &mut Rng, family: Family) -> Self {
        let count = rng.within(NODES.0, NODES.1) as usize;
        let cost = |rng: &mut Rng| {
            let usual = rng.within(COST_NS.0, COST_NS.1);
            if rng.chance(HEAVY) { HEAVIER * usual } else { usual }
        };
        let costs = (0..count).map(|_| cost(rng)).collect();
        let mut graph = Self { costs, successors: vec![Vec::new(); count] };
        match family {
            Family::ErdosRenyi => {
                for to in 1..count {
                    for from in 0..to {
                        if rng.chance(EDGE) {
                            graph.link(from, to);
                        }
                    }
                }
            }
            Family::Layered => {
                let (mut before, mut at) = (0..0, 0);
                while at < count {
                    let end = count.min(at + rng.within(LAYER.0, LAYER.1) as usize);
                    for to in at..end {
                        for _ in 0..rng.within(PREDECESSORS.0, PREDECESSORS.1).min(before.len() as u64) {
                            graph.link(before.start + rng.within(0, before.len() as u64 - 1) as usize, to);
                        }
                    }
                    (before, at) = (at..end, end);
                }
            }
        }
        graph
    }

    /// An edge; one that is there stays one.
    pub(crate) fn link(&mut self, from: usize, to: usize) {
        if !self.successors[from].contains(&to) {
            self.successors[from].push(to);
        }
    }

    /// Sum of all costs.
    #[must_use]
    pub(crate) fn work(&self) -> u64 {
        self.costs.iter().sum()
    }

    /// Longest path after each node, its own cost excluded.
    #[must_use]
    pub(crate) fn tails(&self) -> Vec<u64> {
        let mut tails = vec![0; self.costs.len()];
        for node in (0..self.costs.len()).rev() {
            let after = self.successors[node].iter().map(|s| self.costs[*s] + tails[*s]);
            tails[node] = after.max().unwrap_or(0);
        }
        tails
    }

    /// Longest path before each node, its own cost excluded.
    #[must_use]
    pub(crate) fn heads(&self) -> Vec<u64> {
        let mut heads = vec![0; self.costs.len()];
        for node in 0..self.costs.len() {
            for successor in &self.successors[node] {
                heads[*successor] = heads[*successor].max(heads[node] + self.costs[node]);
            }
        }
        heads
    }

    /// Cost of the longest path.
    #[must_use]
    pub(crate) fn longest(&self) -> u64 {
        self.tails().iter().zip(&self.costs).map(|(tail, cost)| tail + cost).max().unwrap_or(0)
    }

    /// As proofs take it, each node in its cluster.
    #[must_use]
    pub(crate) fn to_prove(&self, cluster: impl Fn(usize) -> usize) -> certificate::Graph {
        let node = |(n, cost): (usize, &u64)| certificate::Node {
            name: format!("n{n}"),
            cost_ns: *cost,
            cluster: cluster(n),
        };
        let successors = self.successors.iter().enumerate();
        certificate::Graph {
            nodes: self.costs.iter().enumerate().map(node).collect(),
            edges: successors.flat_map(|(from, to)| to.iter().map(move |to| (from, *to))).collect(),
        }
    }

    /// As a scheduler takes it, best cases in percent of the costs; `None` where it is larger than its capacity.
    #[must_use]
    pub(crate) fn dag<C: Capacity>(&self, best_percent: u64) -> Option<Dag<C>> {
        let mut dag = Dag::new();
        for cost in &self.costs {
            let best = Duration::from_nanos(cost * best_percent / 100);
            dag.add_node(Node::new(Wcet::from_nanos(*cost)).best_case(best)).ok()?;
        }
        for (from, successors) in self.successors.iter().enumerate() {
            for to in successors {
                dag.add_edge(id(from)?, id(*to)?).ok()?;
            }
        }
        Some(dag)
    }
}

fn id(node: usize) -> Option<NodeId> {
    u8::try_from(node).ok().map(NodeId::new)
}

impl Task {
    /// As the scheduler takes it.
    #[must_use]
    pub(crate) fn timing(&self) -> Timing {
        Timing::new(Duration::from_nanos(self.deadline_ns)).every(Duration::from_nanos(self.period_ns))
    }
}

/// Draws a set of `lanes` + 2 tasks, at most ten, that together use `utilisation` of the lanes. D = L + delta (T - L).
pub(crate) fn draw(rng: &mut Rng, family: Family, lanes: u64, utilisation: f64, delta: f64) -> Vec<Task> {
    let count = (lanes + 2).min(10) as usize;
    loop {
        let graphs: Vec<Graph> = (0..count).map(|_| Graph::draw(rng, family)).collect();
        let shares = uunifast(rng, count, utilisation * lanes as f64);
        let task = |(graph, share): (Graph, f64)| {
            let period_ns = (graph.work() as f64 / share) as u64;
            let longest = graph.longest();
            let slack = period_ns.checked_sub(longest)?;
            Some(Task { period_ns, deadline_ns: longest + (delta * slack as f64) as u64, graph })
        };
        // A period below the longest path has no schedule: drawn again, as UUniFast-Discard does.
        let tasks: Option<Vec<Task>> = graphs.into_iter().zip(shares).map(task).collect();
        if let Some(tasks) = tasks {
            return tasks;
        }
    }
}

/// Bini and Buttazzo: Measuring the performance of schedulability tests, 2005.
pub(super) fn uunifast(rng: &mut Rng, count: usize, sum: f64) -> Vec<f64> {
    let mut left = sum;
    let mut shares = Vec::with_capacity(count);
    for nth in 1..count {
        let next = left * rng.unit().powf(1.0 / (count - nth) as f64);
        shares.push(left - next);
        left = next;
    }
    shares.push(left);
    shares
}
