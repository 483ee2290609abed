//! Where the time of a job went: its critical chain, walked backwards.
//!
//! *Rule.* From the node that ended last, or of a job that did not end the unfinished one with the longest way to go: its
//! executions, what it waited for before and between them, then that predecessor which ended last, up to the release. A
//! node that was ready waited for its lane as long as that had something else, and the others of its pool did too, else
//! the scheduler had started it. If the lane was free, then the pool's memory was not, or the lane had not asked yet.
//! *Why it adds up.* Each step covers the time from where the one before it ended, so there are neither gaps nor overlaps:
//! the parts are as long together as the response.

use crate::model::{Job, Kind, Part, Run, SubJob};
use std::collections::HashMap;

/// What is looked up again and again.
#[derive(Debug)]
pub struct Blame<'a> {
    run: &'a Run,
    /// Slices of each sub-job, by start.
    slices: HashMap<SubJob, Vec<usize>>,
    /// Of each sub-job that took a result, the last time.
    hits: HashMap<SubJob, usize>,
    /// Slices of each lane by start, one for each unit.
    lanes: Vec<Vec<usize>>,
}

impl<'a> Blame<'a> {
    /// Prepares.
    #[must_use]
    pub fn new(run: &'a Run) -> Self {
        let mut slices: HashMap<SubJob, Vec<usize>> = HashMap::new();
        let mut lanes: Vec<Vec<usize>> = vec![Vec::new(); run.lanes.len()];
        for (index, slice) in run.slices.iter().enumerate() {
            slices.entry(slice.of).or_default().push(index);
            let Some(lane) = lanes.get_mut(slice.lane) else { continue };
            if lane.last().is_none_or(|last| run.slices[*last].unit != slice.unit) {
                lane.push(index);
            }
        }
        let hits = run.hits.iter().enumerate().map(|(index, hit)| (hit.of, index)).collect();
        Self { run, slices, hits, lanes }
    }

    /// The parts from the release of a job to `until_ns`, first things first.
    #[must_use]
    pub fn chain(&self, task: usize, number: u64, until_ns: u64) -> Vec<Part> {
        let Some(job) = self.run.job(task, number) else { return Vec::new() };
        let mut walk = Walk { blame: self, task, number, job, parts: Vec::new(), at_ns: until_ns };
        walk.back();
        walk.parts.reverse();
        walk.parts
    }

    /// When a sub-job ended, the last time; `None`: it has not.
    fn ended(&self, of: SubJob) -> Option<u64> {
        let hit = self.hits.get(&of).map(|hit| self.run.hits[*hit].at_ns);
        let slice = self.slices.get(&of).and_then(|all| all.last()).map(|last| &self.run.slices[*last]);
        let ran = slice.filter(|slice| slice.completed).map(|slice| slice.end_ns);
        hit.max(ran)
    }
}

/// A walk back from the end.
struct Walk<'a> {
    blame: &'a Blame<'a>,
    task: usize,
    number: u64,
    job: &'a Job,
    /// Last things first.
    parts: Vec<Part>,
    /// What comes after this is covered.
    at_ns: u64,
}

