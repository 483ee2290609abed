//! How many random sets each rule schedules, beside what no scheduler can.

use super::bound::is_possible;
use super::drive::{Case, World, releases};
use super::rules::{BASELINE, By, OURS, RULES};
use super::sets::{Family, Task, draw};
use crate::rng::Rng;
use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};

const LANES: [u8; 4] = [1, 2, 4, 8];
const DELTAS: [f64; 3] = [1.0, 0.6, 0.3];
const UTILISATIONS: [f64; 7] = [0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.98];
/// From here on shares of missed jobs are counted.
const LOADED: f64 = 0.8;
/// Sets for each point, for each seed that is run: 60 in all with 20 seeds.
const SETS_PER_SEED: u64 = 3;
/// Jobs of a run.
const MOST_JOBS: usize = 120;
/// Column of the table in which times vary.
const VARYING: usize = 3;
/// Shortest execution where times vary, in percent of the WCET.
const VARYING_FROM: u64 = 50;

/// What the product is held to, as shares of the necessary bound.
const MUST: [(f64, f64); 2] = [(0.3, 0.93), (0.6, 0.98)];

/// What rules that do not preempt are called.
const WHOLE: &str = ", non-preemptive";
/// What the paper's own rules are called.
const PAPERS: &str = "paper";

/// One point: a family on so many lanes, with these deadlines and execution times.
#[derive(Clone, Copy)]
struct Point {
    family: Family,
    lanes: u8,
    delta: f64,
    is_varying: bool,
}

/// Sums over the sets of a point.
#[derive(Clone, Copy, Default)]
struct Score {
    /// Utilisations of the sets that were scheduled.
    accepted: f64,
    missed: u64,
    jobs: u64,
}

/// Scores of the bound, and of each rule.
#[derive(Clone, Default)]
struct Scores {
    /// Utilisations of all sets.
    all: f64,
    possible: f64,
    rules: Vec<Score>,
}

impl Scores {
    fn acceptance(&self, rule: usize) -> f64 {
        self.rules[rule].accepted / self.all
    }

    /// Percent of jobs.
    fn missed(&self, rule: usize) -> f64 {
        let Score { missed, jobs, .. } = self.rules[rule];
        100.0 * missed as f64 / jobs.max(1) as f64
    }

    fn bound(&self) -> f64 {
        self.possible / self.all
    }
}

fn points() -> Vec<Point> {
    let mut points = Vec::new();
    for lanes in LANES {
        for family in Family::ALL {
            points.extend(DELTAS.map(|delta| Point { family, lanes, delta, is_varying: false }));
            points.push(Point { family, lanes, delta: 0.3, is_varying: true });
        }
    }
    points
}

/// The sets of one point and one utilisation.
fn score(point: &Point, utilisation: f64, sets: u64) -> Option<Scores> {
    let mut scores = Scores { rules: vec![Score::default(); RULES.len()], ..Scores::default() };
    for nth in 0..sets {
        // The same graphs for every deadline.
        let words = [point.family as u64, point.lanes.into(), (utilisation * 100.0).round() as u64, nth];
        let rng = &mut Rng::of(&words);
        let tasks = draw(rng, point.family, point.lanes.into(), utilisation, point.delta);
        let releases = releases(&tasks, rng, MOST_JOBS);
        let time = |task: usize, job: u64, node: usize| time(point, &tasks, &words, task, job, node);
        let best_percent = if point.is_varying { VARYING_FROM } else { 100 };
        let until_miss = utilisation < LOADED;
        let world = World { releases: &releases, time: &time, until_miss };
        let case = Case { tasks: &tasks, best_percent, world };
        scores.all += utilisation;
        if is_possible(&tasks, &releases, point.lanes.into()) {
            scores.possible += utilisation;
        }
        for (rule, score) in RULES.iter().zip(&mut scores.rules) {
            let ends = rule.run(&case, point.lanes)?;
            score.accepted += if ends.missed == 0 { utilisation } else { 0.0 };
            if !until_miss {
                score.missed += ends.missed;
                score.jobs += ends.jobs;
            }
        }
    }
    Some(scores)
}

