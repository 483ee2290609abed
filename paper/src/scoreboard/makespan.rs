//! One graph whose optimum is known, because it was cut out of a schedule without idle time.

use super::drive::{Case, World, drive};
use super::rules::{BASELINE, JOB_EDF, LATEST_START, LEVEL_SUM, OURS, REDRT, by_rule};
use super::sets::{Graph, Task};
use crate::rng::Rng;
use crate::run::{PaperError, Run};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use red_core::{Config, DeadlineRule, Gate};

/// Nodes of a graph.
const NODES: usize = 100;
const EDGES: [usize; 2] = [150, 600];
const LANES: [u8; 3] = [2, 4, 8];
/// Length of the schedule that graphs are cut out of, in nanoseconds.
const OPTIMUM_NS: u64 = 10_000_000;
/// Graphs of each kind, for each seed that is run: 200 in all with 20 seeds.
const GRAPHS_PER_SEED: u64 = 10;
/// What ours is held to, by lanes: mean makespan over the optimum.
const MUST: [f64; 3] = [1.005, 1.005, 1.015];

const fn whole(config: Config) -> Config {
    Config { preempt: false, ..config }
}

const RULES: [(&str, Config); 8] = [
    ("paper: level-sum, level gate", whole(Config { gate: Gate::Level, ..LEVEL_SUM })),
    ("level-sum", whole(LEVEL_SUM)),
    (BASELINE, whole(JOB_EDF)),
    ("path-proportional", whole(by_rule(DeadlineRule::PathProportional))),
    ("latest finish", whole(by_rule(DeadlineRule::LatestFinish))),
    ("latest start, level gate", whole(Config { gate: Gate::Level, ..LATEST_START })),
    (OURS, whole(REDRT)),
    ("REDRT lookahead", whole(Config { gate: Gate::Lookahead, ..REDRT })),
];

/// Cuts a schedule of [`OPTIMUM_NS`] on so many lanes into nodes, and keeps so many of the edges that it obeys.
fn cut(rng: &mut Rng, lanes: usize, edges: usize) -> Graph {
    let mut slices = Vec::new();
    for lane in 0..lanes {
        let count = (lane + 1) * NODES / lanes - lane * NODES / lanes;
        let mut cuts: Vec<u64> = (1..count).map(|_| rng.within(1, OPTIMUM_NS - 1)).collect();
        cuts.extend([0, OPTIMUM_NS]);
        cuts.sort_unstable();
        slices.extend(cuts.windows(2).map(|ends| (ends[0], ends[1])));
    }
    // Edges lead from lower to higher numbers.
    slices.sort_unstable();
    let costs: Vec<u64> = slices.iter().map(|(start, end)| end - start).collect();
    let mut graph = Graph { successors: vec![Vec::new(); costs.len()], costs };
    let mut possible = Vec::new();
    for (from, (_, end)) in slices.iter().enumerate() {
        let later = slices.iter().enumerate().skip(from + 1).filter(|(_, (start, _))| start >= end);
        possible.extend(later.map(|(to, _)| (from, to)));
    }
    for nth in 0..edges.min(possible.len()) {
        let chosen = rng.within(nth as u64, possible.len() as u64 - 1) as usize;
        possible.swap(nth, chosen);
        graph.link(possible[nth].0, possible[nth].1);
    }
    renumbered(rng, &graph)
}

/// The same with its nodes in a random topological order: theirs would be that of the schedule, which a tie by numbers repeats.
fn renumbered(rng: &mut Rng, graph: &Graph) -> Graph {
    let count = graph.costs.len();
    let mut waits_for = vec![0; count];
    graph.successors.iter().flatten().for_each(|to| waits_for[*to] += 1);
    let mut ready: Vec<usize> = (0..count).filter(|node| waits_for[*node] == 0).collect();
    let mut order = Vec::with_capacity(count);
    while !ready.is_empty() {
        let node = ready.swap_remove(rng.within(0, ready.len() as u64 - 1) as usize);
        order.push(node);
        for to in &graph.successors[node] {
            waits_for[*to] -= 1;
            if waits_for[*to] == 0 {
                ready.push(*to);
            }
        }
    }
    let mut number = vec![0; count];
    order.iter().enumerate().for_each(|(new, old)| number[*old] = new);
    let successors = order.iter().map(|old| graph.successors[*old].iter().map(|to| number[*to]).collect());
    Graph { costs: order.iter().map(|old| graph.costs[*old]).collect(), successors: successors.collect() }
}

