//! The extended evaluation: five scenarios on three platforms.

use super::lone::RUNS;
use crate::platform::{EXECUTION, EXTENDED, EXTENDED_LANES, Extended};
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, EMERGENCY, NIGHT, OBSTACLE, OBSTACLE_FREE, Scenario, URBAN, workload};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::{Samples, System, Trial};
use red_workload::model::{Arrival, SyncGrid};

/// The scenarios with a column in the paper, and the two of section 5 beside them.
const SCENARIOS: [Scenario; 5] = [URBAN, EMERGENCY, NIGHT, OBSTACLE_FREE, OBSTACLE];

/// Latency in seconds, share of misses, quality: by platform, scenario and system (EDF, RED-FG, RED-IDA, RED).
const PAPER: [[[[f64; 4]; 3]; 3]; 3] = [
    [
        [[32.24, 29.16, 31.37, 23.04], [24.88, 23.02, 25.16, 22.20], [16.07, 16.42, 16.31, 13.65]],
        [[27.90, 27.94, 24.65, 14.24], [21.93, 21.90, 18.76, 13.70], [13.96, 14.00, 11.35, 12.25]],
        [[7.76, 7.77, 4.12, 3.20], [3.45, 3.45, 2.63, 2.27], [1.44, 1.44, 1.16, 1.15]],
    ],
    [
        [[1.00, 1.00, 1.00, 0.17], [1.00, 1.00, 1.00, 0.43], [1.00, 1.00, 1.00, 0.97]],
        [[0.52, 0.07, 0.02, 0.00], [0.38, 0.03, 0.13, 0.00], [0.17, 0.27, 0.13, 0.03]],
        [[0.00, 0.00, 0.00, 0.00], [0.28, 0.03, 0.00, 0.00], [0.00, 0.03, 0.00, 0.00]],
    ],
    [
        [[0.06, 0.07, 0.06, 0.14], [0.11, 0.14, 0.11, 0.17], [0.39, 0.34, 0.35, 1.00]],
        [[0.08, 0.08, 0.11, 1.00], [0.15, 0.15, 0.30, 1.00], [1.00, 1.00, 1.00, 1.00]],
        [[0.35, 0.35, 1.00, 1.00], [0.63, 0.63, 1.00, 1.00], [1.00, 1.00, 1.00, 1.00]],
    ],
];
const LATENCY: usize = 0;
const MISSES: usize = 1;
const QUALITY: usize = 2;
/// lambda of the extended evaluation.
pub(super) const LAMBDA: f64 = 0.05;