fn time(point: &Point, tasks: &[Task], words: &[u64; 4], task: usize, job: u64, node: usize) -> u64 {
    let cost = tasks[task].graph.costs[node];
    if !point.is_varying {
        return cost;
    }
    let percent = Rng::of(&[words[2], words[3], task as u64, job, node as u64]).within(VARYING_FROM, 100);
    (cost * percent / 100).max(1)
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let points = points();
    let cells: Vec<(usize, f64)> =
        (0..points.len()).flat_map(|point| UTILISATIONS.map(|u| (point, u))).collect();
    let found = run.each(&cells, |(point, u)| {
        score(&points[*point], *u, SETS_PER_SEED * run.seeds).ok_or(PaperError::Capacity)
    })?;
    let mut scores = vec![Scores::default(); points.len()];
    for ((point, _), found) in cells.iter().zip(&found) {
        scores[*point].add(found);
    }
    // Losses at one utilisation would be hidden by gains at another.
    let each: Vec<(u8, &Scores)> =
        cells.iter().zip(&found).map(|((point, _), found)| (points[*point].lanes, found)).collect();
    let of = |delta: f64, is_varying: bool, lanes: Option<u8>| -> Vec<&Scores> {
        let chosen = |p: &Point| {
            p.delta == delta && p.is_varying == is_varying && lanes.is_none_or(|lanes| p.lanes == lanes)
        };
        points.iter().zip(&scores).filter(|(p, _)| chosen(p)).map(|(_, s)| s).collect()
    };
    let columns: Vec<Vec<&Scores>> = [(1.0, false), (0.6, false), (0.3, false), (0.3, true)]
        .into_iter()
        .map(|(delta, varying)| of(delta, varying, None))
        .chain(LANES.map(|lanes| of(0.3, false, Some(lanes))))
        .collect();
    let mean = |of: &[&Scores], value: &dyn Fn(&Scores) -> f64| {
        of.iter().map(|scores| value(scores)).sum::<f64>() / of.len() as f64
    };
    let mut rows = vec![
        ["necessary bound".into()]
            .into_iter()
            .chain(columns.iter().enumerate().flat_map(|(nth, of)| {
                // It is reckoned at WCET, so it bounds nothing where times vary.
                let bound = Cell::from((nth != VARYING).then(|| mean(of, &Scores::bound)));
                [bound].into_iter().chain((nth < 4).then(|| Cell::from(None::<f64>)))
            }))
            .collect::<Vec<Cell>>(),
    ];
    for (nth, rule) in RULES.iter().enumerate() {
        let missed = |scores: &Scores| scores.missed(nth);
        let is_run = scores.iter().any(|scores| scores.rules[nth].jobs > 0);
        let cells = columns.iter().enumerate().flat_map(|(column, of)| {
            let accepted = Cell::from(mean(of, &|scores| scores.acceptance(nth)));
            let missed = || Cell::from(is_run.then(|| mean(of, &missed)));
            [accepted].into_iter().chain((column < 4).then(missed))
        });
        rows.push([Cell::from(rule.name)].into_iter().chain(cells).collect());
    }
    let numbers = |name| Column::numbers(name, "", 3);
    let missed = |name| Column::numbers(name, "%", 1);
    Ok(Table {
        name: "acceptance",
        title: "Random DAG sets: how many each rule schedules",
        source: "not in the paper",
        about: vec![
            format!(
                "{} sets for each point: rho + 2 tasks, layered or Erdos-Renyi graphs of 8 to 30 nodes, a tenth of them four times \
                 as heavy, UUniFast, D = L + delta (T - L), random offsets, three of the longest periods, at most \
                 {MOST_JOBS} jobs. Acceptance is weighted by utilisation ({} to {}) and averaged over rho = 1, 2, 4, 8 and both \
                 families; misses are shares of jobs from utilisation {LOADED} on.",
                SETS_PER_SEED * run.seeds,
                UTILISATIONS[0],
                UTILISATIONS[UTILISATIONS.len() - 1],
            ),
            "The necessary bound says what no scheduler can do, and not what some could. Where times vary they are uniform \
             from half of the WCET to all of it."
                .to_owned(),
        ],
        columns: vec![
            Column::words("rule"),
            numbers("delta 1"),
            missed("misses"),
            numbers("delta .6"),
            missed("misses"),
            numbers("delta .3"),
            missed("misses"),
            numbers("delta .3, times vary"),
            missed("misses"),
            numbers("delta .3, rho 1"),
            numbers("rho 2"),
            numbers("rho 4"),
            numbers("rho 8"),
        ],
        rows,
        claims: claims(&points, &scores, &each),
    })
}

