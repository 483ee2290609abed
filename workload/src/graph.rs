//! The graph of a task through all its versions: names resolve, and no version has a cycle.
//!
//! Two views of each version are checked, because either can have a cycle of its own making: refined, where a
//! stage is an encoder and its decoders, and coarse, where it is one node, as policy edf runs it.

mod cycle;

use std::collections::HashMap;
use std::ops::Range;

use crate::error::{Fault, Refusal, shown};
use crate::model::Work;
use crate::read::{PlacedEvent, PlacedNode, PlacedTask};
use cycle::{VertexSet, find_cycle};

/// Nodes that a message about a cycle names.
const NAMED_ON_CYCLE: usize = 6;

/// Checks the task's graph as written and after each of its events, which come in the order of their instants. An
/// event removes before it adds, so that it can replace a node by one of the same name.
pub(crate) fn check<'r>(
    task: &'r PlacedTask,
    events: impl Iterator<Item = &'r PlacedEvent>,
) -> Result<(), Fault> {
    let mut graph = Graph::default();
    graph.add(&task.nodes)?;
    for placed in events {
        for (name, at) in placed.event.remove.iter().zip(&placed.remove_at) {
            graph.remove(name, *at)?;
        }
        graph.add(&placed.add)?;
        if let (true, Some(at)) = (graph.present.is_empty(), placed.remove_at.last()) {
            let problem = format!("the task `{}` has no node left after this", shown(&task.task.name));
            return Err(Fault::new(*at, Refusal::Missing, problem, "at least one node at any time"));
        }
    }
    Ok(())
}

/// One version of a task's graph. Vertices are the refined nodes; a vertex's number is never used again.
#[derive(Default)]
struct Graph<'r> {
    /// Every node that was ever there, in the order of appearance.
    members: Vec<Member<'r>>,
    /// The members that are there now, by name.
    present: HashMap<&'r str, usize>,
    /// Of each vertex.
    successors: Vec<VertexSet>,
    /// The member that each vertex belongs to.
    owners: Vec<usize>,
}

struct Member<'r> {
    placed: &'r PlacedNode,
    /// An ordinary node is one vertex; a stage's first vertex is its encoder.
    vertices: Range<usize>,
}

impl Member<'_> {
    /// The vertices that end the member.
    fn sinks(&self) -> Range<usize> {
        match self.placed.node.work {
            Work::Plain(_) => self.vertices.clone(),
            Work::Stage(_) => self.vertices.start + 1..self.vertices.end,
        }
    }
}

impl<'r> Graph<'r> {
    /// Adds nodes that may refer to each other in any order.
    fn add(&mut self, nodes: &'r [PlacedNode]) -> Result<(), Fault> {
        let first = self.members.len();
        for placed in nodes {
            self.add_vertices(placed)?;
        }
        for member in first..self.members.len() {
            self.add_edges(member)?;
        }
        if nodes.is_empty() { Ok(()) } else { self.check_acyclic() }
    }

    fn add_vertices(&mut self, placed: &'r PlacedNode) -> Result<(), Fault> {
        let member = self.members.len();
        if self.present.insert(&placed.node.name, member).is_some() {
            let problem = format!("the task already has a node named `{}`", shown(&placed.node.name));
            return Err(Fault::new(placed.at, Refusal::Duplicate, problem, "a name that is not taken"));
        }
        let start = self.successors.len();
        let vertices = start..start + placed.part_names().count().max(1);
        self.successors.resize_with(vertices.end, VertexSet::default);
        self.owners.resize(vertices.end, member);
        for decoder in start + 1..vertices.end {
            self.successors[start].insert(decoder);
        }
        self.members.push(Member { placed, vertices });
        Ok(())
    }

    fn add_edges(&mut self, member: usize) -> Result<(), Fault> {
        let Member { placed, vertices } = &self.members[member];
        let (placed, entry, sinks) = (*placed, vertices.start, self.members[member].sinks());
        for (name, at) in placed.node.after.iter().zip(&placed.after_at) {
            let (other, part) = self.resolve("after", name, *at, member)?;
            let sources = part.map_or_else(|| self.members[other].sinks(), |part| part..part + 1);
            for source in sources {
                self.successors[source].insert(entry);
            }
        }
        for (name, at) in placed.node.before.iter().zip(&placed.before_at) {
            let (other, part) = self.resolve("before", name, *at, member)?;
            let target = part.unwrap_or(self.members[other].vertices.start);
            for sink in sinks.clone() {
                self.successors[sink].insert(target);
            }
        }
        Ok(())
    }

