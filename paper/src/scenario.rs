//! The pipelines: stages of calls of one multi-task network.

use crate::platform::ENCODER_PER_MILLE;
use red_workload::model::{Arrival, Body, Node, Part, Pool, PoolKind, Stage, SyncGrid, Task, Work, Workload};

/// A task of the paper: one call of the network for one of its outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Net {
    /// Lane detection.
    L,
    /// Segmentation.
    S,
    /// Object detection.
    O,
    /// Cruise control.
    C,
}

impl Net {
    /// Name of its node and decoder.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::L => "lane",
            Self::S => "segment",
            Self::O => "detect",
            Self::C => "control",
        }
    }

    /// Cost in thousandths of an L task, its encoder included.
    #[must_use]
    pub const fn per_mille(self) -> u64 {
        match self {
            Self::L | Self::S => 1_000,
            Self::O => 1_055,
            Self::C => 820,
        }
    }
}

/// Stages, one after the other; the tasks of one stage are independent.
pub type Stages = &'static [&'static [Net]];

/// A scenario of the paper.
#[derive(Clone, Copy, Debug)]
pub struct Scenario {
    /// Name.
    pub name: &'static str,
    /// Stages.
    pub stages: Stages,
}

use Net::{C, L, O, S};
/// L, S, C.
pub const OBSTACLE_FREE: Scenario = Scenario { name: "obstacle-free", stages: &[&[L], &[S], &[C]] };
/// L, S + O, C.
pub const OBSTACLE: Scenario = Scenario { name: "obstacle", stages: &[&[L], &[S, O], &[C]] };
/// L + O, S + O, C.
pub const URBAN: Scenario = Scenario { name: "urban", stages: &[&[L, O], &[S, O], &[C]] };
/// O, L + S, C.
pub const EMERGENCY: Scenario = Scenario { name: "emergency", stages: &[&[O], &[L, S], &[C]] };
/// C, C, C.
pub const NIGHT: Scenario = Scenario { name: "night", stages: &[&[C], &[C], &[C]] };

/// How the calls of a pipeline look.
#[derive(Clone, Copy, Debug)]
pub struct Calls {
    /// WCET of an L task, in nanoseconds.
    pub unit_ns: u64,
    /// Encoder, in thousandths of an L task.
    pub encoder_per_mille: u64,
    /// How many calls of a pipeline are indivisible, in thousandths, spread evenly.
    pub atomic_per_mille: u64,
}

impl Calls {
    /// Divisible, with the usual encoder.
    #[must_use]
    pub const fn of(unit_ns: u64) -> Self {
        Self { unit_ns, encoder_per_mille: ENCODER_PER_MILLE, atomic_per_mille: 0 }
    }

    fn call(&self, net: Net, at: u64) -> Work {
        let whole = self.unit_ns * net.per_mille() / 1_000;
        // Indivisible: every k-th, so that a share of them is spread over the stages.
        if (at + 1) * self.atomic_per_mille / 1_000 > at * self.atomic_per_mille / 1_000 {
            return Work::Plain(Part { atomic: true, ..part(whole) });
        }
        let encoder = (self.unit_ns * self.encoder_per_mille / 1_000).min(whole);
        Work::Stage(Stage {
            weights: "mimo".to_owned(),
            frame: "front".to_owned(),
            encoder: part(encoder),
            decoders: vec![(net.name().to_owned(), part(whole - encoder))],
        })
    }

    /// A pipeline of these stages.
    #[must_use]
    pub fn pipeline(&self, stages: Stages, deadline_ns: u64, arrival: Arrival) -> Task {
        let name = |net: Net, stage: usize| format!("{}-{}", net.name(), stage + 1);
        let mut nodes = Vec::new();
        for (stage, nets) in stages.iter().enumerate() {
            let before = stage.checked_sub(1).map(|stage| (stage, stages[stage]));
            let after: Vec<String> =
                before.iter().flat_map(|(stage, nets)| nets.iter().map(|net| name(*net, *stage))).collect();
            for net in *nets {
                let work = self.call(*net, nodes.len() as u64);
                nodes.push(Node { name: name(*net, stage), after: after.clone(), before: Vec::new(), work });
            }
        }
        task("pipeline", deadline_ns, arrival, nodes)
    }
}

/// Something that takes this long and runs nothing.
#[must_use]
pub fn part(wcet_ns: u64) -> Part {
    Part { wcet_ns, bcet_ns: 0, body: Body::None, pool: 0, memory_bytes: 0, atomic: false, contention_ns: 0 }
}

/// A task from the start on.
#[must_use]
pub fn task(name: &str, deadline_ns: u64, arrival: Arrival, nodes: Vec<Node>) -> Task {
    Task { name: name.to_owned(), deadline_ns, arrival, offset_ns: 0, value: 1, floor: None, nodes }
}

/// A node that is one part.
#[must_use]
pub fn node(name: &str, after: &[&str], wcet_ns: u64) -> Node {
    let after = after.iter().map(|name| (*name).to_owned()).collect();
    Node { name: name.to_owned(), after, before: Vec::new(), work: Work::Plain(part(wcet_ns)) }
}

/// A workload on one pool of so many lanes.
#[must_use]
pub fn workload(lanes: u32, tasks: Vec<Task>, sync: Option<SyncGrid>) -> Workload {
    let pool =
        Pool { name: "gpu".to_owned(), kind: PoolKind::Cpu, lanes, memory_bytes: None, cpus: Vec::new() };
    Workload { pools: vec![pool], sensors: Vec::new(), tasks, events: Vec::new(), sync }
}
