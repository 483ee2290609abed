//! `redrt paper real`: the paper's scenarios with real networks on real threads, system against system.
//!
//! The systems take turns, round by round, so that a machine that gets slower on the way is so for all of them.

use super::Bar;
use crate::demo::models::Networks;
use crate::demo::scene::{self, Costs};
use crate::denied::Denied;
use crate::outcome::Failure;
use crate::output;
use crate::place::{Folder, Place};
use crate::session::{self, Options, RunSummary};
use red_paper::scenario::{EMERGENCY, NIGHT, Net, OBSTACLE, OBSTACLE_FREE, Scenario, URBAN};
use red_paper::stat::Estimate;
use red_paper::table::{Cell, Claim, Column, Table, Verdict, percent};
use red_rt::stop::StopSignals;
use red_workload::metrics::TaskMetrics;
use red_workload::policy::Policy;
use red_workload::{Format, Source};
use std::cell::RefCell;
use std::path::Path;

/// Name on the command line.
pub(super) const NAME: &str = "real";

const SCENARIOS: [Scenario; 5] = [OBSTACLE_FREE, OBSTACLE, URBAN, EMERGENCY, NIGHT];
/// Each system runs each scenario so often.
const ROUNDS: usize = 5;
/// Share of the lanes that a frame takes under EDF, and that others take, in percent.
const EDF_PERCENT: u64 = 80;
const OTHERS_PERCENT: u64 = 15;
/// A piece of the others' load.
const PIECE_NS: u64 = 1_000_000;
/// Deadline in percent of a frame's work under EDF: tight, since the others have their share of that time.
const DEADLINE_PERCENT: u64 = 92;
/// WCET over what was measured, in percent.
const WCET_PERCENT: u64 = 140;
/// RED against EDF in the paper (section 5.2): latency, misses, quality, in percent.
pub(crate) const PAPER: [f64; 3] = [-24.7, -40.5, 34.8];

/// One run's jobs of the pipeline.
#[derive(Clone, Copy)]
struct Measured {
    latency_ms: f64,
    missed: f64,
    given_up: f64,
    quality: f64,
}

/// The table of the rounds that were finished, if there is one, and what was not done because a signal came.
type Made = (Option<Table>, Option<String>);

/// What is written into the folder.
pub(super) struct Files {
    networks: Networks,
    /// Of the scenarios, in their order.
    workloads: Vec<Place>,
}

impl Files {
    /// Their places.
    ///
    /// # Errors
    /// As for [`Folder::add`].
    pub(super) fn of(folder: &mut Folder) -> Result<Self, Failure> {
        let networks = Networks::of(folder)?;
        let workload = |scenario: &Scenario| folder.add("workload", &format!("{}.toml", scenario.name));
        Ok(Self { networks, workloads: SCENARIOS.iter().map(workload).collect::<Result<_, _>>()? })
    }
}

/// Runs everything.
pub(super) fn run(
    folder: &Path,
    files: &Files,
    duration_ns: u64,
    signals: &StopSignals,
) -> Result<Made, Failure> {
    files.networks.unpack()?;
    let left = |rounds| format!("stopped after {rounds} of {ROUNDS} rounds");
    let Some(costs) = Costs::measure(folder)? else { return Ok((None, Some(left(0)))) };
    let lanes = scene::lanes()?;
    let sources: Result<Vec<Source>, Failure> = SCENARIOS
        .iter()
        .zip(&files.workloads)
        .map(|(scenario, place)| source(place, scenario, &costs, lanes))
        .collect();
    let sources = sources?;
    let all = ROUNDS * SCENARIOS.len() * Policy::ALL.len();
    let bar = Bar { name: NAME, nth: 0, of: 1 };
    let mut found = vec![[(); Policy::ALL.len()].map(|()| Vec::new()); SCENARIOS.len()];
    let (mut done, mut rounds, mut realtime, mut why) = (0, 0, true, None);
    'rounds: for round in 0..ROUNDS {
        for (source, found) in sources.iter().zip(&mut found) {
            for (policy, found) in Policy::ALL.iter().zip(found.iter_mut()) {
                bar.show(done, all);
                let (summary, reason) = one(source, *policy, duration_ns)?;
                // A signal ends a run early, and what it has is no measurement.
                if signals.requested().is_some() || summary.stopped_by.is_some() {
                    break 'rounds;
                }
                realtime &= summary.realtime;
                why = why.or(reason);
                found.extend(summary.report.tasks.first().map(measured));
                done += 1;
            }
        }
        rounds = round + 1;
    }
    bar.clear();
    if let Some(why) = why {
        output::note(&format!("BEST EFFORT, not real time: {why}"));
    }
    // Of a round that was broken off some systems have a run and others none.
    found.iter_mut().flatten().for_each(|runs| runs.truncate(rounds));
    let about = About { rounds, lanes, realtime, duration_ns };
    Ok(((rounds > 0).then(|| table(&found, &about)), (rounds < ROUNDS).then(|| left(rounds))))
}