impl Scores {
    fn add(&mut self, other: &Self) {
        self.all += other.all;
        self.possible += other.possible;
        self.rules.resize(RULES.len(), Score::default());
        for (mine, theirs) in self.rules.iter_mut().zip(&other.rules) {
            mine.accepted += theirs.accepted;
            mine.missed += theirs.missed;
            mine.jobs += theirs.jobs;
        }
    }
}

fn claims(points: &[Point], scores: &[Scores], each: &[(u8, &Scores)]) -> Vec<Claim> {
    let rule = |name: &str| RULES.iter().position(|rule| rule.name == name).unwrap_or(0);
    let ours = rule(OURS);
    let mut claims = Vec::new();
    for (delta, must) in MUST {
        let of: Vec<&Scores> = points
            .iter()
            .zip(scores)
            .filter(|(point, _)| point.delta == delta && !point.is_varying)
            .map(|(_, scores)| scores)
            .collect();
        let sum = |value: &dyn Fn(&Scores) -> f64| of.iter().map(|scores| value(scores)).sum::<f64>();
        let share = sum(&|scores| scores.acceptance(ours)) / sum(&Scores::bound);
        claims.push(Claim {
            claim: format!("{OURS} schedules at least {must} of the necessary bound at delta {delta}"),
            paper: "-".to_owned(),
            ours: format!("{share:.3}"),
            verdict: if share >= must { Verdict::Holds } else { Verdict::Fails },
            why: "",
        });
    }
    let is_job_edf = |name: &str| name == BASELINE || name == format!("{BASELINE}{WHOLE}");
    for (nth, of) in RULES.iter().enumerate() {
        if matches!(of.by, By::Scheduler(_)) && !of.name.starts_with(PAPERS) && !is_job_edf(of.name) {
            let baseline =
                if of.name.ends_with(WHOLE) { format!("{BASELINE}{WHOLE}") } else { BASELINE.to_owned() };
            claims.push(beside(each, (of.name, nth), (&baseline, rule(&baseline))));
        }
    }
    claims
}

/// Where a rule of ours schedules less than job-EDF, or misses more: on how many lanes, and by how much.
fn beside(each: &[(u8, &Scores)], ours: (&str, usize), baseline: (&str, usize)) -> Claim {
    let worse = |by: &dyn Fn(&Scores) -> f64| -> Vec<(u8, f64)> {
        each.iter().map(|(lanes, scores)| (*lanes, by(scores))).filter(|(_, by)| *by > 0.0).collect()
    };
    let below = worse(&|scores| scores.acceptance(baseline.1) - scores.acceptance(ours.1));
    let late = worse(&|scores| scores.missed(ours.1) - scores.missed(baseline.1));
    let words = |of: &[(u8, f64)], unit: &str, decimals: usize| {
        let mut lanes: Vec<String> = of.iter().map(|(lanes, _)| lanes.to_string()).collect();
        lanes.dedup();
        let most = of.iter().map(|(_, by)| *by).fold(0.0, f64::max);
        let (count, all, lanes) = (of.len(), each.len(), lanes.join(", "));
        format!("at {count} of {all} points, rho {lanes}, by {most:.decimals$}{unit} at most")
    };
    let found: Vec<String> = [
        (!below.is_empty()).then(|| format!("below {}", words(&below, "", 3))),
        (!late.is_empty()).then(|| format!("more misses {}", words(&late, " % of jobs", 1))),
    ]
    .into_iter()
    .flatten()
    .collect();
    let is_kept = found.is_empty();
    Claim {
        claim: format!("{} is nowhere below {}, and nowhere misses more", ours.0, baseline.0),
        paper: "-".to_owned(),
        ours: if is_kept { format!("at none of {} points", each.len()) } else { found.join("; ") },
        verdict: if is_kept { Verdict::Holds } else { Verdict::Loses },
        why: if is_kept { "" } else { WORK },
    }
}

const WORK: &str = "where work decides, and not the path after a node, the order of deadlines is the better one, most of all on one \
                    lane (Jackson 1955), and under overload what is spent on jobs that miss is lost; a point is one family, \
                    rho, delta and utilisation";
