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
#[derive(Clone, Copy, Debug)]
struct Found {
    federated: bool,
    together: bool,
    divided: bool,
    /// No run had a miss.
    simulated: bool,
}

fn set(tasks: &[Task], lanes: u8) -> Set {
    let task = |(nth, task): (usize, &Task)| certificate::Task {
        name: format!("t{nth}"),
        deadline_ns: task.deadline_ns,
        period_ns: Some(task.period_ns),
        versions: vec![task.graph.to_prove(|_| 0)],
        ..certificate::Task::default()
    };
    let cluster = Cluster { pool: "p".to_owned(), name: "p".to_owned(), lanes: lanes.into() };
    Set { most_jobs: MOST_JOBS, clusters: vec![cluster], tasks: tasks.iter().enumerate().map(task).collect() }
}

/// A set of each family.
fn found(lanes: u8, delta: f64, utilisation: f64, seed: u64) -> Option<Vec<Found>> {
    let one = |family: Family| {
        let words = [family as u64, lanes.into(), (utilisation * 100.0).round() as u64, seed];
        let rng = &mut Rng::of(&words);
        let tasks = draw(rng, family, lanes.into(), utilisation, delta);
        let time = |task: usize, _: u64, node: usize| tasks[task].graph.costs[node];
        let mut simulated = true;
        for _ in 0..RUNS {
            let releases = releases(&tasks, rng, RUN_JOBS);
            let world = World { releases: &releases, time: &time, until_miss: true };
            let case = Case { tasks: &tasks, best_percent: 100, world };
            simulated &= drive(&case, CONFIG.with_lanes(lanes))?.missed == 0;
        }
        let set = set(&tasks, lanes);
        let proved = prove(&set);
        let together = proved.is_analytic();
        Some(Found {
            federated: federated::is_proved(&tasks, lanes.into()),
            together,
            divided: together
                || divide(&set, &proved, |_, _| true).is_some_and(|(_, proved)| proved.is_analytic()),
            simulated,
        })
    };
    Family::ALL.into_iter().map(one).collect()
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let rows: Vec<(u8, f64)> =
        LANES.into_iter().flat_map(|lanes| DELTAS.map(|delta| (lanes, delta))).collect();
    let points = rows.iter().flat_map(|row| UTILISATIONS.map(|u| (*row, u)));
    let cells: Vec<((u8, f64), f64, u64)> =
        points.flat_map(|(row, u)| (1..=run.seeds).map(move |seed| (row, u, seed))).collect();
    let sets = run.each(&cells, |((lanes, delta), utilisation, seed)| {
        found(*lanes, *delta, *utilisation, *seed).ok_or(PaperError::Capacity)
    })?;
    let of = |chosen: &dyn Fn((u8, f64), f64) -> bool| -> Vec<Found> {
        let cells = cells.iter().zip(&sets).filter(|((row, u, _), _)| chosen(*row, *u));
        cells.flat_map(|(_, sets)| sets).copied().collect()
    };
    let count = |sets: &[Found], is: &dyn Fn(&Found) -> bool| sets.iter().filter(|set| is(set)).count();
    let share = |sets: &[Found], is: &dyn Fn(&Found) -> bool| {
        Cell::from(count(sets, is) as f64 / sets.len().max(1) as f64)
    };
    let line = |row: (u8, f64)| {
        let sets = of(&|r, _| r == row);
        let at = |utilisation| share(&of(&|r, u| r == row && u == utilisation), &|set| set.divided);
        [Cell::from(f64::from(row.0)), Cell::from(row.1)]
            .into_iter()
            .chain([
                share(&sets, &|set| set.federated),
                share(&sets, &|set| set.together),
                share(&sets, &|set| set.divided),
                share(&sets, &|set| set.simulated),
            ])
            .chain(UTILISATIONS.map(at))
            .collect()
    };
    let lines = rows.iter().map(|row| line(*row)).collect();
    let all = of(&|_, _| true);
    let [federated, together, divided] = [
        count(&all, &|set| set.federated),
        count(&all, &|set| set.together),
        count(&all, &|set| set.divided),
    ];
    let violations = count(&all, &|set| set.together && !set.simulated);
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
                all.len() / rows.len(),
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
                ours: format!("{violations} of {together} sets"),
                verdict: if violations == 0 { Verdict::Holds } else { Verdict::Fails },
                why: "",
            },
            Claim {
                claim: "clusters prove more than federated scheduling in all, without preempting".to_owned(),
                paper: "-".to_owned(),
                ours: format!("{divided} against {federated} of {} sets", all.len()),
                verdict: if divided > federated { Verdict::Holds } else { Verdict::Fails },
                why: "",
            },
        ],
    })
}
