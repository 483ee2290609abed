//! Section 6.4: bursts.

use super::extended::LAMBDA;
use crate::platform::{EXECUTION, EXTENDED, EXTENDED_LANES, Extended};
use crate::run::{PaperError, Run};
use crate::scenario::{Calls, OBSTACLE_FREE, workload};
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table, Verdict};
use crate::trial::{Sample, Samples, System, Trial};
use red_sim::{Drawn, Execution, SimError, World};
use red_workload::build::{Numbered, Role};
use red_workload::model::Arrival;

const RATIOS_PERCENT: [u64; 3] = [0, 50, 100];
const SYSTEMS: [System; 4] = [System::Edf, System::Red, System::RedDrops, System::Redrt];
/// Share of the lane that the pipeline needs without bursts, in percent.
const BASE_PERCENT: u64 = 88;
/// Periods of a run.
const PERIODS: u64 = 40;

/// Latency in seconds, misses, quality: by platform, ratio, and EDF or RED.
const PAPER: [[[[f64; 2]; 3]; 3]; 3] = [
    [
        [[48.83, 46.46], [59.58, 46.27], [75.34, 46.24]],
        [[31.60, 26.68], [46.34, 25.61], [58.43, 27.30]],
        [[6.58, 6.58], [9.05, 6.58], [11.70, 6.58]],
    ],
    [
        [[1.00, 1.00], [0.99, 1.00], [0.99, 1.00]],
        [[1.00, 1.00], [1.00, 1.00], [1.00, 1.00]],
        [[0.51, 0.42], [0.98, 0.67], [0.99, 1.00]],
    ],
    [
        [[0.09, 0.12], [0.05, 0.13], [0.03, 0.13]],
        [[0.06, 0.09], [0.03, 0.10], [0.02, 0.09]],
        [[0.51, 0.51], [0.22, 0.51], [0.14, 0.51]],
    ],
];

/// The releases of a workload, and after each period a second one with some probability.
struct Bursts<'a> {
    drawn: Drawn<'a>,
    releases: Vec<u64>,
}

impl<'a> Bursts<'a> {
    fn new(drawn: Drawn<'a>, period_ns: u64, percent: u64) -> Self {
        let coin = Execution::Uniform { low_ppm: 0, high_ppm: 999_999 };
        let named =
            Numbered { name: "burst".to_owned(), role: Role::Plain(crate::scenario::part(1_000_000)) };
        let mut releases = Vec::new();
        for nth in 0..PERIODS {
            releases.push(nth * period_ns);
            // Somewhere in the first half of the period.
            let (is_burst, at) =
                (coin.draw(drawn.seed, 0, nth, &named), coin.draw(drawn.seed, 1, nth, &named));
            if is_burst < percent * 10_000 {
                releases.push(nth * period_ns + period_ns / 2 * at / 1_000_000);
            }
        }
        Self { drawn, releases }
    }
}

impl World for Bursts<'_> {
    fn release(&self, _: usize, job: usize) -> Option<u64> {
        self.releases.get(job).copied()
    }

    fn time(&self, task: usize, job: u64, node: &Numbered) -> (u64, bool) {
        self.drawn.time(task, job, node)
    }
}