    /// The member that a name means, and the vertex if it means one part of a stage.
    fn resolve(
        &self,
        key: &str,
        name: &str,
        at: usize,
        from: usize,
    ) -> Result<(usize, Option<usize>), Fault> {
        let (node, part) = name.split_once('.').map_or((name, None), |(node, part)| (node, Some(part)));
        let Some(member) = self.present.get(node).copied() else {
            return Err(self.unknown(key, name, node, at));
        };
        if member == from {
            let problem = format!("`{key}` of `{}` names the node itself", shown(node));
            return Err(Fault::new(at, Refusal::Cycle, problem, "another node"));
        }
        let Some(part) = part else {
            return Ok((member, None));
        };
        let Member { placed, vertices } = &self.members[member];
        match placed.part_names().position(|candidate| candidate == part) {
            Some(index) => Ok((member, Some(vertices.start + index))),
            None => {
                let problem =
                    format!("`{key}` names `{}`, but `{}` has no such part", shown(name), shown(node));
                let parts: Vec<String> = placed.part_names().map(|part| format!("{node}.{part}")).collect();
                let expected = "the name of a node, or `stage.decoder` for one part of a stage";
                let candidates = parts.iter().map(String::as_str).chain([node]);
                Err(Fault::new(at, Refusal::Reference, problem, expected).with_nearest(name, candidates))
            }
        }
    }

    fn unknown(&self, key: &str, name: &str, node: &str, at: usize) -> Fault {
        let was_there = self.members.iter().any(|member| member.placed.node.name == node);
        let why = if was_there { "removed by then" } else { "no node of this task at that time" };
        let problem = format!("`{key}` names `{}`, which is {why}", shown(name));
        Fault::new(at, Refusal::Reference, problem, "the name of a node that is there")
            .with_nearest(node, self.present.keys().copied())
    }

    /// Removes a node; edges from and to it go with it.
    fn remove(&mut self, name: &str, at: usize) -> Result<(), Fault> {
        if let Some((stage, _)) = name.split_once('.') {
            let problem = format!("`remove` names `{}`, a part of a stage", shown(name));
            return Err(Fault::new(
                at,
                Refusal::Reference,
                problem,
                "the name of a node: a stage goes as a whole",
            )
            .with_nearest(stage, self.present.keys().copied()));
        }
        let Some(member) = self.present.remove(name) else {
            return Err(self.unknown("remove", name, name, at));
        };
        for vertex in self.members[member].vertices.clone() {
            self.successors[vertex] = VertexSet::default();
            for successors in &mut self.successors {
                successors.remove(vertex);
            }
        }
        Ok(())
    }

    fn check_acyclic(&self) -> Result<(), Fault> {
        if let Some(cycle) = find_cycle(&self.successors) {
            let names = cycle.iter().map(|vertex| self.vertex_name(*vertex));
            let members = cycle.iter().map(|vertex| self.owners[*vertex]);
            return Err(self.cyclic(members, names, "these nodes wait for each other:"));
        }
        if let Some(cycle) = find_cycle(&self.coarse_successors()) {
            let names = cycle.iter().map(|member| self.members[*member].placed.node.name.clone());
            let problem =
                "with each stage as one node, as policy edf runs it, these nodes wait for each other:";
            return Err(self.cyclic(cycle.iter().copied(), names, problem));
        }
        Ok(())
    }

    /// The graph of members: a stage is one node.
    fn coarse_successors(&self) -> Vec<VertexSet> {
        let mut coarse = vec![VertexSet::default(); self.members.len()];
        for (vertex, successors) in self.successors.iter().enumerate() {
            let member = self.owners[vertex];
            for successor in successors.iter().map(|successor| self.owners[successor]) {
                if successor != member {
                    coarse[member].insert(successor);
                }
            }
        }
        coarse
    }

    fn vertex_name(&self, vertex: usize) -> String {
        let Member { placed, vertices } = &self.members[self.owners[vertex]];
        let node = &placed.node.name;
        placed
            .part_names()
            .nth(vertex - vertices.start)
            .map_or_else(|| node.clone(), |part| format!("{node}.{part}"))
    }

    /// The newest node on the cycle is the place to tell: the older ones had no cycle without it.
    fn cyclic(
        &self,
        members: impl Iterator<Item = usize>,
        names: impl ExactSizeIterator<Item = String>,
        problem: &str,
    ) -> Fault {
        let newest = members.max().map_or(0, |member| self.members[member].placed.at);
        let hidden = names.len().saturating_sub(NAMED_ON_CYCLE);
        let mut names: Vec<String> =
            names.take(NAMED_ON_CYCLE).map(|name| format!("`{}`", shown(&name))).collect();
        let first = names.first().cloned();
        names.extend((hidden > 0).then(|| format!("{hidden} more")));
        names.extend(first);
        let problem = format!("{problem} {}", names.join(" -> "));
        Fault::new(newest, Refusal::Cycle, problem, "no cycle: drop one of these edges")
    }
}

#[cfg(test)]
mod tests;
