//! Section 5.5: memory and time of the scheduler.

use super::lone::trial;
use crate::platform::PLATFORMS;
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, OBSTACLE};
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::System;
use red_core::{Caps, Scheduler};

/// The paper's workload: 4 tasks of up to 16 nodes each, 16 jobs in flight, 4 lanes.
type Paper = Caps<4, 16, 16>;
/// Scheduler and synchronizers at tight deadlines, in bytes (Table "overhead", a).
const PAPER_SCHEDULER: f64 = 5.0 * 1024.0;
const PAPER_SYNC: f64 = 40.1 * 1024.0 * 1024.0;
/// Runtime overhead in milliseconds (c): Nano, TX2, Xavier, Orin.
const PAPER_RUNTIME_MS: [f64; 4] = [27.3, 26.9, 17.4, 1.2];

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let trials: Vec<_> = PLATFORMS
        .iter()
        .map(|p| (trial(p, &OBSTACLE, p.tight_ns, Calls::of(p.unit_ns)), System::Redrt))
        .collect();
    let units = run.each(&trials, |(trial, system)| {
        trial.run(*system, 1).map(|sample| sample.units).map_err(PaperError::Sim)
    })?;
    let ours = Scheduler::<Paper>::SIZE as f64;
    let mut rows = vec![
        row("state of the scheduler, synchronizers in it", "bytes", PAPER_SCHEDULER, Some(ours)),
        row("synchronizers apart from it", "bytes", PAPER_SYNC, Some(0.0)),
    ];
    for ((platform, paper), units) in PLATFORMS.iter().zip(PAPER_RUNTIME_MS).zip(&units) {
        rows.push(row(&format!("runtime overhead on {}, tight", platform.name), "ms", paper, None));
        let name = format!("scheduling decisions of a run on {}", platform.name);
        rows.push(vec![
            Cell::from(name),
            Cell::from("units"),
            Cell::from(None::<f64>),
            Cell::from(*units / 10.0),
        ]);
    }
    Ok(Table {
        name: "overhead",
        title: "Overhead",
        source: "section 5.5, Table \"overhead\"",
        about: vec![
            "Times of a processor cannot be had in virtual time: `cargo xtask bench` measures what a decision costs, beside \
             other executors in the same run; `redrt run` and `redrt demo` print it as overhead per unit. What is said here is \
             the same on every machine."
                .to_owned(),
        ],
        columns: vec![
            Column::words("what"),
            Column::words("unit"),
            Column::numbers("paper", "", 1),
            Column::numbers("here", "", 1),
        ],
        rows,
        claims: vec![Claim {
            claim: "the scheduler is modest in memory".to_owned(),
            paper: "5 KiB, and 40.1 MiB of synchronizers".to_owned(),
            ours: format!("{ours:.0} bytes in all, for 4 tasks of 16 nodes, 16 jobs in flight and 4 lanes"),
            verdict: if ours < PAPER_SYNC { Verdict::ShapeOnly } else { Verdict::NotReproducible },
            why: "more state than the paper's scheduler, and none of its megabytes: those are of processes that talk to each \
                  other, and lanes here are threads beside one state",
        }],
    })
}

fn row(what: &str, unit: &str, paper: f64, ours: Option<f64>) -> Vec<Cell> {
    vec![Cell::from(what), Cell::from(unit), Cell::from(paper), Cell::from(ours)]
}
