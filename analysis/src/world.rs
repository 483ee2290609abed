//! What tests need: random sets, and a simulator of what the proofs assume of a dispatcher.

use red_certificate::{Cluster, Graph, Node, Set, Task};

/// SplitMix64.
pub(crate) struct Rng(pub(crate) u64);

impl Rng {
    pub(crate) fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn within(&mut self, low: u64, high: u64) -> u64 {
        low + self.bits() % (high - low + 1)
    }
}

/// A task in cluster 0.
pub(crate) fn task(
    name: &str,
    deadline_ns: u64,
    period_ns: Option<u64>,
    costs: &[u64],
    edges: &[(usize, usize)],
) -> Task {
    let versions = vec![graph(costs, edges)];
    Task { name: name.to_owned(), deadline_ns, period_ns, versions, ..Task::default() }
}

/// A graph in cluster 0.
pub(crate) fn graph(costs: &[u64], edges: &[(usize, usize)]) -> Graph {
    let node = |(n, cost): (usize, &u64)| Node { name: format!("n{n}"), cost_ns: *cost, cluster: 0 };
    Graph { nodes: costs.iter().enumerate().map(node).collect(), edges: edges.to_vec() }
}

/// Tasks on one cluster of so many lanes.
pub(crate) fn set(lanes: u32, tasks: Vec<Task>) -> Set {
    Set {
        most_jobs: 64,
        clusters: vec![Cluster { pool: "gpu".to_owned(), name: "gpu".to_owned(), lanes }],
        tasks,
    }
}

/// A random set of small numbers, in which worst cases are hit often. `most_deadline`: D over T at most, in percent.
pub(crate) fn random(rng: &mut Rng, clusters: usize, load_percent: u64, most_deadline: u64) -> Set {
    let clusters: Vec<Cluster> = (0..clusters)
        .map(|c| Cluster { pool: format!("p{c}"), name: format!("p{c}"), lanes: rng.within(1, 3) as u32 })
        .collect();
    let count = rng.within(2, 4);
    let lanes: u64 = clusters.iter().map(|c| u64::from(c.lanes)).sum();
    let tasks = (0..count)
        .map(|t| {
            let mut new = task(&format!("t{t}"), 0, None, &[], &[]);
            let versions = if rng.within(0, 2) == 0 { 2 } else { 1 };
            new.versions = (0..versions).map(|_| random_graph(rng, clusters.len())).collect();
            let work = |graph: &Graph| graph.nodes.iter().map(|node| node.cost_ns).sum::<u64>().max(1);
            let work = new.versions.iter().map(work).max().unwrap_or(1);
            let period = (work * count * 100).div_ceil(load_percent * lanes) * rng.within(50, 150) / 100;
            new.period_ns = Some(period.max(1));
            new.deadline_ns = (period * rng.within(60, most_deadline) / 100).max(1);
            new
        })
        .collect();
    Set { most_jobs: 1_000, clusters, tasks }
}

fn random_graph(rng: &mut Rng, clusters: usize) -> Graph {
    let nodes = rng.within(1, 7) as usize;
    let mut graph = graph(&vec![0; nodes], &[]);
    for node in &mut graph.nodes {
        node.cost_ns = if rng.within(0, 9) == 0 { 20 } else { rng.within(0, 9) };
        node.cluster = rng.within(0, clusters as u64 - 1) as usize;
    }
    for to in 1..nodes {
        for from in 0..to {
            if rng.within(0, 3) == 0 {
                graph.edges.push((from, to));
            }
        }
    }
    graph
}

/// A node of a job on its way.
#[derive(Clone)]
struct Piece {
    waits_for: usize,
    time: u64,
    state: State,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Waiting,
    Runs { until: u64 },
    Done,
}

struct Job<'a> {
    task: usize,
    graph: &'a Graph,
    keys: &'a [i128],
    release: u64,
    pieces: Vec<Piece>,
    is_cut: bool,
}

