//! A job alone on lanes of its pools (rule 14).

use super::{Policy, keys};
use crate::graph::{Graph, Role};

/// Where a node of a job is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Stage {
    Done,
    /// What it has still to run.
    Running(u64),
    ToCome,
}

impl Stage {
    pub(super) fn left(self, cost: u64) -> u64 {
        match self {
            Self::Done => 0,
            Self::Running(left) => left,
            Self::ToCome => cost,
        }
    }
}

/// A job alone on some lanes of each pool.
pub(super) struct Alone {
    /// Of each node that has started: from when until when.
    runs: Vec<Option<(u64, u64)>>,
    /// Of each lane of each pool.
    held: Vec<Vec<(u64, u64)>>,
    pool: usize,
    /// The most bytes that nodes have at once that do not run yet.
    pub(super) most: u64,
}

impl Alone {
    pub(super) fn new(
        policy: Policy,
        graph: &Graph,
        deadline: u64,
        pool: usize,
        stages: &[Stage],
        lanes: &[usize],
        budget: Option<u64>,
    ) -> Self {
        let keys = keys::at_release(policy, graph, 0, deadline);
        let runs = stages.iter().map(|stage| (*stage == Stage::Done).then_some((0, 0))).collect();
        let held = lanes.iter().map(|&lanes| vec![(0, 0); lanes]).collect();
        let mut alone = Self { runs, held, pool, most: 0 };
        let is_new = |node: usize| stages[node] == Stage::ToCome;
        let bytes = |alone: &Self, at: u64, counts: &dyn Fn(usize) -> bool| -> u64 {
            let here = (0..stages.len()).filter(|&node| {
                let is_kept = graph.nodes[node].role == Role::Encoder && is_new(node);
                graph.nodes[node].pool == pool
                    && stages[node] != Stage::Done
                    && counts(node)
                    && alone.runs[node].is_some_and(|(_, end)| is_kept || end > at)
            });
            here.map(|node| graph.nodes[node].memory_bytes).sum()
        };
        let mut clock = 0;
        loop {
            let start = |node: usize| {
                let before: Option<Vec<u64>> =
                    graph.nodes[node].preds.iter().map(|&pred| Some(alone.runs[pred]?.1)).collect();
                let ready = before?.into_iter().max().unwrap_or(0);
                if !is_new(node) {
                    return Some(ready);
                }
                let (here, memory) = (graph.nodes[node].pool, graph.nodes[node].memory_bytes);
                let ends = || alone.held[here].iter().map(|&(_, until)| until);
                let first = ready.max(ends().min()?).max(clock);
                let fits = |at: &u64| {
                    let used = bytes(&alone, *at, &|_| true) + memory;
                    here != pool || memory == 0 || budget.is_none_or(|budget| used <= budget)
                };
                let later = ends().filter(|end| *end > first).filter(fits).min();
                let last = ends().max()?.max(first);
                Some(if fits(&first) { first } else { later.unwrap_or(last) })
            };
            let open = (0..stages.len()).filter(|&node| alone.runs[node].is_none());
            let starts = open.filter_map(|node| Some((start(node)?, is_new(node), keys[node], node)));
            let Some((start, _, _, node)) = starts.min() else { return alone };
            let end = start + stages[node].left(graph.nodes[node].cost_ns);
            (alone.runs[node], clock) = (Some((start, end)), start);
            let free = alone.held[graph.nodes[node].pool].iter_mut().filter(|(_, until)| *until <= start);
            if let Some(lane) = free.max_by_key(|(_, until)| *until) {
                let from = if lane.1 == 0 { start } else { lane.0 };
                *lane = (if is_new(node) { from } else { end }, end);
            }
            alone.most = alone.most.max(bytes(&alone, start, &is_new));
        }
    }

    /// From when until when it holds each lane of the pool.
    pub(super) fn held(&self) -> Vec<(u64, u64)> {
        self.held[self.pool].iter().copied().filter(|&(from, until)| from < until).collect()
    }

    pub(super) fn end(&self) -> u64 {
        self.runs.iter().flatten().map(|&(_, end)| end).max().unwrap_or(0)
    }
}
