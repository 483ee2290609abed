//! Sets of tasks that are more than the lanes can carry.

use crate::rng::Rng;
use crate::scoreboard::sets::{Graph, Task, uunifast};

const MS: u64 = 1_000_000;
/// Jobs of a graph that is alone.
pub(super) const LONE_JOBS: u64 = 200;
/// Releases of a set come within this time.
pub(super) const HORIZON_NS: u64 = 3_000 * MS;
/// Nodes of a graph, and their costs in microseconds.
pub(super) const NODES: (u64, u64) = (1, 6);
pub(super) const COST_US: (u64, u64) = (1_000, 15_000);
/// Tasks of a set, and of a set of equals.
pub(super) const TASKS: (u64, u64) = (2, 5);
pub(super) const EQUALS: (u64, u64) = (2, 4);
/// Values are log-uniform from 1 to this.
pub(super) const MOST_VALUE: f64 = 1_000.0;
/// How much time a job has beyond what it takes alone: this share of its period, or of that time where that is longer.
pub(super) const SLACK: (f64, f64) = (0.25, 1.0);
/// The graph that is alone: its costs and its deadline, in milliseconds.
const LONE_MS: [u64; 7] = [2, 9, 3, 4, 5, 14, 3];
const LONE_EDGES: [(usize, usize); 9] =
    [(0, 1), (1, 2), (1, 3), (1, 4), (0, 5), (2, 6), (3, 6), (4, 6), (5, 6)];
const LONE_DEADLINE_MS: u64 = 66;

/// What a set is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// One graph alone, with parallel branches.
    Lone,
    /// The same nodes one after the other.
    LoneChain,
    /// Tasks of different values.
    Values,
    /// The same, some with floors.
    Floors,
    /// Tasks of one value, graph and period.
    Alike,
    /// Tasks of one value.
    Equals,
}

/// How long nodes take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Times {
    /// Their WCET.
    Wcet,
    /// Uniform from half of it to all of it.
    Uniform,
    /// Half of it, and all of it one time in five.
    Bimodal,
}

/// Tasks, and what happens to them.
#[derive(Clone, Debug)]
pub(super) struct Set {
    pub(super) lanes: u8,
    pub(super) times: Times,
    pub(super) tasks: Vec<Task>,
    /// What a job of each task is worth.
    pub(super) values: Vec<u32>,
    /// The floor (m, k) of each task.
    pub(super) floors: Vec<Option<(u32, u32)>>,
    /// Instants of release of each task, ascending, in nanoseconds.
    pub(super) releases: Vec<Vec<u64>>,
    /// What execution times are drawn by, of each task: a task of a part of the set takes the times that it takes in all of it.
    seeds: Vec<u64>,
}

impl Times {
    /// All of them.
    pub(super) const ALL: [Self; 3] = [Self::Wcet, Self::Uniform, Self::Bimodal];

    /// Name in tables.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Wcet => "WCET",
            Self::Uniform => "uniform",
            Self::Bimodal => "bimodal",
        }
    }

    /// Mean, in percent of the WCET.
    pub(super) const fn mean_percent(self) -> u64 {
        match self {
            Self::Wcet => 100,
            Self::Uniform => 75,
            Self::Bimodal => 60,
        }
    }

    /// Least, in percent of the WCET.
    pub(super) const fn best_percent(self) -> u64 {
        match self {
            Self::Wcet => 100,
            Self::Uniform | Self::Bimodal => 50,
        }
    }

    fn draw(self, wcet: u64, rng: &mut Rng) -> u64 {
        match self {
            Self::Wcet => wcet,
            Self::Uniform => wcet * rng.within(500, 1_000) / 1_000,
            Self::Bimodal => {
                if rng.chance(0.2) {
                    wcet
                } else {
                    wcet / 2
                }
            }
        }
    }
}

impl Set {
    /// Draws one whose mean work is `load` times what the lanes can do.
    pub(super) fn draw(shape: Shape, lanes: u8, load: f64, times: Times, seed: u64) -> Self {
        // The same graphs for all execution times.
        let words = [shape.drawn_as() as u64, lanes.into(), (load * 100.0).round() as u64, seed];
        let rng = &mut Rng::of(&words);
        let total = load * f64::from(lanes);
        let (graphs, shares) = shape.graphs(rng, total);
        let mut set = Self::of(lanes, times);
        for (nth, (graph, share)) in graphs.into_iter().zip(shares).enumerate() {
            let mean = graph.work() * times.mean_percent() / 100;
            let period_ns = (mean as f64 / share) as u64;
            let alone = graph.longest().max(graph.work().div_ceil(lanes.into()));
            let slack = SLACK.0 + (SLACK.1 - SLACK.0) * rng.unit();
            let deadline_ns = alone + (slack * period_ns.max(alone) as f64) as u64;
            let first = rng.within(0, period_ns - 1);
            let value = MOST_VALUE.powf(rng.unit()).round() as u32;
            let k = rng.within(2, 5) as u32;
            let floor = (rng.within(1, u64::from(k) - 1) as u32, k);
            let has_floor = rng.chance(0.5);
            let (deadline_ns, releases) = if shape.is_alone() {
                (LONE_DEADLINE_MS * MS, (0..LONE_JOBS).map(|job| job * period_ns).collect())
            } else {
                (deadline_ns, (first..HORIZON_NS).step_by(period_ns as usize).collect())
            };
            // What is alike shares its deadline too.
            let deadline_ns = match set.tasks.first() {
                Some(first) if shape == Shape::Alike => first.deadline_ns,
                _ => deadline_ns,
            };
            let value = if shape.has_values() { value } else { 1 };
            let floor = (shape == Shape::Floors && has_floor).then_some(floor);
            let seed = words.iter().fold(nth as u64, |seed, word| Rng::of(&[seed, *word]).bits());
            set.add(Task { graph, period_ns, deadline_ns }, value, floor, releases, seed);
        }
        set
    }