/// Makespan over optimum of each rule.
fn ratios(graph: &Graph, lanes: u8) -> Option<[f64; RULES.len()]> {
    let task = Task { graph: graph.clone(), period_ns: 4 * OPTIMUM_NS, deadline_ns: 4 * OPTIMUM_NS };
    let time = |_, _, node: usize| graph.costs[node];
    let tasks = [task];
    let world = World { releases: &[vec![0]], time: &time, until_miss: false };
    let case = Case { tasks: &tasks, best_percent: 100, world };
    let mut ratios = [0.0; RULES.len()];
    for ((_, config), ratio) in RULES.iter().zip(&mut ratios) {
        *ratio = drive(&case, config.with_lanes(lanes))?.last_end as f64 / OPTIMUM_NS as f64;
    }
    Some(ratios)
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut cells = Vec::new();
    for lanes in LANES {
        for edges in EDGES {
            cells.extend((0..run.seeds).map(|seed| (lanes, edges, seed)));
        }
    }
    let found = run.each(&cells, |(lanes, edges, seed)| {
        let graph = |nth: u64| {
            let words = [u64::from(*lanes), *edges as u64, seed * GRAPHS_PER_SEED + nth];
            ratios(&cut(&mut Rng::of(&words), (*lanes).into(), *edges), *lanes)
        };
        (0..GRAPHS_PER_SEED).map(graph).collect::<Option<Vec<_>>>().ok_or(PaperError::Capacity)
    })?;
    let of = |lanes: u8, edges: usize, rule: usize| -> Option<Estimate> {
        let chosen = cells.iter().zip(&found).filter(|((l, e, _), _)| (*l, *e) == (lanes, edges));
        let ratios: Vec<f64> =
            chosen.flat_map(|(_, ratios)| ratios.iter().map(|ratios| ratios[rule])).collect();
        Estimate::of(&ratios)
    };
    let rows = RULES.iter().enumerate().map(|(nth, (name, _))| {
        let numbers = LANES.iter().flat_map(|lanes| EDGES.map(|edges| Cell::from(of(*lanes, edges, nth))));
        [Cell::from(*name)].into_iter().chain(numbers).collect()
    });
    let rule = |name: &str| RULES.iter().position(|(rule, _)| *rule == name).unwrap_or(0);
    let mut claims = Vec::new();
    for (lanes, must) in LANES.iter().zip(MUST) {
        for edges in EDGES {
            let mean = |rule| of(*lanes, edges, rule).map_or(f64::INFINITY, |e| e.mean);
            let (ours, theirs) = (mean(rule(OURS)), mean(rule(BASELINE)));
            claims.push(Claim {
                claim: format!("{OURS} takes at most {must} times the optimum on {lanes} lanes with {edges} edges, and no more than {BASELINE}"),
                paper: "-".to_owned(),
                ours: format!("{ours:.4} against {theirs:.4}"),
                verdict: if ours <= must && ours <= theirs { Verdict::Holds } else { Verdict::Fails },
                why: "",
            });
        }
    }
    let others = RULES.iter().enumerate().filter(|(_, (name, _))| *name != OURS && *name != BASELINE);
    for (nth, (name, _)) in others.filter(|(_, (name, _))| !name.starts_with("paper")) {
        let kinds = LANES.iter().flat_map(|lanes| EDGES.map(|edges| (*lanes, edges)));
        let mean = |rule, (lanes, edges)| of(lanes, edges, rule).map_or(f64::INFINITY, |e| e.mean);
        let longer = kinds.filter(|kind| mean(nth, *kind) > mean(rule(BASELINE), *kind)).count();
        claims.push(Claim {
            claim: format!("{name} takes no more than {BASELINE}"),
            paper: "-".to_owned(),
            ours: format!("more at {longer} of {} kinds", LANES.len() * EDGES.len()),
            verdict: if longer == 0 { Verdict::Holds } else { Verdict::Loses },
            why: "",
        });
    }
    Ok(Table {
        name: "makespan",
        title: "One graph whose optimum is known",
        source: "not in the paper",
        about: vec![format!(
            "{} graphs of each kind: {NODES} nodes cut out of a schedule that keeps all lanes busy, with 150 or 600 of the edges \
             that it obeys. Non-preemptive; makespan over the optimum.",
            GRAPHS_PER_SEED * run.seeds
        )],
        columns: vec![
            Column::words("rule"),
            Column::numbers("2 lanes, 150 edges", "", 4),
            Column::numbers("600", "", 4),
            Column::numbers("4 lanes, 150", "", 4),
            Column::numbers("600", "", 4),
            Column::numbers("8 lanes, 150", "", 4),
            Column::numbers("600", "", 4),
        ],
        rows: rows.collect(),
        claims,
    })
}
