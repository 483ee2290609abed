//! The graph that a job runs, from the nodes as written: stages refined or kept whole, edits applied.

use red_workload::model::{Event, Node, Part, Stage, Work};

/// What a sub-node does in a MIMONet stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Nothing shared: a plain node, or a stage kept whole.
    Ordinary,
    /// The shared encoder of a stage.
    Encoder,
    /// One decoder of a stage.
    Decoder,
}

/// A node after refinement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SubNode {
    /// Row name: `node`, or `stage.part`.
    pub name: String,
    /// Index of the pool.
    pub pool: usize,
    /// Nanoseconds that it executes for.
    pub wcet_ns: u64,
    /// Cost c' in every formula: the WCET plus, where atomic, the contention delay.
    pub cost_ns: u64,
    /// Footprint in bytes.
    pub memory_bytes: u64,
    /// Part that it plays in its stage.
    pub role: Role,
    /// Weights and frame name of its stage, for encoders and decoders.
    pub stage: Option<(String, String)>,
    /// Indices of its predecessors, each once, ascending.
    pub preds: Vec<usize>,
    /// Indices of its successors, each once, ascending.
    pub succs: Vec<usize>,
}

/// One version of a task's graph.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Graph {
    /// Nodes in file order, stages expanded in place, then what events added, in the order of the events.
    pub nodes: Vec<SubNode>,
    /// A topological order of the indices, ties by index.
    pub order: Vec<usize>,
}

impl Graph {
    /// Builds the graph of `nodes`: stages become encoder and decoders if `refined`, else one node each.
    /// References to nodes that do not exist are left out.
    ///
    /// # Panics
    ///
    /// If the edges form a cycle, which no valid workload has.
    pub fn of(nodes: &[Node], refined: bool) -> Self {
        let subs = nodes.iter().flat_map(|node| sub_nodes(node, refined)).collect();
        let mut graph = Self { nodes: subs, order: Vec::new() };
        for node in nodes {
            let (entries, exits) =
                (graph.find(&node.name, refined, End::Entry), graph.find(&node.name, refined, End::Exit));
            for name in &node.after {
                let from = graph.find(name, refined, End::Exit);
                graph.connect(&from, &entries);
            }
            for name in &node.before {
                let to = graph.find(name, refined, End::Entry);
                graph.connect(&exits, &to);
            }
            if refined && matches!(node.work, Work::Stage(_)) {
                graph.connect(&entries, &exits);
            }
        }
        while let Some(next) = graph.next_in_order() {
            graph.order.push(next);
        }
        assert_eq!(graph.order.len(), graph.nodes.len(), "a workload's graphs have no cycle");
        graph
    }

    /// Indices that a reference stands for: a stage is entered at its encoder and left at its decoders.
    fn find(&self, reference: &str, refined: bool, end: End) -> Vec<usize> {
        let (node, part) =
            reference.split_once('.').map_or((reference, None), |(node, part)| (node, Some(part)));
        let matches = |sub: &SubNode| match (part, refined) {
            (Some(_), true) => sub.name == reference,
            (_, false) => sub.name == node,
            (None, true) => {
                let inside = sub.name.split_once('.').is_some_and(|(stage, _)| stage == node);
                sub.name == node
                    || inside && sub.role == if end == End::Entry { Role::Encoder } else { Role::Decoder }
            }
        };
        (0..self.nodes.len()).filter(|&index| matches(&self.nodes[index])).collect()
    }

    fn connect(&mut self, from: &[usize], to: &[usize]) {
        for &u in from {
            for &v in to {
                if !self.nodes[v].preds.contains(&u) {
                    self.nodes[v].preds.push(u);
                    self.nodes[v].preds.sort_unstable();
                    self.nodes[u].succs.push(v);
                    self.nodes[u].succs.sort_unstable();
                }
            }
        }
    }

    fn next_in_order(&self) -> Option<usize> {
        let placed = |v: &usize| self.order.contains(v);
        (0..self.nodes.len()).find(|v| !placed(v) && self.nodes[*v].preds.iter().all(placed))
    }

