//! Are proofs true? What is proved of random sets, against the scheduler itself in worlds that are made to break it.

use super::drive::{Ends, World, play};
use super::sets::{Graph, uunifast};
use crate::rng::Rng;
use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use red_analysis::prove;
use red_certificate::{self as certificate, Certificate, Cluster, Guarantee, Set, Task, verify};
use red_core::{Capacity, Caps, Config, Dag, Duration, Empty, NodeId, PoolId, Scheduler, Timing, Wcet};

/// Room for a set: tasks, nodes, jobs, lanes, pools.
type Room = Caps<5, 8, 48, 8, 2>;

const LANES: [u32; 4] = [1, 2, 4, 8];
/// Sets of each row, for each seed that is run: a thousand over all rows.
const SETS_PER_SEED: u64 = 100;
/// Worlds that each set with a proof is run in.
const WORLDS: u64 = 10;
/// Jobs of a run.
const MOST_JOBS: usize = 60;
const NODES: (u64, u64) = (1, 8);
const EDGE: f64 = 0.3;
/// Costs are small, so that worst cases are hit: one in ten is of the second kind.
const COST_NS: (u64, u64) = (0, 9);
const HEAVY_NS: (u64, u64) = (10, 40);
const HEAVY: f64 = 0.1;
/// Work over lanes and period, all tasks together, in percent.
const LOAD_PERCENT: (u64, u64) = (5, 80);
/// Deadline over period where it is not between the longest path and the period, in percent.
const DEADLINE_PERCENT: (u64, u64) = (60, 250);

/// How lanes are shared out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Layout {
    /// One pool.
    Pool,
    /// Two clusters, each task in one of them.
    Clusters,
    /// Two pools, nodes anywhere.
    Pools,
}

impl Layout {
    const ALL: [Self; 3] = [Self::Pool, Self::Clusters, Self::Pools];

    const fn name(self) -> &'static str {
        match self {
            Self::Pool => "one pool",
            Self::Clusters => "two clusters",
            Self::Pools => "two pools",
        }
    }
}

/// What came of the sets of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Score {
    sets: u64,
    /// Sets all of whose tasks are proved.
    accepted: u64,
    /// Proofs that the verifier does not accept.
    rejected: u64,
    runs: u64,
    /// Jobs that were run, those of tasks without a proof among them.
    jobs: u64,
    /// Times that a task's longest response time in a run was just what is proved.
    exact: u64,
    /// Times that it was longer.
    above: u64,
    /// Jobs that were late or given up.
    missed: u64,
}

impl Score {
    fn add(&mut self, other: &Self) {
        self.sets += other.sets;
        self.accepted += other.accepted;
        self.rejected += other.rejected;
        self.runs += other.runs;
        self.jobs += other.jobs;
        self.exact += other.exact;
        self.above += other.above;
        self.missed += other.missed;
    }

    const fn violations(&self) -> u64 {
        self.rejected + self.above + self.missed
    }
}

fn draw(rng: &mut Rng, lanes: u32, layout: Layout) -> Set {
    let first = if lanes > 1 { rng.within(1, u64::from(lanes) - 1) as u32 } else { 1 };
    let cluster =
        |pool: &str, name: &str, lanes| Cluster { pool: pool.to_owned(), name: name.to_owned(), lanes };
    let clusters = match layout {
        Layout::Pool => vec![cluster("p", "p", lanes)],
        Layout::Clusters => vec![cluster("p", "a", first), cluster("p", "b", lanes - first)],
        Layout::Pools => vec![cluster("p", "p", first), cluster("q", "q", lanes - first)],
    };
    let count = rng.within(1, Room::TASKS as u64) as usize;
    let load = rng.within(LOAD_PERCENT.0, LOAD_PERCENT.1) as f64 / 100.0 * f64::from(lanes);
    let tasks = uunifast(rng, count, load).into_iter().enumerate().map(|(nth, share)| {
        let home = (layout != Layout::Pools).then(|| rng.within(0, clusters.len() as u64 - 1) as usize);
        let (graph, places) = graph(rng, clusters.len(), home);
        let longest = graph.longest();
        let period_ns = ((graph.work() as f64 / share) as u64).clamp(1, 1 << 40);
        let deadline_ns = match period_ns.checked_sub(longest) {
            Some(slack) if rng.chance(0.5) => longest + rng.within(0, slack),
            _ => period_ns * rng.within(DEADLINE_PERCENT.0, DEADLINE_PERCENT.1) / 100,
        };
        Task {
            name: format!("t{nth}"),
            deadline_ns: deadline_ns.max(1),
            period_ns: Some(period_ns),
            versions: vec![graph.to_prove(|node| places[node])],
            ..Task::default()
        }
    });
    let tasks = tasks.collect();
    Set { most_jobs: Room::JOBS as u64, clusters, tasks }
}