/// How it was run.
struct About {
    rounds: usize,
    lanes: u64,
    realtime: bool,
    duration_ns: u64,
}

fn one(source: &Source, policy: Policy, duration_ns: u64) -> Result<(RunSummary, Option<String>), Failure> {
    let options =
        Options { policy, duration_ns, best_effort: true, trace: false, record: None, obstacle_ns: None };
    let why: RefCell<Option<String>> = RefCell::new(None);
    let ready = |_: &_, _: &_, reason: Option<&Denied>| {
        *why.borrow_mut() = reason.map(Denied::to_string);
    };
    let session = session::execute(source, &options, ready, |_, _, _| ())?;
    Ok((session.summary, why.into_inner()))
}

fn measured(task: &TaskMetrics) -> Measured {
    let decided = (task.on_time + task.missed).max(1) as f64;
    Measured {
        latency_ms: task.response_ns.mean.map_or(0.0, |ns| ns as f64 / 1e6),
        missed: task.missed as f64 / decided,
        given_up: task.shed as f64 / decided,
        quality: task.qoe.get("1").copied().flatten().unwrap_or(0.0),
    }
}

/// A scenario as a workload: a camera, the stages, an actuator; and others beside it.
fn source(place: &Place, scenario: &Scenario, costs: &Costs, lanes: u64) -> Result<Source, Failure> {
    let fixed = scene::CAMERA_NS + scene::ACTUATE_NS;
    let calls = scenario.stages.iter().flat_map(|nets| nets.iter());
    let edf = fixed + calls.map(|net| costs.of("encoder") + costs.of(net.name())).sum::<u64>();
    let period = (edf * 100 / EDF_PERCENT / lanes).max(1);
    let deadline = (edf * DEADLINE_PERCENT / 100).max(period);
    let wcet = |ns: u64| ns * WCET_PERCENT / 100;
    let spin = |name: &str, after: &str, ns: u64| {
        format!(
            "[[task.node]]\nname = \"{name}\"\nafter = [{after}]\nwcet = \"{}ns\"\nbody = {{ spin = \"{ns}ns\" }}\n",
            wcet(ns)
        )
    };
    let mut file = format!(
        "[[pool]]\nname = \"cpu\"\nlanes = {lanes}\n\n[[task]]\nname = \"cruise\"\nperiod = \"{period}ns\"\n\
         deadline = \"{deadline}ns\"\n\n"
    );
    file += &spin("camera", "", scene::CAMERA_NS);
    let mut after = "\"camera\"".to_owned();
    for (stage, nets) in scenario.stages.iter().enumerate() {
        let name = |net: &Net| format!("{}-{}", net.name(), stage + 1);
        for net in *nets {
            file += &call(&name(net), &after, *net, costs, wcet);
        }
        after = nets.iter().map(|net| format!("\"{}\"", name(net))).collect::<Vec<_>>().join(", ");
    }
    file += &spin("actuate", &after, scene::ACTUATE_NS);
    let others = PIECE_NS * 100 / OTHERS_PERCENT / lanes;
    file += &format!(
        "\n[[task]]\nname = \"others\"\nperiod = \"{others}ns\"\ndeadline = \"{others}ns\"\n\n{}",
        spin("piece", "", PIECE_NS)
    );
    place.write_text(&file)?;
    Ok(Source::parse(file.as_bytes(), Format::Toml, place.path())?)
}

fn call(name: &str, after: &str, net: Net, costs: &Costs, wcet: impl Fn(u64) -> u64) -> String {
    let encoder = costs.of("encoder");
    format!(
        "[[task.node]]\nname = \"{name}\"\nafter = [{after}]\nmimonet = {{ weights = \"mimo\", frame = \"front\", \
         encoder = {{ wcet = \"{}ns\", bcet = \"{}ns\", body = {{ onnx = \"encoder.onnx\" }} }}, \
         decoders = [ {{ name = \"head\", wcet = \"{}ns\", body = {{ onnx = \"{}.onnx\" }} }} ] }}\n",
        wcet(encoder),
        encoder / 2,
        wcet(costs.of(net.name())),
        net.name(),
    )
}

/// A figure of a run.
type Of = fn(&Measured) -> f64;
/// By scenario, system and round.
type Found = [[Vec<Measured>; Policy::ALL.len()]];

