//! What is measured: each node alone, each against its heaviest co-runners, and the parallelism of each pool.

use super::figures::Sample;
use super::lanes::{Lanes, Part, Place, Trouble};
use super::machine::Machine;
use crate::output;
use crate::session::cuda::is_cuda;
use crate::table::time;
use red_core::NodeId;
use red_workload::build::{Numbered, Role};
use red_workload::model::{self, Workload};
use std::cmp::Reverse;

/// Everything there is to measure with.
pub(super) struct Bench<'a> {
    pub(super) lanes: &'a Lanes<'a>,
    pub(super) machine: &'a Machine,
    pub(super) workload: &'a Workload,
    pub(super) nodes: &'a [Vec<Numbered>],
}

/// A node and its times.
pub(super) struct Node {
    /// Task, in the order of the file.
    pub(super) task: usize,
    /// Row name, such as `perception.lane`.
    pub(super) name: String,
    /// What the file says of it.
    pub(super) part: model::Part,
    /// Alone on its CPU.
    pub(super) alone: Sample,
    /// How much longer the longest run against co-runners was; `None` on a machine of one CPU.
    pub(super) contention_ns: Option<u64>,
    place: Place,
}

/// What the measurements say.
pub(super) struct Measured {
    /// Nodes by task, in the order of their numbers.
    pub(super) nodes: Vec<Node>,
    /// Effective parallelism of each pool in hundredths, `None` of a pool without nodes.
    pub(super) rho_percent: Vec<Option<u64>>,
}