/// Ten runs of a scenario.
pub(super) fn trial(platform: &Extended, scenario: &Scenario, calls: Calls) -> Trial {
    let deadline_ns = platform.budgets_ns[usize::from(scenario.name != URBAN.name)];
    let grid_ns = platform.grid_ns();
    // Each run ends before the next, which begins somewhere else between two barriers.
    let period_ns = (8 * platform.unit_ns).next_multiple_of(grid_ns) + grid_ns * 382 / 1_000;
    let task = calls.pipeline(scenario.stages, deadline_ns, Arrival::Periodic { period_ns });
    let sync = SyncGrid { grid_ns, cost_ns: platform.barrier_ns };
    Trial {
        workload: workload(EXTENDED_LANES, vec![task], Some(sync)),
        execution: EXECUTION,
        horizon_ns: RUNS * period_ns,
    }
}

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut trials = Vec::new();
    for platform in &EXTENDED {
        for scenario in SCENARIOS {
            for system in System::ALL {
                trials.push((trial(platform, &scenario, Calls::of(platform.unit_ns)), system));
            }
        }
    }
    let samples = run.trials(&trials)?;
    let at = |platform: usize, scenario: usize, system: usize| {
        &samples[(platform * SCENARIOS.len() + scenario) * System::ALL.len() + system]
    };
    let mut rows = Vec::new();
    for (p, platform) in EXTENDED.iter().enumerate() {
        for (s, scenario) in SCENARIOS.iter().enumerate() {
            for (n, system) in System::ALL.iter().enumerate() {
                let paper = |measure: usize| PAPER[measure][p].get(s).and_then(|row| row.get(n)).copied();
                let ours = at(p, s, n);
                let latency = |samples: &Samples| samples.latency_s().map_or(0.0, |e| e.mean);
                rows.push(vec![
                    Cell::from(platform.name),
                    Cell::from(scenario.name),
                    Cell::from(system.name()),
                    Cell::from(paper(LATENCY)),
                    Cell::from(ours.latency_s()),
                    Cell::from(paper(MISSES)),
                    Cell::from(ours.missed()),
                    Cell::from(ours.nodes_missed()),
                    Cell::from(paper(QUALITY)),
                    Cell::from(ours.quality(LAMBDA)),
                    Cell::from(match (paper(LATENCY), n) {
                        (None, _) => Verdict::Ours,
                        (Some(_), 0) => Verdict::Calibrated,
                        (Some(paper), _) => Verdict::of_value(
                            paper,
                            latency(ours),
                            PAPER[LATENCY][p][s][0],
                            latency(at(p, s, 0)),
                        ),
                    }),
                ]);
            }
        }
    }
    Ok(Table {
        name: "extended",
        title: "Five scenarios on three platforms",
        source: "section 6.2, Table \"extended overall effectiveness\"",
        about: vec![
            "The EDF latencies are what the platforms are fitted to, one number each, so only the others are predictions. \
             Deadlines are inferred. The paper's misses cannot be end to end: EDF on AGX Orin takes 27.9 s in the mean in \
             urban navigation, its score there says that the budget is 16.96 s, and half of its runs are said to be on \
             time. Both counts are given here. Verdicts are about the latency."
                .to_owned(),
        ],
        columns: vec![
            Column::words("platform"),
            Column::words("scenario"),
            Column::words("system"),
            Column::numbers("latency, paper", "s", 2),
            Column::numbers("latency", "s", 2),
            Column::numbers("misses, paper", "", 2),
            Column::numbers("end-to-end misses", "", 2),
            Column::numbers("node misses", "", 2),
            Column::numbers("QoE .05, paper", "", 2),
            Column::numbers("QoE .05", "", 2),
            Column::words("verdict"),
        ],
        rows,
        claims: claims(&at),
    })
}

fn claims<'a>(at: &impl Fn(usize, usize, usize) -> &'a Samples) -> Vec<Claim> {
    const AGX: usize = 1;
    const RED: usize = 3;
    const REDRT: usize = 4;
    let change = |scenario: usize, system: usize, against: usize| {
        let (ours, theirs) =
            (at(AGX, scenario, system).latencies_s(), at(AGX, scenario, against).latencies_s());
        Estimate::paired(&ours, &theirs, |a, b| 100.0 * (a / b - 1.0))
    };
    let paper = |scenario: usize, system: usize, against: usize| {
        let row = PAPER[LATENCY][AGX][scenario];
        100.0 * (row[system] / row[against] - 1.0)
    };
    let encoder = "the stages of one run need one encoder result between them; merging within a stage saves it once or \
                   twice, and only the frame cache, which the paper does not have, across stages";
    let mut claims = Vec::new();
    for (scenario, why) in
        [(0, encoder), (1, encoder), (2, "no stage has anything to share: what is left is the barrier")]
    {
        let name = SCENARIOS[scenario].name;
        claims.push(Claim::change(
            format!("latency on AGX Orin, {name}, RED against EDF"),
            paper(scenario, RED, 0),
            change(scenario, RED, 0),
            why,
        ));
        claims.push(Claim::change(
            format!("latency on AGX Orin, {name}, REDRT against EDF"),
            paper(scenario, RED, 0),
            change(scenario, REDRT, 0),
            "ours, with the frame cache; the paper's value is RED's",
        ));
    }
    claims.push(Claim::change(
        "latency on AGX Orin, urban, RED-FG against EDF",
        paper(0, 1, 0),
        change(0, 1, 0),
        "the text has it as a reduction, \"27.90 to 27.94\"; a barrier after each level costs what it costs",
    ));
    claims.push(Claim::change(
        "latency on AGX Orin, night, RED against RED-IDA",
        paper(2, RED, 2),
        change(2, RED, 2),
        "the text has RED as the fastest of all; in the table RED-IDA is",
    ));
    claims
}
