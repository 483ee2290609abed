//! Section 5.3: one camera frame, four outputs, under interference.

use crate::platform::EXECUTION;
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, Net, node, task, workload};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table};
use crate::trial::{Sample, Samples, System, Trial};
use red_core::{Config, Late};
use red_sim::{Drawn, SimError};
use red_workload::model::Arrival;

const MS: u64 = 1_000_000;
/// All four outputs of one frame.
const FRAME: &[&[Net]] = &[&[Net::L, Net::S, Net::O, Net::C]];
/// WCET of an L task: four tasks take 0.85 of a frame's time in the mean, so that EDF's limit is among the six levels.
const UNIT_NS: u64 = 25 * MS;
const FRAME_NS: u64 = 100 * MS;
const FRAMES: u64 = 200;
/// Load of the others, in percent of the lane, in pieces of 5 ms.
const INTERFERENCE_PERCENT: [u64; 6] = [0, 10, 20, 30, 40, 50];
const PIECE_NS: u64 = 5 * MS;
const ENCODERS_PER_MILLE: [u64; 2] = [500, 300];
const SYSTEMS: [System; 5] = System::ALL;

/// Of the frames and, where there are some, of the others.
fn sample(
    encoder_per_mille: u64,
    interference: u64,
    system: System,
    seed: u64,
) -> Result<Vec<Sample>, SimError> {
    let calls = Calls { encoder_per_mille, ..Calls::of(UNIT_NS) };
    let mut tasks = vec![calls.pipeline(FRAME, FRAME_NS, Arrival::Periodic { period_ns: FRAME_NS })];
    if let Some(period_ns) = (PIECE_NS * 100).checked_div(interference) {
        tasks.push(task(
            "others",
            period_ns,
            Arrival::Periodic { period_ns },
            vec![node("piece", &[], PIECE_NS)],
        ));
    }
    let workload = workload(1, tasks, None);
    let trial = Trial { workload: workload.clone(), execution: EXECUTION, horizon_ns: FRAMES * FRAME_NS };
    let world = Drawn { workload: &workload, execution: EXECUTION, seed };
    // A frame that is late is dropped: the next one is there.
    let config = Config { late: Late::AbortJob, ..system.config() };
    trial.run_by_task(&world, system, config, seed)
}

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut cases = Vec::new();
    for encoder in ENCODERS_PER_MILLE {
        for interference in INTERFERENCE_PERCENT {
            cases.extend(SYSTEMS.map(|system| (encoder, interference, system)));
        }
    }
    let samples = run.each(&cases, |(encoder, interference, system)| {
        let all: Result<Vec<Vec<Sample>>, SimError> =
            (1..=run.seeds).map(|seed| sample(*encoder, *interference, *system, seed)).collect();
        let all = all.map_err(PaperError::Sim)?;
        let of = |task: usize| Samples(all.iter().filter_map(|tasks| tasks.get(task).cloned()).collect());
        Ok((of(0), of(1)))
    })?;
    let (samples, others): (Vec<Samples>, Vec<Samples>) = samples.into_iter().unzip();
    let rows = cases.iter().zip(samples.iter().zip(&others)).map(
        |((encoder, interference, system), (samples, others))| {
            vec![
                Cell::from(*encoder as f64 / 1e3),
                Cell::from(*interference as f64),
                Cell::from(system.name()),
                Cell::from(samples.latency_s().map(|e| Estimate {
                    mean: e.mean * 1e3,
                    half_width: e.half_width * 1e3,
                    ..e
                })),
                Cell::from(samples.missed()),
                Cell::from(samples.nodes_missed()),
                Cell::from(others.missed()),
            ]
        },
    );
    Ok(Table {
        name: "ros2",
        title: "Under interference, in ROS 2",
        source: "section 5.3, Figure 8",
        about: vec![
            "A frame every 100 ms, four outputs. EDF runs four networks apart, each with its encoder; RED runs one encoder and four \
             decoders. Others take 0 to 50 % of the lane; where the lane has too much to do, who gives up their jobs is fast by that, so \
             their misses stand beside. Frames that are late are dropped, which cuts latencies at the deadline. The paper draws its results and publishes two means; its times are not published."
                .to_owned(),
        ],
        columns: vec![
            Column::numbers("encoder, of an L task", "", 1),
            Column::numbers("interference", "%", 0),
            Column::words("system"),
            Column::numbers("latency", "ms", 1),
            Column::numbers("end-to-end misses", "", 3),
            Column::numbers("node misses", "", 3),
            Column::numbers("misses of the others", "", 3),
        ],
        rows: rows.collect(),
        claims: claims(&samples),
    })
}

fn claims(samples: &[Samples]) -> Vec<Claim> {
    let levels = INTERFERENCE_PERCENT.len();
    let mut claims = Vec::new();
    for (nth, encoder) in ENCODERS_PER_MILLE.iter().enumerate() {
        for (system, name) in [(3, "RED"), (4, "REDRT")] {
            let of = |level: usize, system: usize| &samples[(nth * levels + level) * SYSTEMS.len() + system];
            let mean = |system: usize, measure: &dyn Fn(&Samples) -> Option<Estimate>| -> f64 {
                (0..levels).filter_map(|level| Some(measure(of(level, system))?.mean)).sum()
            };
            for (what, paper, measure) in [
                ("response time", -32.7, &Samples::latency_s as &dyn Fn(&Samples) -> Option<Estimate>),
                ("misses", -67.3, &Samples::missed),
            ] {
                let change = 100.0 * (mean(system, measure) / mean(0, measure) - 1.0);
                let ours = Estimate { mean: change, half_width: 0.0, samples: levels };
                claims.push(Claim {
                    ours: format!("{change:+.1} %"),
                    ..Claim::change(
                        format!("{what}, {name} against EDF, encoder {}", *encoder as f64 / 1e3),
                        paper,
                        Some(ours),
                        "how much is saved follows from how much of a task is its encoder",
                    )
                });
            }
        }
    }
    claims
}
