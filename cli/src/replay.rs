//! `redrt replay`: a recorded run fed to the scheduler again.

mod recorded;
mod what_if;

use crate::outcome::{Answer, Failure};
use crate::output;
use crate::progress;
use crate::regular;
use crate::session::Robot;
use crate::table::time;
use recorded::Recorded;
use red_core::{Empty, Instant, Scheduler, TaskId, UnitId};
use red_record::{Difference, Entry, Header, LogError, Reader, Replay, replay};
use red_sim::{Execution, Options, Report, simulate_past};
use red_workload::build::{self, Plan};
use red_workload::model::Workload;
use red_workload::policy::Policy;
use red_workload::{Format, Source, shown, shown_path};
use serde::Serialize;
use std::fmt::Write;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use what_if::Change;

/// Feeds the inputs of a recorded run to the scheduler again, and compares every action.
#[derive(clap::Args)]
#[command(after_help = "\
Exit status 1, with the first difference, where an action is not as it was recorded. --what-if simulates the
recorded releases and execution times with something changed: policy=POLICY, deadline=TIME or deadline.TASK=TIME,
lanes=N or lanes.POOL=N, several with commas.

Example:
  redrt run examples/cruise.toml --duration 5s --record cruise.redlog
  redrt replay cruise.redlog
  redrt replay cruise.redlog --what-if policy=edf,lanes=2")]
pub(crate) struct Args {
    /// Log of `redrt run --record`.
    log: PathBuf,
    /// Simulate what would have happened with these changes.
    #[arg(long, value_name = "CHANGES", value_delimiter = ',', num_args = 1)]
    what_if: Vec<Change>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// A replay in numbers.
#[derive(Serialize)]
struct Compared {
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

/// Both runs, each with the keys of `sim --json`.
#[derive(Serialize)]
struct Both {
    recorded: Report,
    what_if: Report,
}

/// A log whose run is set up again.
pub(crate) struct Opened {
    log: Reader<BufReader<File>>,
    workload: Workload,
    policy: Policy,
    scheduler: Box<Scheduler<Robot>>,
    plan: Plan<Robot>,
    tasks: Vec<TaskId>,
}

/// Replays and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let mut opened = open(&args.log)?;
    let mut recorded = Recorded::new(&opened);
    let found =
        progress::during("replaying", || opened.replay(|scheduler, entry| recorded.watch(scheduler, entry)))
            .map_err(|e| refused(&args.log, &e))?;
    if found.difference.is_none() && !args.what_if.is_empty() {
        return answer_what_if(args, &opened, &recorded);
    }
    let header = opened.log.header();
    let report = Compared {
        policy: header.policy.clone(),
        inputs: found.inputs,
        actions: found.actions,
        equal: found.difference.is_none(),
        difference: found.difference.as_ref().map(|difference| differs(difference, &recorded, &opened)),
    };
    if args.json {
        output::json(&report)?;
    } else {
        output::line(&text(header, &report))?;
    }
    Ok(Answer::of(report.equal))
}

/// What would have happened.
fn answer_what_if(args: &Args, opened: &Opened, recorded: &Recorded) -> Result<Answer, Failure> {
    let (mut workload, mut policy) = (opened.workload.clone(), opened.policy);
    what_if::apply(&args.what_if, &mut workload, &mut policy).map_err(Failure::Input)?;
    let duration_ns = opened.log.header().duration_ns;
    let longest = workload.tasks.iter().map(|task| task.deadline_ns).max().unwrap_or(0);
    let options = Options {
        policy,
        // As a run drains.
        horizon_ns: duration_ns.saturating_add(longest),
        seed: 0,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    };
    let what_if = progress::during("simulating", || simulate_past(&workload, &recorded.past, &options))?;
    let recorded = recorded.report(opened, Instant::from_nanos(duration_ns));
    if args.json {
        output::json(&Both { recorded, what_if })?;
    } else {
        output::line(&what_if::text(&recorded, &what_if))?;
    }
    Ok(Answer::Yes)
}

fn refused(path: &Path, error: &LogError) -> Failure {
    Failure::Input(format!("`{}`: {error}", shown_path(path)))
}

fn open(path: &Path) -> Result<Opened, Failure> {
    let unreadable = |e| refused(path, &LogError::Read(e));
    let _or_missing = regular::exists(path).map_err(unreadable)?;
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
    Ok(Opened { log, workload: source.workload, policy, scheduler, plan, tasks })
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

fn differs(difference: &Difference, watched: &Recorded, opened: &Opened) -> Differs {
    let with_name = |text: String, unit: Option<UnitId>| {
        let name = unit.and_then(|unit| watched.name_of(unit, &opened.scheduler));
        name.map_or_else(|| text.clone(), |name| format!("{text}: {name}"))
    };
    Differs {
        input: difference.input,
        at_ns: difference.recorded.now.as_nanos(),
        call: with_name(difference.recorded.call.to_string(), difference.recorded.call.unit()),
        // A unit that the scheduler did not start now has no name.
        recorded: difference.recorded.answer.to_string(),
        replayed: with_name(difference.now.to_string(), difference.now.unit()),
        before: difference
            .before
            .iter()
            .map(|entry| with_name(entry.to_string(), entry.call.unit().or(entry.answer.unit())))
            .collect(),
    }
}

fn text(header: &Header, report: &Compared) -> String {
    let Compared { inputs, actions, .. } = report;
    let lanes = if header.realtime { "in real time" } else { "best effort" };
    let recorded = format!(
        "recorded by {}: {} under policy {}, {} {lanes}",
        shown(&header.program),
        shown(&header.file),
        shown(&header.policy),
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