/// Longest response time of each task in a random run; jobs of tasks that are not in `kept` are given up when they are late.
pub(crate) fn responses(rng: &mut Rng, set: &Set, kept: &[bool]) -> Vec<u64> {
    let horizon = 6 * set.tasks.iter().filter_map(|t| t.period_ns).max().unwrap_or(1);
    let (together, gaps, times) = (rng.within(0, 2) == 0, rng.within(0, 1) == 0, rng.within(0, 3));
    let mut releases = Vec::new();
    for (t, task) in set.tasks.iter().enumerate() {
        let period = task.period_ns.unwrap_or(horizon);
        let mut at = if together { 0 } else { rng.within(0, period) };
        while at < horizon {
            releases.push((at, t));
            at += period + if gaps { rng.within(0, period / 2) } else { 0 };
        }
    }
    releases.sort_unstable();
    let keys: Vec<Vec<Vec<i128>>> = set.tasks.iter().map(keys).collect();
    let mut worst = vec![0; set.tasks.len()];
    let mut jobs: Vec<Job<'_>> = Vec::new();
    let mut next = 0;
    let mut now = 0;
    loop {
        // Everything of an instant before anything begins.
        for job in &mut jobs {
            for n in 0..job.pieces.len() {
                if job.pieces[n].state == (State::Runs { until: now }) {
                    job.pieces[n].state = State::Done;
                    for (_, to) in job.graph.edges.iter().filter(|(from, _)| *from == n) {
                        job.pieces[*to].waits_for -= 1;
                    }
                }
            }
        }
        while next < releases.len() && releases[next].0 == now {
            let (release, t) = releases[next];
            next += 1;
            // A proof knows nothing of which graph comes when.
            let version = rng.within(0, set.tasks[t].versions.len() as u64 - 1) as usize;
            let graph = &set.tasks[t].versions[version];
            let piece = |(n, node): (usize, &Node)| Piece {
                waits_for: graph.edges.iter().filter(|(_, to)| *to == n).count(),
                time: match times {
                    0 => node.cost_ns,
                    1 => rng.within(0, node.cost_ns),
                    _ => {
                        if rng.within(0, 4) == 0 {
                            0
                        } else {
                            node.cost_ns
                        }
                    }
                },
                state: State::Waiting,
            };
            let pieces = graph.nodes.iter().enumerate().map(piece).collect();
            jobs.push(Job { task: t, graph, keys: &keys[t][version], release, pieces, is_cut: false });
        }
        let mut again = true;
        while again {
            again = false;
            for job in &mut jobs {
                job.is_cut |= !kept[job.task] && now > job.release + set.tasks[job.task].deadline_ns;
            }
            for (c, cluster) in set.clusters.iter().enumerate() {
                let here = |job: &Job<'_>, n: usize| job.graph.nodes[n].cluster == c;
                let busy = jobs
                    .iter()
                    .map(|job| {
                        (0..job.pieces.len())
                            .filter(|n| here(job, *n) && matches!(job.pieces[*n].state, State::Runs { .. }))
                            .count()
                    })
                    .sum::<usize>();
                let mut free = cluster.lanes as usize - busy;
                while free > 0 {
                    let mut first: Option<(i128, usize, usize)> = None;
                    for (j, job) in jobs.iter().enumerate().filter(|(_, job)| !job.is_cut) {
                        for n in 0..job.pieces.len() {
                            let piece = &job.pieces[n];
                            if here(job, n) && piece.state == State::Waiting && piece.waits_for == 0 {
                                let key = (i128::from(job.release) + job.keys[n], j, n);
                                first = Some(first.map_or(key, |first| first.min(key)));
                            }
                        }
                    }
                    let Some((_, j, n)) = first else { break };
                    let time = jobs[j].pieces[n].time;
                    jobs[j].pieces[n].state = State::Runs { until: now + time };
                    if time == 0 {
                        // It ends in this instant, and what it frees begins in it.
                        jobs[j].pieces[n].state = State::Done;
                        let graph = jobs[j].graph;
                        for (_, to) in graph.edges.iter().filter(|(from, _)| *from == n) {
                            jobs[j].pieces[*to].waits_for -= 1;
                        }
                        again = true;
                    } else {
                        free -= 1;
                    }
                }
            }
        }
        jobs.retain(|job| {
            let is_done = job.pieces.iter().all(|piece| piece.state == State::Done);
            if is_done {
                worst[job.task] = worst[job.task].max(now - job.release);
            }
            let runs = job.pieces.iter().any(|piece| matches!(piece.state, State::Runs { .. }));
            !is_done && (!job.is_cut || runs)
        });
        let ends = jobs.iter().flat_map(|job| &job.pieces).filter_map(|piece| match piece.state {
            State::Runs { until } => Some(until),
            _ => None,
        });
        let release = releases.get(next).map(|(at, _)| *at);
        match ends.chain(release).min() {
            Some(at) => now = at,
            None => return worst,
        }
    }
}

/// D - tail - c of each node of each graph.
fn keys(task: &Task) -> Vec<Vec<i128>> {
    let of = |graph: &Graph| {
        let mut tails = vec![0; graph.nodes.len()];
        // Edges of random sets lead from lower to higher numbers.
        for n in (0..graph.nodes.len()).rev() {
            let after = graph.edges.iter().filter(|(from, _)| *from == n);
            let longest = after.map(|(_, to)| tails[*to] + i128::from(graph.nodes[*to].cost_ns)).max();
            tails[n] = longest.unwrap_or(0);
        }
        let key =
            |(n, node): (usize, &Node)| i128::from(task.deadline_ns) - tails[n] - i128::from(node.cost_ns);
        graph.nodes.iter().enumerate().map(key).collect()
    };
    task.versions.iter().map(of).collect()
}
