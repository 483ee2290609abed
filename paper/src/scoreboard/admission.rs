//! How many random sets are proved before they run, and how many of the others could have run.

use super::drive::{Case, World, drive, releases};
use super::federated;
use super::rules::REDRT;
use super::sets::{Family, Task, draw};
use crate::rng::Rng;
use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use red_analysis::{divide, prove};
use red_certificate::{self as certificate, Cluster, Set};
use red_core::Config;

const LANES: [u8; 4] = [1, 2, 4, 8];
const DELTAS: [f64; 3] = [1.0, 0.6, 0.3];
const UTILISATIONS: [f64; 4] = [0.2, 0.4, 0.6, 0.8];
/// Jobs that the scheduler has room for.
const MOST_JOBS: u64 = 64;
/// Runs that a set has to survive to count as one that may be schedulable.
const RUNS: usize = 6;
/// Jobs of a run.
const RUN_JOBS: usize = 120;
const CONFIG: Config = Config { preempt: false, ..REDRT };

/// Who accepts a set.
#[derive(Clone, Copy, Debug, Default)]
struct Score {
    sets: u64,
    federated: u64,
    together: u64,
    divided: u64,
    simulated: u64,
    /// Sets that are proved, and have a miss all the same.
    violations: u64,
}

impl Score {
    fn add(&mut self, other: &Self) {
        self.sets += other.sets;
        self.federated += other.federated;
        self.together += other.together;
        self.divided += other.divided;
        self.simulated += other.simulated;
        self.violations += other.violations;
    }
}

fn set(tasks: &[Task], lanes: u8) -> Set {
    let task = |(nth, task): (usize, &Task)| certificate::Task {
        name: format!("t{nth}"),
        deadline_ns: task.deadline_ns,
        period_ns: Some(task.period_ns),
        versions: vec![graph(task)],
        ..certificate::Task::default()
    };
    let cluster = Cluster { pool: "p".to_owned(), name: "p".to_owned(), lanes: lanes.into() };
    Set { most_jobs: MOST_JOBS, clusters: vec![cluster], tasks: tasks.iter().enumerate().map(task).collect() }
}

fn graph(task: &Task) -> certificate::Graph {
    let node =
        |(n, cost): (usize, &u64)| certificate::Node { name: format!("n{n}"), cost_ns: *cost, cluster: 0 };
    let successors = task.graph.successors.iter().enumerate();
    certificate::Graph {
        nodes: task.graph.costs.iter().enumerate().map(node).collect(),
        edges: successors.flat_map(|(from, to)| to.iter().map(move |to| (from, *to))).collect(),
    }
}

fn score(lanes: u8, delta: f64, utilisation: f64, seed: u64) -> Option<Score> {
    let mut score = Score::default();
    for family in Family::ALL {
        let words = [family as u64, lanes.into(), (utilisation * 100.0).round() as u64, seed];
        let rng = &mut Rng::of(&words);
        let tasks = draw(rng, family, lanes.into(), utilisation, delta);
        let mut misses = false;
        for _ in 0..RUNS {
            let releases = releases(&tasks, rng, RUN_JOBS);
            let time = |task: usize, _: u64, node: usize| tasks[task].graph.costs[node];
            let world = World { releases: &releases, time: &time, until_miss: true };
            let case = Case { tasks: &tasks, best_percent: 100, world };
            misses |= drive(&case, CONFIG.with_lanes(lanes))?.missed > 0;
        }
        let set = set(&tasks, lanes);
        let together = prove(&set);
        let is_divided = || divide(&set, &together).is_some_and(|(_, proved)| proved.is_analytic());
        score.sets += 1;
        score.federated += u64::from(federated::is_proved(&tasks, lanes.into()));
        score.together += u64::from(together.is_analytic());
        score.divided += u64::from(together.is_analytic() || is_divided());
        score.simulated += u64::from(!misses);
        score.violations += u64::from(together.is_analytic() && misses);
    }
    Some(score)
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let rows: Vec<(u8, f64)> =
        LANES.into_iter().flat_map(|lanes| DELTAS.map(|delta| (lanes, delta))).collect();
    let points = rows.iter().flat_map(|row| UTILISATIONS.map(|u| (*row, u)));
    let cells: Vec<((u8, f64), f64, u64)> =
        points.flat_map(|(row, u)| (1..=run.seeds).map(move |seed| (row, u, seed))).collect();
    let found = run.each(&cells, |((lanes, delta), utilisation, seed)| {
        score(*lanes, *delta, *utilisation, *seed).ok_or(PaperError::Capacity)
    })?;
    let sum = |chosen: &dyn Fn((u8, f64), f64) -> bool| {
        let mut sum = Score::default();
        let of = cells.iter().zip(&found).filter(|((row, u, _), _)| chosen(*row, *u));
        of.for_each(|(_, score)| sum.add(score));
        sum
    };
    let share = |part: u64, all: &Score| Cell::from(part as f64 / all.sets.max(1) as f64);
    let line = |row: (u8, f64)| {
        let all = sum(&|r, _| r == row);
        let at = |utilisation| {
            let score = sum(&|r, u| r == row && u == utilisation);
            share(score.divided, &score)
        };
        [Cell::from(f64::from(row.0)), Cell::from(row.1)]
            .into_iter()
            .chain([all.federated, all.together, all.divided, all.simulated].map(|part| share(part, &all)))
            .chain(UTILISATIONS.map(at))
            .collect()
    };
    let lines = rows.iter().map(|row| line(*row)).collect();
    let all = sum(&|_, _| true);
    let numbers = |name| Column::numbers(name, "", 3);
    Ok(Table {
        name: "admission",
        title: "Random DAG sets: how many are proved before they run",
        source: "not in the paper",
        about: vec![
            format!(
                "The sets of `acceptance`, {} of each row: non-preemptive, sporadic, WCETs. Federated scheduling gives lanes to \
                 heavy tasks, and runs the others preemptively; `together` proves the pool as it is, `clusters` as `redrt plan` would divide it; `no miss` have \
                 none in {RUNS} runs of random offsets: no proof, and more than can be proved.",
                all.sets / rows.len() as u64,
            ),
            "The last columns are `clusters` by utilisation.".to_owned(),
        ],
        columns: vec![
            Column::numbers("rho", "", 0),
            Column::numbers("delta", "", 1),
            numbers("federated, preemptive"),
            numbers("together"),
            numbers("clusters"),
            numbers("no miss"),
            numbers("u .2"),
            numbers("u .4"),
            numbers("u .6"),
            numbers("u .8"),
        ],
        rows: lines,
        claims: vec![
            Claim {
                claim: "no set that is proved as it is has a miss".to_owned(),
                paper: "-".to_owned(),
                ours: format!("{} of {} sets", all.violations, all.together),
                verdict: if all.violations == 0 { Verdict::Holds } else { Verdict::Fails },
                why: "",
            },
            Claim {
                claim: "clusters prove more than federated scheduling in all, without preempting".to_owned(),
                paper: "-".to_owned(),
                ours: format!("{} against {} of {} sets", all.divided, all.federated, all.sets),
                verdict: if all.divided > all.federated { Verdict::Holds } else { Verdict::Fails },
                why: "",
            },
        ],
    })
}
