//! `redrt replay`: a recorded run fed to the scheduler again.

use crate::outcome::{Answer, Failure};
use crate::output;
use crate::progress;
use crate::session::Robot;
use crate::table::time;
use red_core::{Empty, Scheduler, TaskId};
use red_record::{Difference, Entry, Header, LogError, Reader, Replay, replay};
use red_workload::build::{self, Plan};
use red_workload::policy::Policy;
use red_workload::{Format, Source, shown_path};
use serde::Serialize;
use std::fmt::Write;
use std::fs::{self, File};
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// Feeds the inputs of a recorded run to the scheduler again, and compares every action.
#[derive(clap::Args)]
#[command(after_help = "\
Exit status 1, with the first difference, where an action is not as it was recorded.

Example:
  redrt run examples/cruise.toml --duration 5s --record cruise.redlog
  redrt replay cruise.redlog")]
pub(crate) struct Args {
    /// Log of `redrt run --record`.
    log: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// A replay in numbers.
#[derive(Serialize)]
struct Report {
    policy: String,
    inputs: u64,
    actions: u64,
    equal: bool,
    difference: Option<Differs>,
}

/// The first difference in words.
#[derive(Serialize)]
struct Differs {
    input: u64,
    at_ns: u64,
    call: String,
    recorded: String,
    replayed: String,
    before: Vec<String>,
}

/// A log whose run is set up again.
pub(crate) struct Opened {
    log: Reader<BufReader<File>>,
    scheduler: Box<Scheduler<Robot>>,
    plan: Plan<Robot>,
    tasks: Vec<TaskId>,
}

/// Replays and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let mut opened = open(&args.log)?;
    let found =
        progress::during("replaying", || opened.replay(|_, _| {})).map_err(|e| refused(&args.log, &e))?;
    let header = opened.log.header();
    let report = Report {
        policy: header.policy.clone(),
        inputs: found.inputs,
        actions: found.actions,
        equal: found.difference.is_none(),
        difference: found.difference.as_ref().map(differs),
    };
    if args.json {
        output::json(&report)?;
    } else {
        output::line(&text(header, &report))?;
    }
    Ok(Answer::of(report.equal))
}

fn refused(path: &Path, error: &LogError) -> Failure {
    Failure::Input(format!("`{}`: {error}", shown_path(path)))
}

fn open(path: &Path) -> Result<Opened, Failure> {
    let unreadable = |e| refused(path, &LogError::Read(e));
    // Opening a FIFO would wait for its writer.
    if !fs::metadata(path).map_err(unreadable)?.is_file() {
        return Err(unreadable(io::Error::other("it is a directory, a FIFO, a device or a socket")));
    }
    let file = File::open(path).map_err(unreadable)?;
    let log = Reader::new(BufReader::new(file)).map_err(|e| refused(path, &e))?;
    let header = log.header();
    let of_other = |what: &str| Failure::Input(format!("`{}`: {what}; update the program", shown_path(path)));
    let policy: Policy = header.policy.parse().map_err(|_| of_other("its policy is not known"))?;
    let format = match &*header.format {
        "toml" => Format::Toml,
        "yaml" => Format::Yaml,
        _ => return Err(of_other("its workload is in a language that is not known")),
    };
    let source = Source::parse(header.workload.as_bytes(), format, Path::new(&header.file))?;
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &source.workload, policy.config())?;
    Ok(Opened { log, scheduler, plan, tasks })
}

impl Opened {
    fn replay(&mut self, watch: impl FnMut(&Scheduler<Robot>, &Entry)) -> Result<Replay, LogError> {
        let Self { log, scheduler, plan, tasks, .. } = self;
        let change = |scheduler: &mut Scheduler<Robot>, number: u32, now| {
            let change = plan.changes.get(number as usize).ok_or(red_core::CommitError::UnknownTask)?;
            build::apply(scheduler, change, tasks[change.task], now)
        };
        replay(log, scheduler, change, watch)
    }
}

fn differs(difference: &Difference) -> Differs {
    Differs {
        input: difference.input,
        at_ns: difference.recorded.now.as_nanos(),
        call: difference.recorded.call.to_string(),
        recorded: difference.recorded.answer.to_string(),
        replayed: difference.now.to_string(),
        before: difference.before.iter().map(Entry::to_string).collect(),
    }
}

fn text(header: &Header, report: &Report) -> String {
    let Report { inputs, actions, .. } = report;
    let lanes = if header.realtime { "in real time" } else { "best effort" };
    let recorded = format!(
        "recorded by {}: {} under policy {}, {} {lanes}",
        header.program,
        header.file.escape_debug(),
        header.policy,
        time(Some(header.duration_ns))
    );
    let Some(difference) = &report.difference else {
        return format!("{recorded}\n{inputs} inputs fed, {actions} actions compared: no difference");
    };
    let mut text = format!("{recorded}\ninput {} differs, after {actions} equal actions\n", difference.input);
    for line in &difference.before {
        let _infallible = write!(text, "\n    {line}");
    }
    let Differs { at_ns, call, recorded, replayed, .. } = difference;
    let _infallible =
        write!(text, "\n  > {at_ns} ns  {call}\n      recorded: {recorded}\n      replayed: {replayed}");
    text
}
