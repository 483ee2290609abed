//! `redrt run`.

use crate::denied::Denied;
use crate::executable;
use crate::given_up;
use crate::happened;
use crate::kept;
use crate::live::View;
use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{self, Force, Place};
use crate::session::record::ClosedLog;
use crate::session::trace::Trace;
use crate::session::{self, Options, Progress, RunSummary, Session, SessionError};
use crate::table::{Table, time};
use red_rt::runtime::Mode;
use red_workload::Source;
use red_workload::model::Arrival;
use red_workload::policy::Policy;
use std::cell::RefCell;
use std::path::PathBuf;

/// Runs a workload in real time on this machine.
#[derive(clap::Args)]
#[command(after_help = "\
Releases come by the clock for `duration`, then the jobs in flight drain. Sporadic tasks are released by plugins.
Ctrl-C ends the run cleanly, with the summary so far. A trace or log that is there already is replaced under --force only.
Without real-time rights: exit status 3, with the fix.

Example:
  redrt run examples/cruise.toml --duration 10s --trace cruise.json")]
pub(crate) struct Args {
    /// Workload file, TOML or YAML.
    file: PathBuf,
    /// Policy.
    #[arg(long, value_name = "POLICY", default_value = "redrt", value_parser = options::policy())]
    policy: Policy,
    /// Time during which jobs are released.
    #[arg(long, value_name = "TIME", default_value = "10s", allow_hyphen_values = true, value_parser = options::duration_ns)]
    duration: u64,
    /// Write a trace for Perfetto or chrome://tracing.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Write every input of the scheduler to a log for `redrt replay`.
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Go on without real-time rights; every output says so.
    #[arg(long)]
    best_effort: bool,
    /// Exit with 1 if a deadline was missed.
    #[arg(long)]
    strict: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the file.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let source = Source::load(&args.file)?;
    let mut places = place::beside(&source, &args.force);
    let trace = args.trace.as_ref().map(|path| places.add("trace", "--trace", path)).transpose()?;
    let record = args.record.as_ref().map(|path| places.add_log("--record", path)).transpose()?;
    let options = Options {
        policy: args.policy,
        duration_ns: args.duration,
        best_effort: args.best_effort,
        trace: trace.is_some(),
        record: record.as_ref(),
        obstacle_ns: None,
    };
    let session = watch(&source, &options)?;
    if args.json {
        output::json(&session.summary)?;
    } else {
        output::line(&text(&session.summary))?;
    }
    if let Some(place) = &trace {
        write_trace(place, &session)?;
        output::note(&format!(
            "trace: {} (open it in ui.perfetto.dev)",
            place.path().to_string_lossy().escape_debug()
        ));
    }
    if let Some(record) = &session.record {
        output::note(&record.words());
    }
    happened::went_on(&session.summary)?;
    session.record.as_ref().map_or(Ok(()), ClosedLog::is_whole)?;
    let missed: u64 = session.summary.report.tasks.iter().map(|t| t.missed).sum();
    Ok(Answer::of(!args.strict || missed == 0))
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match (&error, error.exit_code()) {
            (_, 2) => Self::Input(error.to_string()),
            (SessionError::Machine(_), _) => {
                Self::Machine(format!("{error}; `--best-effort` runs without real time, labelled so"))
            }
            _ => Self::Machine(error.to_string()),
        }
    }
}

/// Runs with the live view.
pub(crate) fn watch(source: &Source, options: &Options<'_>) -> Result<Session, Failure> {
    let title = options.policy.name().to_uppercase();
    let lanes = session::lane_titles(&source.workload);
    let view = RefCell::new(View::new(title, options.duration_ns, options.obstacle_ns, lanes));
    let session = session::execute(
        source,
        options,
        |mode, nodes, why| {
            view.borrow_mut().name(nodes);
            told(mode, why);
        },
        |progress, now, live| match progress {
            Progress::Running => view.borrow_mut().show(now, live),
            Progress::Ended => view.borrow_mut().end(now, live),
        },
    )?;
    session.faults.iter().for_each(|fault| output::note(&format!("fault: {fault}")));
    session.stream_hangs.iter().for_each(|hang| output::note(&format!("fault: {hang}")));
    if session.hung > 0 {
        output::note(&hung(&session));
    }
    happened::notes(&session.summary).iter().for_each(|note| output::note(note));
    for name in never_released(source, &session.summary) {
        output::note(&format!(
            "task `{name}` was never released: in `run` only a plugin releases tasks with `min_interarrival`; give it \
             `period` to release it by the clock"
        ));
    }
    if let Some(signal) = session.summary.stopped_by {
        output::note(&format!("stopped by {signal}; what follows is the run so far"));
    }
    Ok(session)
}