    /// One without tasks.
    pub(super) const fn of(lanes: u8, times: Times) -> Self {
        Self {
            lanes,
            times,
            tasks: Vec::new(),
            values: Vec::new(),
            floors: Vec::new(),
            releases: Vec::new(),
            seeds: Vec::new(),
        }
    }

    /// One more task, whose execution times are drawn by `seed`.
    pub(super) fn add(
        &mut self,
        task: Task,
        value: u32,
        floor: Option<(u32, u32)>,
        releases: Vec<u64>,
        seed: u64,
    ) {
        self.tasks.push(task);
        self.values.push(value);
        self.floors.push(floor);
        self.releases.push(releases);
        self.seeds.push(seed);
    }

    /// These tasks alone, with deadlines that are shorter by so much; `None` where one has no time left.
    pub(super) fn part(&self, tasks: &[usize], shorter_ns: u64) -> Option<Self> {
        let mut part = Self::of(self.lanes, self.times);
        for &nth in tasks {
            let deadline_ns = self.tasks[nth].deadline_ns.checked_sub(shorter_ns).filter(|ns| *ns > 0)?;
            let task = Task { deadline_ns, ..self.tasks[nth].clone() };
            let (releases, seed) = (self.releases[nth].clone(), self.seeds[nth]);
            part.add(task, self.values[nth], self.floors[nth], releases, seed);
        }
        Some(part)
    }

    /// How long a node takes, in nanoseconds.
    pub(super) fn time(&self, task: usize, job: u64, node: usize) -> u64 {
        let wcet = self.tasks[task].graph.costs[node];
        self.times.draw(wcet, &mut Rng::of(&[self.seeds[task], job, node as u64]))
    }

    /// What a node takes in the mean, in nanoseconds.
    pub(super) fn mean(&self, task: usize, node: usize) -> u64 {
        self.tasks[task].graph.costs[node] * self.times.mean_percent() / 100
    }

    /// How long all nodes of a job take together, in nanoseconds.
    pub(super) fn work(&self, task: usize, job: u64) -> u64 {
        (0..self.tasks[task].graph.costs.len()).map(|node| self.time(task, job, node)).sum()
    }

    /// All jobs, as (task, number).
    pub(super) fn jobs(&self) -> impl Iterator<Item = (usize, u64)> + '_ {
        let of =
            |(task, releases): (usize, &Vec<u64>)| (0..releases.len() as u64).map(move |job| (task, job));
        self.releases.iter().enumerate().flat_map(of)
    }
}

impl Shape {
    /// All of them.
    pub(super) const ALL: [Self; 6] =
        [Self::Lone, Self::LoneChain, Self::Values, Self::Floors, Self::Alike, Self::Equals];

    /// Sets with floors are those without, and floors.
    const fn drawn_as(self) -> Self {
        match self {
            Self::Floors => Self::Values,
            shape => shape,
        }
    }

    /// Whether it is one task.
    pub(super) const fn is_alone(self) -> bool {
        matches!(self, Self::Lone | Self::LoneChain)
    }

    const fn has_values(self) -> bool {
        matches!(self, Self::Values | Self::Floors)
    }

    /// Graphs, and how many lanes each keeps busy in the mean.
    fn graphs(self, rng: &mut Rng, total: f64) -> (Vec<Graph>, Vec<f64>) {
        let count = |rng: &mut Rng, (low, high): (u64, u64)| rng.within(low, high) as usize;
        match self {
            Self::Lone => (vec![lone(&LONE_EDGES)], vec![total]),
            Self::LoneChain => {
                let edges: Vec<(usize, usize)> = (1..LONE_MS.len()).map(|to| (to - 1, to)).collect();
                (vec![lone(&edges)], vec![total])
            }
            Self::Values | Self::Floors => {
                let count = count(rng, TASKS);
                ((0..count).map(|_| graph(rng)).collect(), uunifast(rng, count, total))
            }
            Self::Equals => {
                let count = count(rng, EQUALS);
                ((0..count).map(|_| graph(rng)).collect(), uunifast(rng, count, total))
            }
            Self::Alike => {
                let count = count(rng, EQUALS);
                (vec![graph(rng); count], vec![total / count as f64; count])
            }
        }
    }
}

fn lone(edges: &[(usize, usize)]) -> Graph {
    let costs: Vec<u64> = LONE_MS.iter().map(|ms| ms * MS).collect();
    let mut graph = Graph { successors: vec![Vec::new(); costs.len()], costs };
    edges.iter().for_each(|(from, to)| graph.link(*from, *to));
    graph
}

/// A chain; or, as often, a first and a last node with all others side by side between them.
fn graph(rng: &mut Rng) -> Graph {
    let count = rng.within(NODES.0, NODES.1) as usize;
    let costs: Vec<u64> = (0..count).map(|_| 1_000 * rng.within(COST_US.0, COST_US.1)).collect();
    let mut graph = Graph { costs, successors: vec![Vec::new(); count] };
    let is_chain = rng.chance(0.5);
    for node in 1..count {
        graph.link(if is_chain { node - 1 } else { 0 }, node);
        if !is_chain && 0 < node && node < count - 1 {
            graph.link(node, count - 1);
        }
    }
    graph
}
