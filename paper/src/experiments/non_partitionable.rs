//! Section 6.3: more and more tasks that cannot be split.

use super::extended::{LAMBDA, trial};
use crate::platform::EXTENDED;
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, OBSTACLE};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::{Samples, System};

const RATIOS_PER_MILLE: [u64; 3] = [0, 500, 1_000];
const SYSTEMS: [System; 3] = [System::Edf, System::Red, System::Redrt];

/// Latency in seconds, misses, quality: by platform, ratio, and EDF or RED.
const PAPER: [[[[f64; 2]; 3]; 3]; 3] = [
    [
        [[41.77, 37.47], [41.93, 38.91], [42.11, 39.40]],
        [[26.59, 16.11], [24.54, 16.21], [26.39, 16.38]],
        [[5.64, 3.63], [5.64, 4.05], [5.64, 3.97]],
    ],
    [
        [[0.99, 0.60], [0.99, 0.68], [0.97, 0.64]],
        [[1.00, 0.82], [1.00, 0.79], [1.00, 0.83]],
        [[0.17, 0.00], [0.14, 0.00], [0.16, 0.00]],
    ],
    [
        [[0.31, 1.00], [0.29, 1.00], [0.28, 1.00]],
        [[0.09, 1.00], [0.11, 1.00], [0.09, 1.00]],
        [[1.00, 1.00], [1.00, 1.00], [1.00, 1.00]],
    ],
];

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut trials = Vec::new();
    for platform in &EXTENDED {
        for atomic_per_mille in RATIOS_PER_MILLE {
            let calls = Calls { atomic_per_mille, ..Calls::of(platform.unit_ns) };
            trials.extend(SYSTEMS.map(|system| (trial(platform, &OBSTACLE, calls), system)));
        }
    }
    let samples = run.trials(&trials)?;
    let at = |p: usize, r: usize, s: usize| &samples[(p * RATIOS_PER_MILLE.len() + r) * SYSTEMS.len() + s];
    let mut rows = Vec::new();
    for (p, platform) in EXTENDED.iter().enumerate() {
        for (r, ratio) in RATIOS_PER_MILLE.iter().enumerate() {
            for (n, system) in SYSTEMS.iter().enumerate() {
                let paper = |measure: usize| PAPER[measure][p][r].get(n).copied();
                let ours = at(p, r, n);
                rows.push(vec![
                    Cell::from(platform.name),
                    Cell::from(*ratio as f64 / 10.0),
                    Cell::from(system.name()),
                    Cell::from(paper(0)),
                    Cell::from(ours.latency_s()),
                    Cell::from(paper(1)),
                    Cell::from(ours.missed()),
                    Cell::from(ours.nodes_missed()),
                    Cell::from(paper(2)),
                    Cell::from(ours.quality(LAMBDA)),
                ]);
            }
        }
    }
    let (is_flat, rises, ahead) = (
        (0..EXTENDED.len()).all(|p| change(at(p, 0, 0), at(p, 2, 0)).abs() < 2.0),
        (0..EXTENDED.len()).all(|p| change(at(p, 0, 1), at(p, 2, 1)) > 0.0),
        (0..EXTENDED.len()).all(|p| (0..3).all(|r| change(at(p, r, 0), at(p, r, 1)) < 0.0)),
    );
    let quality = |p: usize, r: usize, s: usize| at(p, r, s).quality(LAMBDA).map_or(0.0, |e| e.mean);
    let mut behind = Vec::new();
    for (p, platform) in EXTENDED.iter().enumerate() {
        for (r, ratio) in RATIOS_PER_MILLE.iter().enumerate() {
            if quality(p, r, 2) < quality(p, r, 0) {
                behind.push(format!("{}, {} %", platform.name, ratio / 10));
            }
        }
    }
    let claim = |claim: &str, holds: bool, why| Claim {
        claim: claim.to_owned(),
        paper: "on all three platforms".to_owned(),
        ours: if holds { "on all three" } else { "not on all three" }.to_owned(),
        verdict: if holds { Verdict::ShapeOnly } else { Verdict::NotReproducible },
        why,
    };
    Ok(Table {
        name: "non-partitionable",
        title: "Tasks that cannot be split",
        source: "section 6.3, Table \"non-partitionable\"",
        about: vec![
            "The obstacle pipeline; a share of its tasks is one indivisible node each instead of an encoder and a decoder, so \
             that nothing can be shared with them. The paper has the obstacle-free pipeline, where no stage of two tasks \
             has anything to share, and where its numbers contradict those of its other tables: the same experiment reads \
             41.8 s at 0 % here and 48.8 s in Table \"burst\"."
                .to_owned(),
        ],
        columns: vec![
            Column::words("platform"),
            Column::numbers("indivisible", "%", 0),
            Column::words("system"),
            Column::numbers("latency, paper", "s", 2),
            Column::numbers("latency", "s", 2),
            Column::numbers("misses, paper", "", 2),
            Column::numbers("end-to-end misses", "", 2),
            Column::numbers("node misses", "", 2),
            Column::numbers("QoE .05, paper", "", 2),
            Column::numbers("QoE .05", "", 2),
        ],
        rows,
        claims: vec![
            claim("EDF is flat over the ratio", is_flat, FLAT),
            claim("RED rises a little with the ratio", rises, "what cannot be split cannot be shared"),
            claim(
                "RED is ahead of EDF at each ratio",
                ahead,
                "where nothing can be split any more, what is left of its gain are the barriers that it does not wait for",
            ),
            Claim {
                claim: "REDRT is not behind EDF in quality".to_owned(),
                paper: "-".to_owned(),
                ours: match behind.len() {
                    0 => "nowhere".to_owned(),
                    _ => format!("behind at {}", behind.join("; ")),
                },
                verdict: if behind.is_empty() { Verdict::Holds } else { Verdict::Loses },
                why: if behind.is_empty() { "" } else { BEHIND },
            },
            Claim {
                claim: "quality of 1.00 beside 82 % of misses (AGX Orin)".to_owned(),
                paper: "as printed".to_owned(),
                ours: "never".to_owned(),
                verdict: Verdict::NotReproducible,
                why: "a run that misses end to end scores below 1: the paper counts misses against other deadlines than scores",
            },
        ],
    })
}

const FLAT: &str = "it runs tasks whole anyway, but one time for a task varies more than the sum of its two parts' times, and a \
                    barrier waits for the longest";
const BEHIND: &str = "nothing is left to share, and not even the best case is in time: REDRT gives such jobs up, where a late \
                      result still scores";

/// Mean latency of one against another's, in percent.
fn change(from: &Samples, to: &Samples) -> f64 {
    let ratio = |a: f64, b: f64| 100.0 * (b / a - 1.0);
    Estimate::paired(&from.latencies_s(), &to.latencies_s(), ratio).map_or(0.0, |e| e.mean)
}
