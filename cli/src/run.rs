//! `redrt run`.

use crate::live::View;
use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::session::trace::Trace;
use crate::session::{self, Options, RunSummary, Session, SessionError};
use crate::table::{Table, time};
use red_rt::runtime::Mode;
use red_rt::setup::SetupError;
use red_workload::model::Workload;
use red_workload::policy::Policy;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Runs a workload in real time on this machine.
#[derive(clap::Args)]
#[command(after_help = "\
Releases come by the clock for `duration`, then the jobs in flight drain. Sporadic tasks are released by plugins.
Ctrl-C ends the run cleanly, with the summary so far. Without real-time rights: exit status 3, with the fix.

Example:
  redrt run examples/cruise.toml --duration 10s --trace cruise.json")]
pub(crate) struct Args {
    /// Workload file, TOML or YAML.
    file: PathBuf,
    /// Policy.
    #[arg(long, value_name = "POLICY", default_value = "redrt", value_parser = options::policy())]
    policy: Policy,
    /// Time during which jobs are released.
    #[arg(long, value_name = "TIME", default_value = "10s", value_parser = options::time_ns)]
    duration: u64,
    /// Write a trace for Perfetto or chrome://tracing.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
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
    let workload = red_workload::load(&args.file)?;
    let folder = args.file.parent().unwrap_or(Path::new(""));
    let options = Options {
        policy: args.policy,
        duration_ns: args.duration,
        best_effort: args.best_effort,
        folder,
        trace: args.trace.is_some(),
        obstacle_ns: None,
    };
    let session = watch(&workload, &options)?;
    if let Some(path) = &args.trace {
        write_trace(path, &workload, &session)?;
    }
    if args.json {
        output::json(&session.summary)?;
    } else {
        output::line(&text(&session.summary))?;
        if let Some(path) = &args.trace {
            output::line(&format!("trace: {} (open it in ui.perfetto.dev)", path.display()))?;
        }
    }
    let missed: u64 = session.summary.report.tasks.iter().map(|t| t.missed).sum();
    Ok(Answer::of(!args.strict || missed == 0))
}

impl From<SessionError> for Failure {
    fn from(error: SessionError) -> Self {
        match error.exit_code() {
            2 => Self::Input(error.to_string()),
            _ => Self::Machine(format!("{error}; `--best-effort` runs without real time, labelled so")),
        }
    }
}

/// Runs with the live view.
pub(crate) fn watch(workload: &Workload, options: &Options<'_>) -> Result<Session, Failure> {
    let lanes = workload.pools.iter().flat_map(|p| (0..p.lanes).map(move |i| format!("{} lane {i}", p.name)));
    let title = options.policy.name().to_uppercase();
    let view =
        std::cell::RefCell::new(View::new(&title, options.duration_ns, options.obstacle_ns, lanes.collect()));
    let session = session::execute(
        workload,
        options,
        |mode, nodes, why| {
            view.borrow_mut().name(nodes);
            told(mode, why);
        },
        |now, live| view.borrow_mut().show(now, live),
    )?;
    if let Some(signal) = session.summary.stopped_by {
        output::note(&format!("stopped by {signal}; what follows is the run so far"));
    }
    Ok(session)
}

/// Missing rights are said out loud, once, with the fix.
fn told(mode: &Mode, why: Option<&SetupError>) {
    if let (Mode::BestEffort, Some(why)) = (mode, why) {
        output::note(&format!("BEST EFFORT, not real time: {why}"));
    }
}

/// Writes a run's trace.
pub(crate) fn write_trace(path: &Path, workload: &Workload, session: &Session) -> Result<(), Failure> {
    let failed =
        |e: std::io::Error| Failure::Machine(format!("cannot write the trace to {}: {e}", path.display()));
    let trace = Trace {
        policy: session.summary.report.policy,
        tasks: workload.tasks.iter().map(|t| t.name.as_str()).collect(),
        nodes: &session.nodes,
        edges: &session.edges,
        lanes: session.lanes.clone(),
        events: &session.notes.events,
        logs: &session.notes.logs,
        end_ns: session.end_ns,
    };
    let mut file = BufWriter::new(File::create(path).map_err(failed)?);
    trace.write(&mut file).and_then(|()| std::io::Write::flush(&mut file)).map_err(failed)
}

/// A run's summary for people.
fn text(summary: &RunSummary) -> String {
    let report = &summary.report;
    let mut table = Table::new(&["task", "released", "on time", "missed", "shed", "p50", "p99", "max"]);
    for task in &report.tasks {
        let r = &task.response_ns;
        table.row([
            task.name.clone(),
            task.released.to_string(),
            task.on_time.to_string(),
            task.missed.to_string(),
            task.shed.to_string(),
            time(r.p50),
            time(r.p99),
            time(r.max),
        ]);
    }
    let d = &summary.dispatch_ns;
    format!(
        "policy {}, {}, {}\n\n{table}\nunits {}, encoder runs saved {}, nodes late {}, overruns {}, failed {}, lanes lost {}\n\
         dispatch latency p50 {} p99 {} p99.9 {} max {}\n\
         scheduling cost per unit {}, allocations {}, page faults {}, scheduler state {} bytes",
        report.policy,
        if summary.realtime { "real time" } else { "BEST EFFORT, not real time" },
        time(Some(report.horizon_ns)),
        report.units_dispatched,
        report.encoder_runs_saved,
        report.nodes_missed,
        summary.overruns,
        summary.failed,
        summary.lanes_lost,
        time(Some(d.p50)),
        time(Some(d.p99)),
        time(Some(d.p999)),
        time(Some(d.max)),
        time(Some(summary.overhead_ns_per_unit)),
        summary.allocations,
        summary.page_faults,
        summary.scheduler_bytes,
    )
}