    /// Height of every node among those that `remain`: 0 without a remaining predecessor, else one more than
    /// the highest. Nodes that do not remain have height 0, which means nothing.
    pub fn heights(&self, remain: impl Fn(usize) -> bool) -> Vec<usize> {
        let mut heights = vec![0; self.nodes.len()];
        for &v in &self.order {
            let preds = self.nodes[v].preds.iter().filter(|&&u| remain(u));
            heights[v] = preds.map(|&u| heights[u] + 1).max().unwrap_or(0);
        }
        heights
    }

    /// Cost c' of every node.
    pub fn costs(&self) -> Vec<u64> {
        self.nodes.iter().map(|node| node.cost_ns).collect()
    }

    /// Longest path that ends with each node, the node included.
    pub fn heads(&self, costs: &[u64]) -> Vec<u64> {
        let mut heads = vec![0; self.nodes.len()];
        for &v in &self.order {
            heads[v] = costs[v] + self.nodes[v].preds.iter().map(|&u| heads[u]).max().unwrap_or(0);
        }
        heads
    }

    /// Longest path after each node, the node excluded.
    pub fn tails(&self, costs: &[u64]) -> Vec<u64> {
        let mut tails = vec![0; self.nodes.len()];
        for &v in self.order.iter().rev() {
            tails[v] = self.nodes[v].succs.iter().map(|&s| costs[s] + tails[s]).max().unwrap_or(0);
        }
        tails
    }

    /// Cost of the longest path.
    pub fn longest_path(&self, costs: &[u64]) -> u64 {
        self.heads(costs).into_iter().max().unwrap_or(0)
    }

    /// Work that a pool gets, at WCET.
    pub fn work(&self, pool: usize) -> u64 {
        self.nodes.iter().filter(|node| node.pool == pool).map(|node| node.cost_ns).sum()
    }
}

/// The nodes after `events`, which all hold from one instant on: removals first, then additions at the end.
/// A removed node takes its edges with it.
pub fn edited(nodes: &[Node], events: &[&Event]) -> Vec<Node> {
    let mut nodes = nodes.to_vec();
    for event in events {
        let gone = |reference: &String| {
            let node = reference.split_once('.').map_or(reference.as_str(), |(node, _)| node);
            event.remove.iter().any(|removed| removed == node)
        };
        nodes.retain(|node| !gone(&node.name));
        for node in &mut nodes {
            node.after.retain(|reference| !gone(reference));
            node.before.retain(|reference| !gone(reference));
        }
        nodes.extend(event.add.iter().cloned());
    }
    nodes
}

/// Which end of a stage a reference to the whole stage means.
#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Entry,
    Exit,
}

fn sub_nodes(node: &Node, refined: bool) -> Vec<SubNode> {
    match &node.work {
        Work::Plain(part) => vec![sub_node(node.name.clone(), part, Role::Ordinary, None)],
        Work::Stage(stage) if refined => {
            let shared = Some((stage.weights.clone(), stage.frame.clone()));
            let encoder =
                sub_node(format!("{}.encoder", node.name), &stage.encoder, Role::Encoder, shared.clone());
            let decoders = stage.decoders.iter().map(|(name, part)| {
                sub_node(format!("{}.{name}", node.name), part, Role::Decoder, shared.clone())
            });
            std::iter::once(encoder).chain(decoders).collect()
        }
        Work::Stage(stage) => vec![whole_stage(node.name.clone(), stage)],
    }
}

fn sub_node(name: String, part: &Part, role: Role, stage: Option<(String, String)>) -> SubNode {
    SubNode {
        name,
        pool: part.pool,
        wcet_ns: part.wcet_ns,
        cost_ns: part.wcet_ns + part.contention_ns,
        memory_bytes: part.memory_bytes,
        role,
        stage,
        preds: Vec::new(),
        succs: Vec::new(),
    }
}

/// A stage kept whole runs in its encoder's pool, part after part, and holds the encoder's output meanwhile.
fn whole_stage(name: String, stage: &Stage) -> SubNode {
    let mut whole = sub_node(name, &stage.encoder, Role::Ordinary, None);
    for (_, part) in &stage.decoders {
        whole.wcet_ns += part.wcet_ns;
        whole.cost_ns += part.wcet_ns + part.contention_ns;
    }
    let here = stage.decoders.iter().filter(|(_, part)| part.pool == stage.encoder.pool);
    whole.memory_bytes += here.map(|(_, part)| part.memory_bytes).max().unwrap_or(0);
    whole
}

#[cfg(test)]
mod tests;