fn sample(platform: &Extended, percent: u64, system: System, seed: u64) -> Result<Sample, SimError> {
    let calls = Calls::of(platform.unit_ns);
    let work: u64 = OBSTACLE_FREE.stages.iter().flat_map(|nets| nets.iter()).map(|net| net.per_mille()).sum();
    // The load of coarse tasks at their mean execution times, which are 0.88 of the WCET.
    let period_ns = platform.unit_ns * work / 1_000 * 88 / BASE_PERCENT;
    let task = calls.pipeline(OBSTACLE_FREE.stages, platform.budgets_ns[1], Arrival::Periodic { period_ns });
    let workload = workload(EXTENDED_LANES, vec![task], None);
    let drawn = Drawn { workload: &workload, execution: EXECUTION, seed };
    let world = Bursts::new(drawn, period_ns, percent);
    // What was released ends: the last ones wait for all before them.
    let trial =
        Trial { workload: workload.clone(), execution: EXECUTION, horizon_ns: 4 * PERIODS * period_ns };
    trial.run_in(&world, system, system.config(), seed)
}

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let mut cases = Vec::new();
    for platform in &EXTENDED {
        for percent in RATIOS_PERCENT {
            cases.extend(SYSTEMS.map(|system| (platform, percent, system)));
        }
    }
    let samples = run.each(&cases, |(platform, percent, system)| {
        let all: Result<Vec<Sample>, SimError> =
            (1..=run.seeds).map(|seed| sample(platform, *percent, *system, seed)).collect();
        all.map(Samples).map_err(PaperError::Sim)
    })?;
    let at = |p: usize, r: usize, s: usize| &samples[(p * RATIOS_PERCENT.len() + r) * SYSTEMS.len() + s];
    let mut rows = Vec::new();
    for (p, platform) in EXTENDED.iter().enumerate() {
        for (r, percent) in RATIOS_PERCENT.iter().enumerate() {
            for (n, system) in SYSTEMS.iter().enumerate() {
                // The paper's RED drops.
                let column = [Some(0), None, Some(1), None][n];
                let paper = |measure: usize| column.map(|column: usize| PAPER[measure][p][r][column]);
                let ours = at(p, r, n);
                rows.push(vec![
                    Cell::from(platform.name),
                    Cell::from(*percent as f64),
                    Cell::from(system.name()),
                    Cell::from(paper(0)),
                    Cell::from(ours.latency_s()),
                    Cell::from(paper(1)),
                    Cell::from(ours.missed()),
                    Cell::from(ours.given_up()),
                    Cell::from(paper(2)),
                    Cell::from(ours.quality(LAMBDA)),
                ]);
            }
        }
    }
    Ok(Table {
        name: "burst",
        title: "Bursts",
        source: "section 6.4, Table \"burst\"",
        about: vec![
            "The obstacle-free pipeline again and again, at a load of 0.88 of the lane; in a share of the periods a second one \
             comes, so that the load is 0.88, 1.32 and 1.76. Latency is over jobs that completed: whoever gives up the \
             late ones looks fast, so read it beside the misses."
                .to_owned(),
            "RED stands twice: with the paper's ProactiveDrop, and without it.".to_owned(),
        ],
        columns: vec![
            Column::words("platform"),
            Column::numbers("bursts", "%", 0),
            Column::words("system"),
            Column::numbers("latency, paper", "s", 2),
            Column::numbers("latency", "s", 2),
            Column::numbers("misses, paper", "", 2),
            Column::numbers("end-to-end misses", "", 2),
            Column::numbers("given up", "", 2),
            Column::numbers("QoE .05, paper", "", 2),
            Column::numbers("QoE .05", "", 2),
        ],
        rows,
        claims: claims(&at),
    })
}

fn claims<'a>(at: &impl Fn(usize, usize, usize) -> &'a Samples) -> Vec<Claim> {
    const MAC: usize = 2;
    const FULL: usize = 2;
    let mean = |of: Option<Estimate>| of.map_or(0.0, |e| e.mean);
    let latency = |n: usize, r: usize| mean(at(MAC, r, n).latency_s());
    let grows = 100.0 * (latency(0, FULL) / latency(0, 0) - 1.0);
    let bounded = 100.0 * (latency(2, FULL) / latency(2, 0) - 1.0);
    let missed = |n: usize| mean(at(MAC, FULL, n).missed());
    vec![
        Claim {
            claim: "EDF's latency grows with bursts (MacBook Pro, 0 to 100 %)".to_owned(),
            paper: "+77.8 %".to_owned(),
            ours: format!("{grows:+.1} %"),
            verdict: Verdict::of_change(77.8, grows),
            why: "by how much says how long the overload lasted, which is not published",
        },
        Claim {
            claim: "RED's latency does not (MacBook Pro, 0 to 100 %)".to_owned(),
            paper: "+0.0 %".to_owned(),
            ours: format!("{bounded:+.1} %"),
            verdict: if bounded.abs() < 0.25 * grows {
                Verdict::Reproduced
            } else {
                Verdict::NotReproducible
            },
            why: "because it drops jobs: the survivors' latency is bounded, the misses are not",
        },
        Claim {
            claim: "misses at 100 % bursts, RED against EDF (MacBook Pro)".to_owned(),
            paper: "1.00 against 0.99".to_owned(),
            ours: format!("{:.2} against {:.2}", missed(2), missed(0)),
            verdict: if missed(2) > 0.9 * missed(0) { Verdict::Reproduced } else { Verdict::NotReproducible },
            why: "lowest urgency first gives up the jobs that could still make it and keeps those that are late",
        },
        Claim {
            claim: "misses at 100 % bursts, REDRT against EDF (MacBook Pro)".to_owned(),
            paper: "-".to_owned(),
            ours: format!("{:.2} against {:.2}", missed(3), missed(0)),
            verdict: Verdict::Ours,
            why: "it gives up only jobs that cannot make it any more, and runs the encoder once",
        },
    ]
}
