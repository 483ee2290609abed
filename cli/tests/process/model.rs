//! Random workload files, as numbers that a test can change.

use red_tests::rng::Rng;
use std::fmt::Write;

/// A file, as numbers. Times are nanoseconds.
#[derive(Clone)]
pub(crate) struct Model {
    /// Pools `p0`, `p1`.
    pub(crate) lanes: Vec<u64>,
    /// By pool: names and lanes of its clusters.
    pub(crate) clusters: Vec<Vec<(String, u64)>>,
    /// Tasks `t0`, `t1`.
    pub(crate) tasks: Vec<Task>,
}

#[derive(Clone)]
pub(crate) struct Task {
    pub(crate) deadline: u64,
    pub(crate) period: u64,
    pub(crate) value: u64,
    pub(crate) cluster: Option<String>,
    /// Nodes `n0`, `n1`.
    pub(crate) nodes: Vec<Node>,
}

#[derive(Clone)]
pub(crate) struct Node {
    pub(crate) wcet: u64,
    pub(crate) bcet: u64,
    pub(crate) pool: usize,
    pub(crate) after: Vec<usize>,
}

/// Up to four tasks of up to five nodes that ask for somewhat more than they should, in periods long enough that a
/// minute has few jobs.
pub(crate) fn drawn(seed: u64, load_percent: (u64, u64)) -> Model {
    let rng = &mut Rng::new(seed);
    let pools = if rng.chance(30) { 2 } else { 1 };
    let lanes: Vec<u64> = (0..pools).map(|_| rng.within(1, 3)).collect();
    let (count, load) = (rng.within(1, 4), rng.within(load_percent.0, load_percent.1));
    let all: u64 = lanes.iter().sum();
    let tasks = (0..count).map(|_| {
        let node = |n: usize, rng: &mut Rng| {
            let wcet = rng.within(1, 60_000) * 1_000;
            let bcet = if rng.chance(30) { wcet / 2 } else { 0 };
            let after = (0..n).filter(|_| rng.chance(40)).collect();
            Node { wcet, bcet, pool: rng.index(pools), after }
        };
        let nodes: Vec<Node> = (0..rng.within(1, 5) as usize).map(|n| node(n, rng)).collect();
        let work: u64 = nodes.iter().map(|node| node.wcet).sum();
        let period = (work * count * 100 / load / all).max(50_000_000) / 1_000 * 1_000;
        Task {
            deadline: period * rng.within(50, 130) / 100,
            period,
            value: rng.within(1, 3),
            cluster: None,
            nodes,
        }
    });
    let tasks = tasks.collect();
    Model { clusters: vec![Vec::new(); pools], lanes, tasks }
}

impl Model {
    /// The file.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for (p, lanes) in self.lanes.iter().enumerate() {
            writeln!(text, "[[pool]]\nname = \"p{p}\"\nlanes = {lanes}").unwrap();
            let clusters = self.clusters[p].iter();
            let clusters: Vec<String> =
                clusters.map(|(name, lanes)| format!("{{ name = \"{name}\", lanes = {lanes} }}")).collect();
            if !clusters.is_empty() {
                writeln!(text, "clusters = [{}]", clusters.join(", ")).unwrap();
            }
        }
        for (t, Task { deadline, period, value, cluster, nodes }) in self.tasks.iter().enumerate() {
            let head = format!("name = \"t{t}\"\ndeadline = \"{deadline}ns\"\nperiod = \"{period}ns\"");
            writeln!(text, "[[task]]\n{head}\nvalue = {value}").unwrap();
            if let Some(cluster) = cluster {
                writeln!(text, "cluster = \"{cluster}\"").unwrap();
            }
            for (n, Node { wcet, bcet, pool, after }) in nodes.iter().enumerate() {
                let after: Vec<String> = after.iter().map(|from| format!("\"n{from}\"")).collect();
                let after = after.join(", ");
                writeln!(
                    text,
                    "[[task.node]]\nname = \"n{n}\"\nwcet = \"{wcet}ns\"\nbcet = \"{bcet}ns\"\npool = \"p{pool}\"\nafter = [{after}]"
                )
                .unwrap();
            }
        }
        text
    }
}