impl Bench<'_> {
    /// Measures everything, telling each node's times on standard error.
    ///
    /// # Errors
    /// A body failed, or a signal came.
    pub(super) fn measure(&self) -> Result<Measured, Trouble> {
        let mut nodes = Vec::new();
        for (task, numbered) in self.nodes.iter().enumerate() {
            for (number, node) in numbered.iter().enumerate() {
                nodes.push(self.alone(task, number, node)?);
            }
        }
        if self.machine.cpus.len() == 1 && nodes.iter().any(|node| !self.is_on_device(node)) {
            output::note("one CPU: contention cannot be measured and stays as it is in the file");
        }
        for index in 0..nodes.len() {
            nodes[index].contention_ns = self.against(&nodes, index)?;
        }
        let pools = 0..self.workload.pools.len();
        let rho_percent = pools.map(|pool| self.parallelism(&nodes, pool)).collect::<Result<_, _>>()?;
        Ok(Measured { nodes, rho_percent })
    }

    fn alone(&self, task: usize, number: usize, node: &Numbered) -> Result<Node, Trouble> {
        let (part, encoder) = match &node.role {
            Role::Plain(part) | Role::Encoder { part, .. } => (part, None),
            Role::Decoder { part, encoder } => (part, Some(id(*encoder))),
            Role::Coarse(stage) => (&stage.encoder, None),
        };
        let owner = &self.workload.tasks[task];
        let place = Place { task, node: id(number), encoder, deadline_ns: owner.deadline_ns };
        let lane = self.machine.lanes_of_pool[part.pool][0];
        let times = self.lanes.drill(vec![Part { lane, pass: vec![place] }])?;
        let alone = Sample::of(times.into_iter().flatten().collect());
        output::note(&format!(
            "{}.{} alone: {} runs, at most {}",
            owner.name,
            node.name,
            alone.runs,
            time(Some(alone.max_ns))
        ));
        Ok(Node { task, name: node.name.clone(), part: part.clone(), alone, contention_ns: None, place })
    }

    fn is_on_device(&self, node: &Node) -> bool {
        is_cuda(self.workload, node.part.pool)
    }

    /// How much longer the node's longest run is while all other lanes of its kind run its heaviest co-runners; `None`: there
    /// are none.
    fn against(&self, nodes: &[Node], index: usize) -> Result<Option<u64>, Trouble> {
        let node = &nodes[index];
        let is_on_device = self.is_on_device(node);
        let of_pool = &self.machine.lanes_of_pool[node.part.pool];
        let lane = of_pool[0];
        let all = if is_on_device { of_pool.clone() } else { (0..self.machine.cpus.len()).collect() };
        let rest: Vec<usize> = all.into_iter().filter(|other| *other != lane).collect();
        if rest.is_empty() {
            return Ok(None);
        }
        // A stream runs the nodes of its pool.
        let is_beside = |n: &Node| {
            self.is_on_device(n) == is_on_device && (!is_on_device || n.part.pool == node.part.pool)
        };
        let weights: Vec<Option<Weight>> = nodes
            .iter()
            .map(|n| {
                is_beside(n).then_some(Weight { memory_bytes: n.part.memory_bytes, cost_ns: n.alone.max_ns })
            })
            .collect();
        let mix = heaviest_mix(&weights, index, rest.len());
        let co_runners =
            rest.into_iter().zip(&mix).map(|(lane, other)| Part { lane, pass: vec![nodes[*other].place] });
        let parts = std::iter::once(Part { lane, pass: vec![node.place] }).chain(co_runners).collect();
        let times = self.lanes.drill(parts)?.swap_remove(0);
        let longest = Sample::of(times).max_ns;
        let contention_ns = longest.saturating_sub(node.alone.max_ns);
        let task = &self.workload.tasks[node.task].name;
        let by: Vec<&str> = mix.iter().map(|other| nodes[*other].name.as_str()).collect();
        output::note(&format!(
            "{task}.{} against {}: {} more",
            node.name,
            by.join(", "),
            time(Some(contention_ns))
        ));
        Ok(Some(contention_ns))
    }

    /// Throughput of all lanes that run the pool's nodes, in hundredths of one lane's. A lane's throughput is one
    /// over its median pass, which hiccups do not move.
    fn parallelism(&self, nodes: &[Node], pool: usize) -> Result<Option<u64>, Trouble> {
        let places: Vec<Place> = nodes.iter().filter(|n| n.part.pool == pool).map(|n| n.place).collect();
        let lanes = &self.machine.lanes_of_pool[pool];
        if places.is_empty() {
            return Ok(None);
        }
        let part = |(i, lane): (usize, &usize)| {
            let mut pass = places.clone();
            // Lanes at different nodes, as in a run.
            pass.rotate_left(i * places.len() / lanes.len());
            Part { lane: *lane, pass }
        };
        let medians = |lanes: &[usize]| -> Result<Vec<f64>, Trouble> {
            let times = self.lanes.drill(lanes.iter().enumerate().map(part).collect())?;
            Ok(times.into_iter().map(|times| Sample::of(times).median_ns.max(1) as f64).collect())
        };
        let alone: f64 = medians(&lanes[..1])?.iter().sum();
        let rho: f64 = if lanes.len() == 1 {
            1.0
        } else {
            medians(lanes)?.iter().map(|together| alone / together).sum()
        };
        let name = &self.workload.pools[pool].name;
        let kind = if is_cuda(self.workload, pool) { "streams" } else { "CPUs" };
        output::note(&format!("pool {name}: rho {rho:.2}, {kind} used: {}", lanes.len()));
        Ok(Some((rho * 100.0).round() as u64))
    }
}

/// What makes a co-runner heavy: its memory, and among equals its cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Weight {
    memory_bytes: u64,
    cost_ns: u64,
}

/// The mix of largest sum: the heaviest nodes besides `subject` of those that have a weight, from the start again where
/// there are fewer than `count`; alone in its workload, the node itself, of another job.
fn heaviest_mix(weights: &[Option<Weight>], subject: usize, count: usize) -> Vec<usize> {
    let may = |other: &usize| *other != subject && weights[*other].is_some();
    let mut others: Vec<usize> = (0..weights.len()).filter(may).collect();
    others.sort_by_key(|other| Reverse(weights[*other]));
    if others.is_empty() {
        others.push(subject);
    }
    others.into_iter().cycle().take(count).collect()
}

fn id(number: usize) -> NodeId {
    NodeId::new(u8::try_from(number).unwrap_or(u8::MAX))
}

#[cfg(test)]
mod tests;
