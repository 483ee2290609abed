//! From the record to slices: when each sub-job ran on which lane, and which slices led to it.

use crate::session::sub_deadlines::SubJob;
use red_core::{Event, EventKind};
use std::collections::HashMap;

/// One execution of a sub-job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Slice {
    /// Task, job, node.
    pub(super) of: SubJob,
    /// Where.
    pub(super) lane: usize,
    /// From.
    pub(super) start_ns: u64,
    /// Until.
    pub(super) end_ns: u64,
    /// Whether it ended by itself; else its job was given up, or the run ended.
    pub(super) completed: bool,
    /// The slices of its predecessors, as indices. An encoder that took a result instead of running has no slice:
    /// its own predecessors stand here then.
    pub(super) after: Vec<usize>,
}

/// What is known of a sub-job so far.
enum Place {
    Slice(usize),
    Hit,
}

/// The slices of a record, by start. `edges` are those of each task by node number; `end_of` tells when a job of a
/// task ended.
pub(super) fn slices(
    events: &[Event],
    edges: &[Vec<(usize, usize)>],
    end_of: impl Fn(usize, u64) -> u64,
) -> Vec<Slice> {
    let mut slices: Vec<Slice> = Vec::new();
    let mut places: HashMap<SubJob, Place> = HashMap::new();
    for event in events {
        let of = (event.task.index(), event.job, event.node.index());
        let at = event.at.as_nanos();
        match event.kind {
            EventKind::Started => {
                let after = before(&edges[of.0], &places, of);
                places.insert(of, Place::Slice(slices.len()));
                let end_ns = end_of(of.0, of.1).max(at);
                let lane = event.lane.index();
                slices.push(Slice { of, lane, start_ns: at, end_ns, completed: false, after });
            }
            EventKind::Completed => {
                if let Some(Place::Slice(index)) = places.get(&of) {
                    slices[*index].end_ns = at;
                    slices[*index].completed = true;
                }
            }
            EventKind::Hit => drop(places.insert(of, Place::Hit)),
            _ => {}
        }
    }
    slices
}

/// The slices that `of` waited for.
fn before(edges: &[(usize, usize)], places: &HashMap<SubJob, Place>, of: SubJob) -> Vec<usize> {
    let (mut found, mut open) = (Vec::new(), vec![of.2]);
    // Every node is opened once for each of its hits' successors: bounded by the edges of an acyclic graph.
    while let Some(node) = open.pop() {
        for (from, _) in edges.iter().filter(|(_, to)| *to == node) {
            match places.get(&(of.0, of.1, *from)) {
                Some(Place::Slice(index)) if !found.contains(index) => found.push(*index),
                Some(Place::Hit) if !open.contains(from) => open.push(*from),
                _ => {}
            }
        }
    }
    found
}

#[cfg(test)]
mod tests;