impl Walk<'_> {
    fn back(&mut self) {
        let run = self.blame.run;
        let graph = run.graphs.get(self.job.graph);
        let mut next = self.last();
        // Each round goes to a predecessor: at most as many as there are nodes.
        for _ in 0..=graph.map_or(0, |graph| graph.nodes.len()) {
            let Some((node, facts)) = next.and_then(|node| Some((node, graph?.nodes.get(&node)?))) else {
                break;
            };
            let of = (self.task, self.number, node);
            let ended = |node: &usize| Some((self.blame.ended((self.task, self.number, *node))?, *node));
            let before = facts.after.iter().filter_map(ended).max();
            let ready_ns = before.map_or(self.job.recorded_ns, |(at, _)| at.max(self.job.recorded_ns));
            let level = graph.into_iter().flat_map(|graph| &graph.nodes);
            let level = level.filter(|(_, other)| run.level_gate && other.height < facts.height);
            let gate = level.filter_map(|(node, _)| ended(node)).max().filter(|(at, _)| *at > ready_ns);
            self.worked(of, facts.pool, gate.map_or(ready_ns, |(at, _)| at));
            if let Some((_, other)) = gate {
                self.cover(Kind::Gate, Some(node), ready_ns, Some((self.task, self.number, other)));
            }
            next = before.filter(|(at, _)| *at > self.job.recorded_ns).map(|(_, node)| node);
        }
        // Of a job whose graph is not known: somebody's, and nobody's in particular.
        self.cover(Kind::Dispatch, None, self.job.recorded_ns, None);
        self.cover(Kind::Release, None, self.job.release_ns, None);
    }

    /// The node that the end depends on.
    fn last(&self) -> Option<usize> {
        let graph = self.blame.run.graphs.get(self.job.graph)?;
        let ended = |node: usize| self.blame.ended((self.task, self.number, node));
        if self.job.end_ns.is_some() && self.job.shed.is_none() {
            return graph
                .nodes
                .keys()
                .copied()
                .filter_map(|node| Some((ended(node)?, node)))
                .max()
                .map(|(_, n)| n);
        }
        let open = graph.nodes.iter().filter(|(node, facts)| {
            ended(**node).is_none() && facts.after.iter().all(|before| ended(*before).is_some())
        });
        open.max_by_key(|(node, facts)| (facts.rest_ns, std::cmp::Reverse(**node))).map(|(node, _)| *node)
    }

    /// Covers the time since `ready_ns` with what a sub-job executed and waited for.
    fn worked(&mut self, of: SubJob, pool: usize, ready_ns: u64) {
        let run = self.blame.run;
        let node = Some(of.2);
        if let Some(hit) =
            self.blame.hits.get(&of).map(|hit| &run.hits[*hit]).filter(|hit| hit.at_ns <= self.at_ns)
        {
            let kind = if hit.by.is_some() { Kind::Encoder } else { Kind::Dispatch };
            return self.cover(kind, node, ready_ns, hit.by);
        }
        let wcet_ns =
            run.graphs.get(self.job.graph).and_then(|graph| graph.nodes.get(&of.2)).map(|n| n.wcet_ns);
        let slices: Vec<usize> = self.blame.slices.get(&of).cloned().unwrap_or_default();
        let mut slices: Vec<_> = slices.iter().map(|slice| &run.slices[*slice]).collect();
        slices.retain(|slice| slice.start_ns < self.at_ns && slice.end_ns > ready_ns);
        // Where it starts, or would have.
        let mut lane = slices.last().map(|slice| slice.lane);
        for slice in slices.iter().rev() {
            self.waited(node, pool, lane, slice.end_ns.max(ready_ns));
            let overran_ns = slice.start_ns.saturating_add(wcet_ns.unwrap_or(u64::MAX));
            self.cover(Kind::Overrun, node, overran_ns.max(ready_ns), None);
            self.cover(Kind::Execution, node, slice.start_ns.max(ready_ns), None);
            lane = Some(slice.lane);
        }
        self.waited(node, pool, lane, ready_ns);
    }

    /// Covers the time since `from_ns`, in which a node was ready and did not run.
    fn waited(&mut self, node: Option<usize>, pool: usize, lane: Option<usize>, from_ns: u64) {
        let run = self.blame.run;
        let free = if run.pools.get(pool).is_some_and(|pool| pool.is_limited) {
            Kind::Memory
        } else {
            Kind::Dispatch
        };
        // One that never started would have taken the lane of its pool that was free last.
        let first = || (0..run.lanes.len()).find(|lane| run.lanes[*lane].pool == pool);
        let units = lane.or_else(first).and_then(|lane| self.blame.lanes.get(lane));
        let units = units.map_or(&[][..], Vec::as_slice);
        let before = units.partition_point(|unit| run.slices[*unit].start_ns < self.at_ns);
        for unit in units[..before].iter().rev() {
            let slice = &run.slices[*unit];
            if slice.end_ns <= from_ns || self.at_ns <= from_ns {
                break;
            }
            self.cover(free, node, slice.end_ns.max(from_ns), None);
            self.cover(Kind::Lane, node, slice.start_ns.max(from_ns), Some(slice.of));
        }
        self.cover(free, node, from_ns, None);
    }

    /// The time since `from_ns` that is not covered yet is of this kind.
    fn cover(&mut self, kind: Kind, node: Option<usize>, from_ns: u64, by: Option<SubJob>) {
        let from_ns = from_ns.max(self.job.release_ns);
        if from_ns < self.at_ns {
            self.parts.push(Part { kind, node, from_ns, to_ns: self.at_ns, by });
            self.at_ns = from_ns;
        }
    }
}

/// Parts of one node and kind in a row, as one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// What.
    pub kind: Kind,
    /// The node.
    pub node: Option<usize>,
    /// How long.
    pub ns: u64,
    /// Who had what it waited for, and how long; the longest first.
    pub by: Vec<(SubJob, u64)>,
}

/// A chain in steps, which are as long together as its parts.
#[must_use]
pub fn steps(parts: &[Part]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for part in parts {
        match steps.last_mut().filter(|step| (step.kind, step.node) == (part.kind, part.node)) {
            Some(step) => step.ns += part.ns(),
            None => steps.push(Step { kind: part.kind, node: part.node, ns: part.ns(), by: Vec::new() }),
        }
        if let (Some(step), Some(by)) = (steps.last_mut(), part.by) {
            match step.by.iter_mut().find(|(other, _)| *other == by) {
                Some((_, ns)) => *ns += part.ns(),
                None => step.by.push((by, part.ns())),
            }
        }
    }
    steps.iter_mut().for_each(|step| step.by.sort_by_key(|(by, ns)| (std::cmp::Reverse(*ns), *by)));
    steps
}

/// Which of its parts a chain is longest in: the kind, and whose lane or encoder it was, its own task's or another's.
#[must_use]
pub fn longest(parts: &[Part]) -> Option<(Kind, Option<usize>)> {
    let mut sums: Vec<((Kind, Option<usize>), u64)> = Vec::new();
    for part in parts {
        let key = (part.kind, part.by.map(|(task, ..)| task));
        match sums.iter_mut().find(|(other, _)| *other == key) {
            Some((_, sum)) => *sum += part.ns(),
            None => sums.push((key, part.ns())),
        }
    }
    // Of equal ones the first.
    sums.into_iter().rev().max_by_key(|(_, sum)| *sum).map(|(key, _)| key)
}

#[cfg(test)]
mod tests;