fn table(found: &Found, about: &About) -> Table {
    let About { rounds, lanes, realtime, duration_ns } = *about;
    let mut rows = Vec::new();
    for (scenario, systems) in SCENARIOS.iter().zip(found) {
        for (policy, runs) in Policy::ALL.iter().zip(systems) {
            let mean = |of: Of| Cell::from(Estimate::of(&runs.iter().map(of).collect::<Vec<f64>>()));
            let against = |of: Of, by| Cell::from(paired(runs, &systems[0], of, by));
            rows.push(vec![
                Cell::from(scenario.name),
                Cell::from(policy.name().to_uppercase()),
                mean(|m| m.latency_ms),
                mean(|m| m.missed),
                mean(|m| m.given_up),
                mean(|m| m.quality),
                against(|m| m.latency_ms, change),
                against(|m| m.missed, points),
                against(|m| m.quality, change),
            ]);
        }
    }
    Table {
        name: NAME,
        title: "The scenarios on this machine",
        source: "section 5.2",
        about: vec![
            format!(
                "Real networks on {lanes} lane{}, {rounds} rounds of {} ms for each system and scenario, in turn. A frame takes \
                 {EDF_PERCENT} % of the lanes under EDF, others {OTHERS_PERCENT} %; the deadline is {DEADLINE_PERCENT} % of a \
                 frame's work under EDF. {}.",
                if lanes == 1 { "" } else { "s" },
                duration_ns / 1_000_000,
                if realtime { "Lanes were real time" } else { "Lanes were BEST EFFORT, not real time" },
            ),
            "Measured, so never twice the same. Latency is over jobs that completed; misses against EDF are percentage points; the paper's values, for the mean over its \
             eight settings, stand in the claims."
                .to_owned(),
        ],
        columns: vec![
            Column::words("scenario"),
            Column::words("system"),
            Column::numbers("latency", "ms", 1),
            Column::numbers("end-to-end misses", "", 3),
            Column::numbers("given up", "", 3),
            Column::numbers("QoE, lambda 1", "", 3),
            Column::numbers("latency against EDF", "%", 1),
            Column::numbers("misses against EDF", "points", 1),
            Column::numbers("QoE against EDF", "%", 1),
        ],
        rows,
        claims: claims(found),
    }
}

/// What a measure of ours makes of theirs, round by round.
fn paired(ours: &[Measured], theirs: &[Measured], of: Of, by: fn(f64, f64) -> f64) -> Option<Estimate> {
    let of_all = |runs: &[Measured]| runs.iter().map(of).collect::<Vec<f64>>();
    Estimate::paired(&of_all(ours), &of_all(theirs), by).filter(|e| e.mean.is_finite())
}

/// By how many percent a measure differs.
fn change(ours: f64, theirs: f64) -> f64 {
    100.0 * (ours / theirs - 1.0)
}

/// By how many percentage points a share differs: that of EDF may be none at all.
fn points(ours: f64, theirs: f64) -> f64 {
    100.0 * (ours - theirs)
}

fn claims(found: &Found) -> Vec<Claim> {
    let at = |policy: Policy| Policy::ALL.iter().position(|p| *p == policy).unwrap_or(0);
    let (edf, red, redrt) = (at(Policy::Edf), at(Policy::Red), at(Policy::Redrt));
    let mean = |runs: &[Measured], of: Of| runs.iter().map(of).sum::<f64>() / runs.len().max(1) as f64;
    // Round by round, of all scenarios together.
    let overall = |system: usize, of: Of| {
        let rounds =
            found.iter().map(|systems| systems[system].len().min(systems[edf].len())).min().unwrap_or(0);
        let sum = |system: usize, round: usize| {
            found.iter().map(|systems| of(&systems[system][round])).sum::<f64>()
        };
        let changes: Vec<f64> = (0..rounds)
            .map(|round| change(sum(system, round), sum(edf, round)))
            .filter(|change| change.is_finite())
            .collect();
        Estimate::of(&changes)
    };
    let mut claims = Vec::new();
    let measures: [(&str, Of); 3] =
        [("mean latency", |m| m.latency_ms), ("misses", |m| m.missed), ("quality", |m| m.quality)];
    for (system, name) in [(red, "RED"), (redrt, "REDRT")] {
        for ((what, of), paper) in measures.iter().zip(PAPER) {
            let ours = overall(system, *of);
            let claim = format!("{what}, {name} against EDF, all scenarios");
            claims.push(Claim::change(claim, paper, ours, WHY));
        }
    }
    for (scenario, systems) in SCENARIOS.iter().zip(found) {
        let (ours, theirs) = (&systems[redrt], &systems[edf]);
        let faster = paired(ours, theirs, |m| m.latency_ms, change);
        let misses = (mean(ours, |m| m.missed), mean(theirs, |m| m.missed));
        let holds = faster.is_some_and(|e| e.mean < 0.0) && (misses.0 < misses.1 || misses.0 == 0.0);
        claims.push(Claim {
            claim: format!("REDRT beats EDF in mean latency and misses: {}", scenario.name),
            paper: "-".to_owned(),
            ours: format!(
                "{}; {:.1} against {:.1} % misses, {} points",
                faster.map_or_else(|| "-".to_owned(), percent),
                100.0 * misses.0,
                100.0 * misses.1,
                paired(ours, theirs, |m| m.missed, points)
                    .map_or_else(|| "-".to_owned(), |e| format!("{:+.1} ± {:.1}", e.mean, e.half_width)),
            ),
            verdict: if holds { Verdict::Holds } else { Verdict::Fails },
            why: "",
        });
    }
    claims
}

const WHY: &str = "other networks, on another machine, under another load than the paper's: its sign, and not its size, can be \
                   expected";