/// A graph, and the cluster of each node.
fn graph(rng: &mut Rng, clusters: usize, home: Option<usize>) -> (Graph, Vec<usize>) {
    let count = rng.within(NODES.0, NODES.1) as usize;
    let node = |_| {
        let (low, high) = if rng.chance(HEAVY) { HEAVY_NS } else { COST_NS };
        (rng.within(low, high), home.unwrap_or_else(|| rng.within(0, clusters as u64 - 1) as usize))
    };
    let (costs, places) = (0..count).map(node).unzip();
    let mut graph = Graph { costs, successors: vec![Vec::new(); count] };
    for to in 1..count {
        for from in 0..to {
            if rng.chance(EDGE) {
                graph.link(from, to);
            }
        }
    }
    (graph, places)
}

/// Runs a set once. Releases come together, a few nanoseconds apart or anywhere, on time or late; nodes take their WCET, or any
/// time up to it, or now and then none.
fn run_once(rng: &mut Rng, set: &Set) -> Option<Ends> {
    let mut scheduler: Box<Scheduler<Room>> = Box::new(Scheduler::EMPTY);
    let lanes = |cluster: &Cluster| u8::try_from(cluster.lanes).ok();
    let (first, others) = set.clusters.split_first()?;
    scheduler.configure(Config::REDRT.with_lanes(lanes(first)?));
    for cluster in others {
        scheduler.add_pool(lanes(cluster)?, None).ok()?;
    }
    let mut tasks = Vec::new();
    for task in &set.tasks {
        let timing = Timing::new(Duration::from_nanos(task.deadline_ns));
        // Values decide nothing where all is proved.
        let timing = timing.value(rng.within(1, 3) as u32);
        let timing = task.period_ns.map_or(timing, |period| timing.every(Duration::from_nanos(period)));
        tasks.push(scheduler.add_task(&dag(task.versions.first()?)?, timing).ok()?);
    }
    let releases = releases(rng, set);
    let (seed, kind) = (rng.bits(), rng.within(0, 2));
    let time = |task: usize, job: u64, node: usize| {
        let cost = set.tasks[task].versions[0].nodes[node].cost_ns;
        let rng = &mut Rng::of(&[seed, task as u64, job, node as u64]);
        match kind {
            0 => cost,
            1 => rng.within(0, cost),
            _ if rng.chance(0.2) => 0,
            _ => cost,
        }
    };
    Some(play(World { releases: &releases, time: &time, until_miss: false }, scheduler, tasks))
}

fn dag(graph: &certificate::Graph) -> Option<Dag<Room>> {
    let id = |node: usize| u8::try_from(node).ok().map(NodeId::new);
    let mut dag = Dag::new();
    for node in &graph.nodes {
        let pool = PoolId::new(u8::try_from(node.cluster).ok()?);
        dag.add_node(red_core::Node::new(Wcet::from_nanos(node.cost_ns)).in_pool(pool)).ok()?;
    }
    for (from, to) in &graph.edges {
        dag.add_edge(id(*from)?, id(*to)?).ok()?;
    }
    Some(dag)
}

fn releases(rng: &mut Rng, set: &Set) -> Vec<Vec<u64>> {
    let period = |task: &Task| task.period_ns.unwrap_or(1);
    let horizon = 3 * set.tasks.iter().map(period).max().unwrap_or(0);
    let (spread, is_late) = (rng.within(0, 2), rng.chance(0.5));
    let mut all = Vec::new();
    for (nth, task) in set.tasks.iter().enumerate() {
        let period = period(task);
        let mut at = rng.within(0, [0, 3, period][spread as usize]);
        for _ in 0..MOST_JOBS {
            all.push((at, nth));
            at += period + if is_late { rng.within(0, period / 2) } else { 0 };
            if at > horizon {
                break;
            }
        }
    }
    all.sort_unstable();
    let mut releases = vec![Vec::new(); set.tasks.len()];
    for (at, nth) in all.into_iter().take(MOST_JOBS) {
        releases[nth].push(at);
    }
    releases
}

