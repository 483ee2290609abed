//! Mixes of the paper's pipelines: what merging, giving up dead jobs and the frame cache are worth.

use crate::platform::ENCODER_PER_MILLE;
use crate::rng::Rng;
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, EMERGENCY, NIGHT, OBSTACLE, OBSTACLE_FREE, Scenario, URBAN, workload};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::{Sample, Samples, System, Trial};
use red_core::{Config, DeadlineRule, Shed};
use red_sim::{Drawn, Execution, SimError};
use red_workload::model::{Arrival, Task, Workload};

const SCENARIOS: [Scenario; 5] = [OBSTACLE_FREE, OBSTACLE, URBAN, EMERGENCY, NIGHT];
/// Lanes, and load of the coarse tasks at WCET.
const LOADS: [(u32, f64); 7] = [(1, 0.9), (1, 1.1), (1, 1.3), (2, 0.9), (2, 1.1), (2, 1.3), (4, 1.3)];
/// WCET of an L task.
const UNIT_NS: u64 = 10_000_000;
/// Execution times below WCET.
const EXECUTION: Execution = Execution::Uniform { low_ppm: 700_000, high_ppm: 1_000_000 };
/// Deadline in percent of the period, and not below the longest path.
const DEADLINE_PERCENT: u64 = 60;
/// Mixes for each seed that is run: 200 in all with 20 seeds.
const MIXES_PER_SEED: u64 = 10;
/// Jobs of the slowest pipeline.
const JOBS: u64 = 20;

const KEEPING: Config = Config { shed: Shed::Never, frame_cache: false, ..System::Redrt.config() };

/// What is compared: each step adds one thing.
const STEPS: [(&str, System, Config); 6] = [
    ("coarse job-EDF", System::Edf, System::Edf.config()),
    ("the paper's RED, nothing dropped", System::Red, System::Red.config()),
    ("latest finish, merging", System::Redrt, Config { rule: DeadlineRule::LatestFinish, ..KEEPING }),
    ("latest start, merging", System::Redrt, KEEPING),
    ("and dead jobs given up", System::Redrt, Config { frame_cache: false, ..System::Redrt.config() }),
    ("REDRT: and the frame cache", System::Redrt, System::Redrt.config()),
];

fn mix(lanes: u32, load: f64, seed: u64) -> Workload {
    let rng = &mut Rng::of(&[u64::from(lanes), (load * 100.0).round() as u64, seed]);
    let count = u64::from(lanes) + 2;
    let pipeline = |nth: u64| -> Task {
        let scenario = SCENARIOS[rng.within(0, SCENARIOS.len() as u64 - 1) as usize];
        let cost = |nets: &[crate::scenario::Net]| nets.iter().map(|net| net.per_mille()).sum::<u64>();
        let longest =
            |nets: &[crate::scenario::Net]| nets.iter().map(|net| net.per_mille()).max().unwrap_or(0);
        let work = scenario.stages.iter().map(|nets| cost(nets)).sum::<u64>() * UNIT_NS / 1_000;
        let path = scenario.stages.iter().map(|nets| longest(nets)).sum::<u64>() * UNIT_NS / 1_000;
        // Each has its share of the load, more or less.
        let share = load * f64::from(lanes) / count as f64 * (0.6 + 0.8 * rng.unit());
        let period_ns = (work as f64 / share) as u64;
        let deadline_ns = (period_ns * DEADLINE_PERCENT / 100).max(path);
        let calls = Calls { encoder_per_mille: ENCODER_PER_MILLE, ..Calls::of(UNIT_NS) };
        let mut task = calls.pipeline(scenario.stages, deadline_ns, Arrival::Periodic { period_ns });
        task.name = format!("pipeline-{}", nth + 1);
        task.offset_ns = rng.within(0, period_ns - 1);
        task
    };
    let tasks = (0..count).map(pipeline).collect();
    workload(lanes, tasks, None)
}

fn sample(step: usize, lanes: u32, load: f64, seed: u64) -> Result<Sample, SimError> {
    let workload = mix(lanes, load, seed);
    let period = |task: &Task| match task.arrival {
        Arrival::Periodic { period_ns } => period_ns,
        _ => 0,
    };
    let horizon_ns = JOBS * workload.tasks.iter().map(period).max().unwrap_or(0);
    let trial = Trial { workload: workload.clone(), execution: EXECUTION, horizon_ns };
    let (_, system, config) = STEPS[step];
    trial.run_in(&Drawn { workload: &workload, execution: EXECUTION, seed }, system, config, seed)
}

pub(crate) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let cells: Vec<(usize, (u32, f64))> =
        (0..STEPS.len()).flat_map(|step| LOADS.map(|load| (step, load))).collect();
    let samples = run.each(&cells, |(step, (lanes, load))| {
        let all: Result<Vec<Sample>, SimError> =
            (1..=MIXES_PER_SEED * run.seeds).map(|seed| sample(*step, *lanes, *load, seed)).collect();
        all.map(Samples).map_err(PaperError::Sim)
    })?;
    let percent = |e: Option<Estimate>| {
        e.map(|e| Estimate { mean: 100.0 * e.mean, half_width: 100.0 * e.half_width, ..e })
    };
    let rows = STEPS.iter().zip(samples.chunks(LOADS.len())).map(|((name, ..), samples)| {
        let missed = samples.iter().map(|samples| Cell::from(percent(samples.missed())));
        [Cell::from(*name)].into_iter().chain(missed).collect()
    });
    let mean = |step: usize, load: usize| samples[step * LOADS.len() + load].missed().map_or(0.0, |e| e.mean);
    let is_below = |step: usize| (0..LOADS.len()).filter(|load| mean(step, *load) > mean(0, *load)).count();
    let claims = STEPS.iter().enumerate().skip(2).map(|(step, (name, ..))| Claim {
        claim: format!("{name}: nowhere more misses than {}", STEPS[0].0),
        paper: "-".to_owned(),
        ours: format!("more at {} of {} loads", is_below(step), LOADS.len()),
        verdict: if is_below(step) == 0 { Verdict::Holds } else { Verdict::Loses },
        why: "",
    });
    let claims = claims.collect();
    let numbers = |name| Column::numbers(name, "%", 1);
    Ok(Table {
        name: "frame-cache",
        title: "Mixes of the paper's pipelines: jobs that miss",
        source: "not in the paper",
        about: vec![
            "rho + 2 pipelines of the paper's five scenarios on rho lanes; the load is that of unrefined tasks at WCET, executions \
             take 0.7 to 1 of it, deadlines are 0.6 of the periods and not below the longest path; no barriers. Results are \
             shared within a job only: no two pipelines read the same frame."
                .to_owned(),
        ],
        columns: vec![
            Column::words("jobs that miss"),
            numbers("rho 1, load .9"),
            numbers("1.1"),
            numbers("1.3"),
            numbers("rho 2, load .9"),
            numbers("1.1"),
            numbers("1.3"),
            numbers("rho 4, load 1.3"),
        ],
        rows: rows.collect(),
        claims,
    })
}
