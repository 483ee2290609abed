//! Table "variant lambda": quality of experience at five values of lambda, tight deadlines.

use super::effectiveness::both_scenarios;
use crate::platform::{PLATFORMS, Platform};
use crate::run::{PaperError, Run};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::System;

const LAMBDAS: [f64; 5] = [0.001, 0.01, 0.1, 1.0, 10.0];

/// By platform; EDF, RED-FG, RED-IDA, RED; by lambda.
const PAPER: [[[f64; 5]; 4]; 4] = [
    [
        [0.256, 0.254, 0.238, 0.113, 0.001],
        [0.248, 0.246, 0.230, 0.108, 0.001],
        [0.306, 0.304, 0.285, 0.140, 0.002],
        [0.461, 0.460, 0.437, 0.240, 0.004],
    ],
    [
        [0.420, 0.418, 0.399, 0.222, 0.003],
        [0.473, 0.470, 0.448, 0.248, 0.001],
        [0.638, 0.636, 0.615, 0.395, 0.001],
        [1.000, 1.000, 1.000, 1.000, 1.000],
    ],
    [
        [0.748, 0.746, 0.735, 0.616, 0.003],
        [0.525, 0.523, 0.501, 0.295, 0.005],
        [0.946, 0.945, 0.942, 0.902, 0.500],
        [0.999, 0.999, 0.998, 0.996, 0.900],
    ],
    [
        [0.973, 0.972, 0.971, 0.954, 0.878],
        [0.953, 0.952, 0.951, 0.931, 0.893],
        [0.973, 0.973, 0.971, 0.956, 0.900],
        [0.990, 0.990, 0.989, 0.984, 0.960],
    ],
];

/// Which lambda verdicts are about: the paper's own (section 5.1).
const JUDGED: usize = 3;

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let cases: Vec<(&Platform, u64)> = PLATFORMS.iter().map(|p| (p, p.tight_ns)).collect();
    let results = both_scenarios(run, &cases)?;
    let mut rows = Vec::new();
    let (mut best, mut falls) = (0, 0);
    for ((platform, systems), paper) in PLATFORMS.iter().zip(&results).zip(&PAPER) {
        let ours: Vec<Vec<f64>> = systems
            .iter()
            .map(|s| LAMBDAS.iter().map(|l| s.quality(*l).map_or(0.0, |e| e.mean)).collect())
            .collect();
        for (nth, system) in System::ALL.iter().enumerate() {
            let mut row = vec![Cell::from(platform.name), Cell::from(system.name())];
            for (at, ours) in ours[nth].iter().enumerate() {
                row.push(Cell::from(paper.get(nth).map(|values| values[at])));
                row.push(Cell::from(*ours));
            }
            row.push(Cell::from(match (nth, paper.get(nth)) {
                (0, _) => Verdict::Calibrated,
                (_, None) => Verdict::Ours,
                (_, Some(values)) => {
                    Verdict::of_value(values[JUDGED], ours[nth][JUDGED], paper[0][JUDGED], ours[0][JUDGED])
                }
            }));
            rows.push(row);
        }
        best += usize::from((0..3).all(|other| ours[3][JUDGED] >= ours[other][JUDGED]));
        falls += usize::from(ours[..4].iter().all(|q| q.windows(2).all(|pair| pair[0] >= pair[1])));
    }
    let all = PLATFORMS.len();
    let count = |claim: &str, paper: &str, n: usize, why| Claim {
        claim: claim.to_owned(),
        paper: paper.to_owned(),
        ours: format!("{n} of {all} platforms"),
        verdict: if n == all { Verdict::Reproduced } else { Verdict::NotReproducible },
        why,
    };
    Ok(Table {
        name: "lambda",
        title: "Quality of experience at five values of lambda",
        source: "section 5.4, Table \"variant lambda\"",
        about: vec![
            "Tight deadlines, both scenarios. The score is 1 / (1 + e^lambda x), x the end-to-end tardiness in seconds: only so \
             do the paper's five columns agree with each other. At lambda = 10 it is the share of runs that met the \
             deadline."
                .to_owned(),
        ],
        columns: vec![
            Column::words("platform"),
            Column::words("system"),
            Column::numbers(".001, paper", "", 3),
            Column::numbers(".001", "", 3),
            Column::numbers(".01, paper", "", 3),
            Column::numbers(".01", "", 3),
            Column::numbers(".1, paper", "", 3),
            Column::numbers(".1", "", 3),
            Column::numbers("1, paper", "", 3),
            Column::numbers("1", "", 3),
            Column::numbers("10, paper", "", 3),
            Column::numbers("10", "", 3),
            Column::words("verdict at 1"),
        ],
        rows,
        claims: vec![
            count("RED scores best of the paper's four at lambda 1", "4 of 4 platforms", best, ""),
            count("scores are flat up to 0.1 and fall from there", "4 of 4 platforms", falls, ""),
            Claim {
                claim: "RED-FG scores below EDF on Nano, Xavier and Orin".to_owned(),
                paper: "as printed; the text says that FG helps in seven of eight settings".to_owned(),
                ours: "on all four".to_owned(),
                verdict: Verdict::of_change(-1.5, mean_of_fg_against_edf(&results)),
                why: "level gating with periodic barriers adds a wait per level, which refinement alone does not win back",
            },
        ],
    })
}

/// By how many percent the quality of RED-FG at lambda 1 differs from EDF's, all platforms together.
fn mean_of_fg_against_edf(results: &[[crate::trial::Samples; 5]]) -> f64 {
    let sum = |system: usize| -> f64 {
        results.iter().filter_map(|systems| Some(systems[system].quality(LAMBDAS[JUDGED])?.mean)).sum()
    };
    100.0 * (sum(1) / sum(0) - 1.0)
}
