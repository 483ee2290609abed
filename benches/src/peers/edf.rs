//! EDF as one writes it in 40 lines: successors in compressed rows, a binary heap of keys packed in one word.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::graphs::Graph;
use crate::measure::{Runner, timed};
use crate::not_run::NotRun;
use crate::peers::Setup;

/// The constant part: compressed rows of successors, indegrees, packed keys.
pub(super) struct Plan {
    first: Vec<u32>,
    successors: Vec<u16>,
    indegree: Vec<u16>,
    /// Deadline in the upper 48 bits, node in the lower 16.
    keys: Vec<u64>,
    roots: Vec<u32>,
}

/// The part that changes: a counter per node and the heap of the ready ones.
pub(super) struct State {
    left: Vec<u16>,
    ready: BinaryHeap<Reverse<u64>>,
}

impl Plan {
    pub(super) fn new(graph: &Graph) -> Self {
        let mut first = vec![0];
        let mut successors = Vec::new();
        for list in &graph.successors {
            successors.extend(list.iter().map(|&node| node as u16));
            first.push(successors.len() as u32);
        }
        Self {
            first,
            successors,
            indegree: graph.indegree.iter().map(|&count| count as u16).collect(),
            keys: (0..graph.nodes()).map(|node| graph.deadline(node) << 16 | node as u64).collect(),
            roots: graph.roots(),
        }
    }

    pub(super) fn state(&self) -> State {
        State { left: self.indegree.clone(), ready: BinaryHeap::with_capacity(self.indegree.len()) }
    }
}

impl State {
    #[inline(always)]
    pub(super) fn release(&mut self, plan: &Plan) {
        self.left.copy_from_slice(&plan.indegree);
        for &root in &plan.roots {
            self.ready.push(Reverse(plan.keys[root as usize]));
        }
    }

    #[inline(always)]
    pub(super) fn next(&mut self) -> Option<usize> {
        self.ready.pop().map(|Reverse(key)| (key & 0xffff) as usize)
    }

    #[inline(always)]
    pub(super) fn complete(&mut self, plan: &Plan, node: usize) {
        let row = plan.first[node] as usize..plan.first[node + 1] as usize;
        for &successor in &plan.successors[row] {
            let left = &mut self.left[usize::from(successor)];
            *left -= 1;
            if *left == 0 {
                self.ready.push(Reverse(plan.keys[usize::from(successor)]));
            }
        }
    }
}

/// Runs the graph on the calling thread.
pub(crate) fn build(setup: &Setup<'_>) -> Result<Runner, NotRun> {
    let plan = Plan::new(setup.graph);
    let mut state = plan.state();
    let (body, call) = (setup.body, setup.body.behind_pointer());
    Ok(timed(move |runs| {
        for _ in 0..runs {
            state.release(&plan);
            while let Some(node) = state.next() {
                call(body, node);
                state.complete(&plan, node);
            }
        }
    }))
}
