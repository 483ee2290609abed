//! Section 5.2: the mini-benchmark on four platforms, tight and loose.

use super::lone::{SCENARIOS, trial};
use crate::platform::{PLATFORMS, Platform};
use crate::run::{PaperError, Run};
use crate::scenario::Calls;
use crate::stat::Estimate;
use crate::table::{Cell, Claim, Column, Table};
use crate::trial::{Samples, System};

/// Against whom, and by how many percent RED's mean latency, misses and quality differ (section 5.2).
const HEADLINES: [(System, [f64; 3]); 3] = [
    (System::Edf, [-24.7, -40.5, 34.8]),
    (System::RedIda, [-17.3, -37.8, 34.2]),
    (System::RedFg, [-14.2, -37.5, 15.9]),
];
const LAMBDA: f64 = 1.0;

/// A platform with one of its deadlines.
struct Setting {
    platform: &'static Platform,
    name: &'static str,
    deadline_ns: u64,
}

fn settings() -> Vec<Setting> {
    let of = |platform: &'static Platform| {
        [("tight", platform.tight_ns), ("loose", platform.loose_ns)].map(|(name, deadline_ns)| Setting {
            platform,
            name,
            deadline_ns,
        })
    };
    PLATFORMS.iter().flat_map(of).collect()
}

/// Both scenarios of a setting under one system, as one list of jobs for each seed.
pub(super) fn both_scenarios(
    run: &Run<'_>,
    cases: &[(&Platform, u64)],
) -> Result<Vec<[Samples; 5]>, PaperError> {
    let mut trials = Vec::new();
    for (platform, deadline_ns) in cases {
        for system in System::ALL {
            for scenario in SCENARIOS {
                trials.push((trial(platform, &scenario, *deadline_ns, Calls::of(platform.unit_ns)), system));
            }
        }
    }
    let mut samples = run.trials(&trials)?.into_iter();
    let mut next = || {
        let (free, obstacle) = (samples.next().unwrap_or_default(), samples.next().unwrap_or_default());
        Samples(free.0.into_iter().zip(obstacle.0).map(|(a, b)| a.and(b)).collect())
    };
    Ok(cases.iter().map(|_| System::ALL.map(|_| next())).collect())
}

pub(super) fn run(run: &Run<'_>) -> Result<Table, PaperError> {
    let settings = settings();
    let cases: Vec<(&Platform, u64)> = settings.iter().map(|s| (s.platform, s.deadline_ns)).collect();
    let results = both_scenarios(run, &cases)?;
    let mut rows = Vec::new();
    for (setting, systems) in settings.iter().zip(&results) {
        for (system, samples) in System::ALL.iter().zip(systems) {
            let paper =
                (*system == System::Edf && setting.name == "tight").then_some(setting.platform.edf_latency_s);
            rows.push(vec![
                Cell::from(format!("{} {}", setting.platform.name, setting.name)),
                Cell::from(system.name()),
                Cell::from(paper),
                Cell::from(samples.latency_s()),
                Cell::from(samples.missed()),
                Cell::from(samples.nodes_missed()),
                Cell::from(samples.given_up()),
                Cell::from(samples.quality(LAMBDA)),
            ]);
        }
    }
    Ok(Table {
        name: "effectiveness",
        title: "Overall effectiveness",
        source: "section 5.2, Figure 6",
        about: vec![
            "Two scenarios (L, S, C and L, S + O, C), ten runs of each, one after the other, on each platform at its tight \
             and its loose deadline. The paper draws its results and publishes means over the eight settings; the \
             latency of EDF at tight deadlines is inferred from its Table \"variant lambda\", and our times are scaled \
             to it, one number for each platform."
                .to_owned(),
        ],
        columns: vec![
            Column::words("setting"),
            Column::words("system"),
            Column::numbers("latency, paper", "s", 2),
            Column::numbers("latency", "s", 2),
            Column::numbers("end-to-end misses", "", 3),
            Column::numbers("node misses", "", 3),
            Column::numbers("given up", "", 3),
            Column::numbers("QoE, lambda 1", "", 3),
        ],
        rows,
        claims: claims(&results),
    })
}

fn claims(results: &[[Samples; 5]]) -> Vec<Claim> {
    let of = |system: System| System::ALL.iter().position(|s| *s == system).unwrap_or(0);
    type Measure = fn(&Samples) -> Vec<f64>;
    let measures: [(&str, Measure); 3] = [
        ("mean latency", |s| s.latencies_s()),
        ("end-to-end misses", |s| s.each(|x| x.missed)),
        ("quality at lambda 1", |s| s.each(|x| x.quality(LAMBDA))),
    ];
    let mut claims = Vec::new();
    for (ours, why) in [(System::Red, WHY), (System::Redrt, "ours; the paper's value is RED's")] {
        for (against, paper) in HEADLINES {
            for ((what, measure), paper) in measures.iter().zip(paper) {
                // Ratio of the means over the eight settings, by seed.
                let mean = |system: System| {
                    let by_setting: Vec<Vec<f64>> =
                        results.iter().map(|systems| measure(&systems[of(system)])).collect();
                    let seeds = by_setting.iter().map(Vec::len).min().unwrap_or(0);
                    let sum = |seed: usize| by_setting.iter().map(|samples| samples[seed]).sum::<f64>();
                    (0..seeds).map(sum).collect::<Vec<f64>>()
                };
                let change = Estimate::paired(&mean(ours), &mean(against), |a, b| 100.0 * (a / b - 1.0));
                let claim = format!("{what}, {} against {}", ours.name(), against.name());
                claims.push(Claim::change(claim, paper, change, why));
            }
        }
    }
    claims
}

const WHY: &str = "more than half of RED's gain is that it does not wait for barriers; sharing the encoder within a stage \
                   gives the rest, and FG and IDA cannot differ where one pipeline runs alone";
