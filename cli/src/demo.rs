//! `redrt demo`: the paper's obstacle-cruising pipeline with real networks on real threads, under EDF and then
//! under REDRT.
//!
//! Lane detection, then segmentation, then cruise control; while an obstacle is in sight, object detection runs
//! beside segmentation. Each is one call of the same multi-task network, so EDF computes the shared encoder in
//! every call, and REDRT once per frame.

pub(crate) mod models;
mod page;
pub(crate) mod scene;

use crate::given_up::{legend, list};
use crate::happened;
use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{self, Folder, Force};
use crate::run::{watch, write_trace};
use crate::session::record::ClosedLog;
use crate::session::{Options, RunSummary, Session};
use crate::table::{Table, time};
use models::Networks;
use red_rt::stop::StopSignals;
use red_workload::policy::Policy;
use red_workload::{Format, Source, shown_path};
use scene::Costs;
use serde::Serialize;
use std::path::PathBuf;

/// Runs the obstacle-cruising pipeline on this machine, first under EDF and then under REDRT.
#[derive(clap::Args)]
#[command(after_help = "\
Example:
  redrt demo --duration 10s")]
pub(crate) struct Args {
    /// Time per policy.
    #[arg(long, value_name = "TIME", default_value = "10s", allow_hyphen_values = true, value_parser = options::duration_ns)]
    duration: u64,
    /// Folder for the scene, its networks, the traces, the logs and the report; they are written anew each time where the
    /// folder is not told, and under `--force`.
    #[arg(long, value_name = "FOLDER", default_value = place::OWN)]
    out: PathBuf,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Both policies, in turn.
const POLICIES: [Policy; 2] = [Policy::Edf, Policy::Redrt];

#[derive(Serialize)]
struct Runs<'a> {
    runs: Vec<&'a RunSummary>,
}

/// Measures, runs, compares.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let mut folder = Folder::open(&args.out, &args.force)?;
    let networks = Networks::of(&mut folder)?;
    let scene = folder.add("scene", "demo.toml")?;
    let (mut logs, mut traces) = (Vec::new(), Vec::new());
    for policy in POLICIES {
        logs.push(folder.add_log(&format!("{}.redlog", policy.name()))?);
        traces.push(folder.add("trace", &format!("{}.trace.json", policy.name()))?);
    }
    let report = folder.add("report", "report.html")?;
    networks.unpack()?;
    // Around both runs: a signal between them is one, too.
    let signals = StopSignals::install().map_err(|e| Failure::Machine(e.to_string()))?;
    let Some(costs) = Costs::measure(&args.out)? else {
        output::note("stopped; nothing ran");
        return Ok(Answer::No);
    };
    let lanes = scene::lanes()?;
    let plan = scene::plan(&costs, lanes, args.duration);
    output::note(&plan.explained);
    scene.write_text(&plan.file)?;
    let source = Source::parse(plan.file.as_bytes(), Format::Toml, scene.path())?;
    let mut sessions = Vec::new();
    for (policy, log) in POLICIES.into_iter().zip(&logs) {
        if signals.requested().is_some() {
            break;
        }
        let options = Options {
            policy,
            duration_ns: args.duration,
            best_effort: true,
            trace: true,
            record: Some(log),
            obstacle_ns: Some(plan.obstacle_ns),
        };
        sessions.push(watch(&source, &options)?);
    }
    if sessions.is_empty() {
        output::note("stopped; nothing ran");
        return Ok(Answer::No);
    }
    let mut files = Vec::new();
    for (session, trace) in sessions.iter().zip(&traces) {
        write_trace(trace, session)?;
        files.push(format!("trace: {}", trace.path().display()));
        files.extend(session.record.as_ref().map(ClosedLog::words));
    }
    files.push(format!("scene: {} (`redrt run` takes it)", scene.path().display()));
    // Who stopped the runs does not wait for changes to be tried.
    let written = page::write(&report, &sessions, signals.requested().is_none());
    if written.is_ok() {
        files.push(format!("report: {} (open it in a browser)", report.path().display()));
    }
    if args.json {
        output::json(&Runs { runs: sessions.iter().map(|s| &s.summary).collect() })?;
        if written.is_ok() {
            output::note(&format!("report: {}", shown_path(report.path())));
        }
    } else {
        output::line(&text(&sessions, &files))?;
    }
    sessions.iter().try_for_each(|session| happened::went_on(&session.summary))?;
    sessions.iter().filter_map(|session| session.record.as_ref()).try_for_each(ClosedLog::is_whole)?;
    written?;
    Ok(Answer::Yes)
}

/// The comparison: a row per figure, a column per policy.
fn text(sessions: &[Session], files: &[String]) -> String {
    let runs: Vec<&RunSummary> = sessions.iter().map(|s| &s.summary).collect();
    let titles: Vec<String> = runs.iter().map(|run| run.report.policy.to_uppercase()).collect();
    let head: Vec<&str> = std::iter::once("").chain(titles.iter().map(String::as_str)).collect();
    let mut table = Table::new(&head);
    let mut row = |title: &str, cell: &dyn Fn(&RunSummary) -> String| {
        table.row(std::iter::once(title.to_owned()).chain(runs.iter().map(|run| cell(run))));
    };
    let sum = |run: &RunSummary, of: fn(&red_workload::metrics::TaskMetrics) -> u64| -> u64 {
        run.report.tasks.iter().map(of).sum()
    };
    let response = |run: &RunSummary| run.report.tasks.first().map(|t| t.response_ns).unwrap_or_default();
    row("jobs released", &|run| sum(run, |t| t.released).to_string());
    row("on time", &|run| sum(run, |t| t.on_time).to_string());
    row("missed", &|run| sum(run, |t| t.missed).to_string());
    row("  of them given up (shed)", &|run| sum(run, |t| t.shed).to_string());
    let given_up =
        |run: &RunSummary| run.report.tasks.first().map(|task| list(&task.given_up)).unwrap_or_default();
    if runs.iter().any(|run| sum(run, |t| t.shed) > 0) {
        row("  why", &given_up);
    }
    row("response time, median", &|run| time(response(run).p50));
    row("response time, p99", &|run| time(response(run).p99));
    row("response time, max", &|run| time(response(run).max));
    row("encoder runs saved", &|run| run.report.encoder_runs_saved.to_string());
    row("units dispatched", &|run| run.report.units_dispatched.to_string());
    row("scheduling cost per unit", &|run| time(run.measured(run.overhead_ns_per_unit)));
    row("dispatch latency, p99", &|run| time(run.measured(run.dispatch_ns.p99)));
    row("scheduler state", &|run| format!("{} bytes", run.scheduler_bytes));
    row("allocations while running", &|run| run.allocations.to_string());
    row("page faults while running", &|run| run.page_faults.to_string());
    row("lanes", &|run| if run.realtime { "real time" } else { "BEST EFFORT" }.to_owned());
    let reasons: String = legend(runs.iter().flat_map(|run| &run.report.tasks).map(|task| &task.given_up))
        .iter()
        .map(|line| format!("\n{line}"))
        .collect();
    format!(
        "{table}{reasons}\n\n{}\nOpen a trace in ui.perfetto.dev: lanes are rows, arrows are edges of the graph.",
        files.join("\n")
    )
}