/// Tries what a certificate says in so many worlds.
fn put_to_the_test(rng: &mut Rng, set: &Set, certificate: &Certificate, worlds: u64) -> Option<Score> {
    let mut score = Score { sets: 1, accepted: certificate.is_analytic().into(), ..Score::default() };
    if certificate.tasks.iter().all(|task| task.response_ns.is_none()) {
        return Some(score);
    }
    score.rejected += u64::from(verify(certificate, set).is_err());
    for _ in 0..worlds {
        let ends = run_once(rng, set)?;
        score.runs += 1;
        for ((proof, task), (longest, missed)) in certificate.tasks.iter().zip(&set.tasks).zip(&ends.by_task)
        {
            let Some(bound) = proof.response_ns else { continue };
            score.exact += u64::from(*longest == bound);
            // Ranks may go before keys for a task that has no proof and is tied to it, and jobs may be given up.
            let theirs = certificate.clusters.iter().filter(|cluster| cluster.tasks.contains(&task.name));
            if theirs.into_iter().all(|cluster| cluster.guarantee == Guarantee::Analytic) {
                score.above += u64::from(*longest > bound);
                score.missed += missed;
            }
        }
        score.jobs += ends.jobs;
    }
    Some(score)
}

fn score(lanes: u32, layout: Layout, seed: u64) -> Option<Score> {
    let mut score = Score::default();
    for nth in 0..SETS_PER_SEED {
        let rng = &mut Rng::of(&[u64::from(lanes), layout as u64, seed, nth]);
        let set = draw(rng, lanes, layout);
        score.add(&put_to_the_test(rng, &set, &prove(&set), WORLDS)?);
    }
    Some(score)
}

fn rows() -> Vec<(u32, Layout)> {
    let of = |lanes: u32| Layout::ALL.map(|layout| (lanes, layout));
    LANES.into_iter().flat_map(of).filter(|(lanes, layout)| *lanes > 1 || *layout == Layout::Pool).collect()
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let rows = rows();
    let cells: Vec<(usize, u64)> =
        (1..=run.seeds).flat_map(|seed| (0..rows.len()).map(move |row| (row, seed))).collect();
    let found = run.each(&cells, |(row, seed)| {
        let (lanes, layout) = rows[*row];
        score(lanes, layout, *seed).ok_or(PaperError::Capacity)
    })?;
    let mut scores = vec![Score::default(); rows.len()];
    for ((row, _), found) in cells.iter().zip(found) {
        scores[*row].add(&found);
    }
    let mut all = Score::default();
    scores.iter().for_each(|score| all.add(score));
    let line = |lanes: Cell, layout: &str, score: &Score| {
        let count = |count: u64| Cell::from(count as f64);
        vec![
            lanes,
            Cell::from(layout),
            count(score.sets),
            count(score.accepted),
            Cell::from(100.0 * score.accepted as f64 / score.sets.max(1) as f64),
            count(score.runs),
            count(score.jobs),
            count(score.exact),
            count(score.above),
            count(score.missed),
        ]
    };
    let mut lines: Vec<Vec<Cell>> = rows
        .iter()
        .zip(&scores)
        .map(|((lanes, layout), score)| line(Cell::from(f64::from(*lanes)), layout.name(), score))
        .collect();
    lines.push(line(Cell::from("all"), "", &all));
    let count = |name| Column::numbers(name, "", 0);
    Ok(Table {
        name: "admission-trial",
        title: "Are the proofs true? Random sets under the scheduler itself",
        source: "not in the paper",
        about: vec![
            format!(
                "One to {} tasks of {} to {} nodes, costs of {} to {} ns, one in ten up to {}; UUniFast, load {} to {} % of the \
                 lanes; deadlines between the longest path and 2.5 periods. Every set with a proof is run {WORLDS} times: released \
                 together, within 3 ns or anywhere, periodic or with gaps; nodes take their WCET, or any time up to it, or none \
                 one time in five.",
                Room::TASKS, NODES.0, NODES.1, COST_NS.0, COST_NS.1, HEAVY_NS.1, LOAD_PERCENT.0, LOAD_PERCENT.1,
            ),
            "`exact` counts how often a task took just what is proved: any smaller bound would be wrong there. A set is accepted \
             where all its tasks are proved; of others, what is proved is tried all the same where no task without a proof is tied to it. `redrt paper admission-trial \
             --seeds 1000` tries a million sets."
                .to_owned(),
        ],
        columns: vec![
            Column::numbers("rho", "", 0),
            Column::words("layout"),
            count("sets"),
            count("accepted"),
            Column::numbers("accepted", "%", 1),
            count("runs"),
            count("jobs"),
            count("exact"),
            count("above the bound"),
            count("misses"),
        ],
        rows: lines,
        claims: vec![Claim {
            claim: "no job of a task with a guarantee takes longer than proved, and the verifier accepts every proof".to_owned(),
            paper: "-".to_owned(),
            ours: format!("{} violations in {} sets", all.violations(), all.sets),
            verdict: if all.violations() == 0 { Verdict::Holds } else { Verdict::Fails },
            why: "",
        }],
    })
}

#[cfg(test)]
mod tests;