/// Sporadic tasks that no plugin released.
fn never_released<'a>(source: &'a Source, summary: &RunSummary) -> impl Iterator<Item = &'a str> {
    let tasks = source.workload.tasks.iter().zip(&summary.report.tasks);
    let silent = tasks
        .filter(|(task, report)| matches!(task.arrival, Arrival::Sporadic { .. }) && report.released == 0);
    silent.map(|(task, _)| task.name.as_str())
}

/// What became of bodies that did not return.
fn hung(session: &Session) -> String {
    // Those of streams have reasons of their own.
    let of_streams = session.summary.cuda.as_ref().map_or(0, |cuda| cuda.lanes_left);
    let (hung, lost) = (session.hung, session.summary.lanes_lost.saturating_sub(of_streams));
    let spares = if lost == 0 {
        "spare threads took their lanes, except at the end of the run".to_owned()
    } else {
        format!("{lost} of their lanes are lost, because no thread could be started; raise `ulimit -u`")
    };
    format!("bodies that did not return within 10 times their WCET and 100 ms: {hung}; {spares}")
}

/// Missing rights are said out loud, once, with the fix.
fn told(mode: &Mode, why: Option<&Denied>) {
    if let (Mode::BestEffort, Some(why)) = (mode, why) {
        output::note(&executable::named_in(&format!("BEST EFFORT, not real time: {why}")));
    }
}

/// Writes a run's trace.
pub(crate) fn write_trace(place: &Place, session: &Session) -> Result<(), Failure> {
    place.write(|file| Trace::of(session).write(file))
}

/// A run's summary for people.
fn text(summary: &RunSummary) -> String {
    let report = &summary.report;
    let mut tasks = Table::new(&[
        "task",
        "released",
        "on time",
        "missed",
        "of them given up",
        "response p50",
        "p99",
        "max",
    ]);
    for task in &report.tasks {
        let counts = [task.released, task.on_time, task.missed, task.shed].map(|count| count.to_string());
        let times = [task.response_ns.p50, task.response_ns.p99, task.response_ns.max].map(time);
        tasks.row([task.name.clone()].into_iter().chain(counts).chain(times));
    }
    let mut nodes = kept::nodes(&report.tasks);
    if !nodes.is_empty() {
        nodes += "\n\n  times from the dispatch on; `executions beyond the WCET` below counts bodies alone";
    }
    let told = [given_up::by_task(&report.tasks), kept::promises(&report.tasks), nodes];
    let told: String =
        told.iter().filter(|part| !part.is_empty()).map(|part| format!("\n\n{part}")).collect();
    let d = &summary.dispatch_ns;
    let mut figures = Table::default();
    let mut row = |title: &str, value: String| figures.row([title.to_owned(), value]);
    row("units dispatched", report.units_dispatched.to_string());
    row("encoder runs saved", report.encoder_runs_saved.to_string());
    row("nodes after their sub-deadlines", report.nodes_missed.to_string());
    row("executions beyond the WCET", summary.overruns.to_string());
    row("bodies that failed or hung", summary.failed.to_string());
    row("lanes lost", summary.lanes_lost.to_string());
    row("dispatch latency, median", time(summary.measured(d.p50)));
    row("dispatch latency, p99", time(summary.measured(d.p99)));
    row("dispatch latency, p99.9", time(summary.measured(d.p999)));
    row("dispatch latency, max", time(summary.measured(d.max)));
    row("scheduling cost per unit", time(summary.measured(summary.overhead_ns_per_unit)));
    row("allocations while running", summary.allocations.to_string());
    row("page faults while running", summary.page_faults.to_string());
    if let Some(cuda) = &summary.cuda {
        row("event waits, issued", cuda.event_waits_issued.to_string());
        row("event waits, avoided", cuda.event_waits_avoided.to_string());
        row("submissions ahead", cuda.submissions_ahead.to_string());
        row("device memory at its highest", format!("{} bytes", cuda.device_memory_bytes));
    }
    row("scheduler state", format!("{} bytes", summary.scheduler_bytes));
    let mode = match (summary.realtime, summary.preempt_rt) {
        (true, true) => "real time",
        (true, false) => "real time on a kernel without PREEMPT_RT, so without a bound",
        (false, _) => "BEST EFFORT, not real time",
    };
    format!(
        "policy {}, {mode}, {}\n\n{tasks}{told}\n\n{figures}",
        report.policy,
        time(Some(report.horizon_ns))
    )
}
