//! `redrt replay`: a recorded run fed to the scheduler again.

mod calls;
pub(crate) mod figures;
mod names;
pub(crate) mod refused;
pub(crate) mod what_if;

use crate::kept;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::progress;
use crate::regular;
use crate::session::Robot;
use crate::table::time;
use figures::Figures;
use names::Names;
use red_core::{Capacity, Empty, Event, Instant, Scheduler, TaskId, UnitId};
use red_record::{Broken, Difference, Entry, Header, LogError, Reader, Replay, replay_events};
use red_sim::{Execution, Options, Past, Report, simulate_past};
use red_workload::build::{self, Plan};
use red_workload::metrics::TaskMetrics;
use red_workload::model::Workload;
use red_workload::policy::Policy;
use red_workload::{Format, Source, shown};
use refused::Refused;
use serde::Serialize;
use std::fmt::Write;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};
use what_if::Change;

/// Feeds the inputs of a recorded run to the scheduler again, and compares every action.
#[derive(clap::Args)]
#[command(after_help = "\
Exit status 1, with the first difference, where an action is not as it was recorded; 2 where the log is not whole:
what it has is fed, and a difference in that is told first. --what-if simulates the
recorded releases and execution times with something changed: policy=POLICY, deadline=TIME or deadline.TASK=TIME,
lanes=N or lanes.POOL=N, several with commas.

Example:
  redrt run examples/cruise.toml --duration 5s --record cruise.redlog
  redrt replay cruise.redlog
  redrt replay cruise.redlog --what-if policy=edf,lanes=2

A log whose scheduler was set up by calls needs no workload: its tasks and nodes have numbers for names (task-0,
node-3), and --what-if is refused.")]
pub(crate) struct Args {
    /// Log of `redrt run --record`, or of a program that records its calls.
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
    policy: Option<String>,
    inputs: u64,
    actions: u64,
    /// `None`: the log could not be replayed to its end.
    equal: Option<bool>,
    difference: Option<Differs>,
    /// Why it could not.
    refused: Option<Refused>,
    /// How the jobs of each task ended; `None` where the replay differs, the log was set up by calls, or is too long.
    #[serde(skip_serializing_if = "Option::is_none")]
    tasks: Option<Vec<TaskMetrics>>,
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
    /// Nodes that took their WCET, because the recorded run never executed them.
    at_wcet: Vec<String>,
}

/// A log in a file.
pub(crate) type Log = Reader<BufReader<File>>;

/// A log whose workload is set up again.
pub(crate) struct Opened {
    pub(crate) log: Log,
    pub(crate) workload: Workload,
    pub(crate) policy: Policy,
    pub(crate) scheduler: Box<Scheduler<Robot>>,
    pub(crate) plan: Plan<Robot>,
    pub(crate) tasks: Vec<TaskId>,
}

/// Replays and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let refused = |refused: Refused| refused.tell(args.json, None, None);
    let log = read(&args.log).map_err(refused)?;
    if log.header().config.is_some() {
        return calls::main(args, log);
    }
    let mut opened = set_up(&args.log, log).map_err(refused)?;
    let (mut workload, mut policy_then) = (opened.workload.clone(), opened.policy);
    what_if::apply(&args.what_if, &mut workload, &mut policy_then).map_err(Failure::Input)?;
    let mut names = Names::new(&opened.workload, opened.plan.nodes.clone());
    let mut figures = Figures::new(&opened.workload, opened.plan.nodes.clone());
    let found = progress::during("replaying", || {
        opened.replay_events(|scheduler, entry, events| {
            names.watch(entry);
            figures.watch(scheduler, entry, events);
        })
    });
    let found = found.map_err(|broken| {
        let policy = Some(opened.log.header().policy.clone());
        Refused::after(&args.log, &broken).tell(args.json, policy, Some(&broken))
    })?;
    if found.difference.is_none() && !args.what_if.is_empty() {
        return answer_what_if(args, &opened, &figures, &workload, policy_then);
    }
    let tasks = found.difference.is_none().then(|| figures.tasks(&opened)).flatten();
    compared(args, opened.log.header(), &found, &names, &opened.scheduler, tasks)
}

/// Reports a log that was fed to its end, or to its first difference.
fn compared<C: Capacity>(
    args: &Args,
    header: &Header,
    found: &Replay,
    names: &Names,
    scheduler: &Scheduler<C>,
    tasks: Option<Vec<TaskMetrics>>,
) -> Result<Answer, Failure> {
    let equal = found.difference.is_none();
    let report = Compared {
        policy: Some(header.policy.clone()),
        inputs: found.inputs,
        actions: found.actions,
        equal: Some(equal),
        difference: found.difference.as_ref().map(|difference| differs(difference, names, scheduler)),
        refused: None,
        tasks,
    };
    if args.json {
        output::json(&report)?;
    } else {
        output::line(&text(header, &report))?;
    }
    Ok(Answer::of(equal))
}

/// What would have happened.
fn answer_what_if(
    args: &Args,
    opened: &Opened,
    figures: &Figures,
    workload: &Workload,
    policy: Policy,
) -> Result<Answer, Failure> {
    if figures.past.is_cut() {
        return Err(Failure::Input(format!(
            "--what-if: the log has more than {} releases and executions, the most that are simulated; record a shorter run",
            Past::LARGEST
        )));
    }
    let (duration_ns, end_ns) = (opened.log.header().duration_ns, figures.end.as_nanos());
    let options = Options {
        policy,
        horizon_ns: what_if::horizon_ns(duration_ns, end_ns, figures.left_open, [&opened.workload, workload]),
        seed: 0,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    };
    let (what_if, at_wcet) =
        progress::during("simulating", || simulate_past(workload, &figures.past, &options))?;
    let recorded = figures.report(opened, Instant::from_nanos(duration_ns.min(end_ns)));
    if args.json {
        output::json(&Both { recorded, what_if, at_wcet })?;
    } else {
        output::line(&what_if::text(&recorded, &what_if, &at_wcet))?;
    }
    Ok(Answer::Yes)
}

pub(crate) fn read(path: &Path) -> Result<Log, Refused> {
    let refused = |e| Refused::by(path, &e);
    let unreadable = |e| refused(LogError::Read(e));
    let _or_missing = regular::exists(path).map_err(unreadable)?;
    let file = File::open(path).map_err(unreadable)?;
    Reader::new(BufReader::new(file)).map_err(refused)
}

pub(crate) fn set_up(path: &Path, log: Log) -> Result<Opened, Refused> {
    let header = log.header();
    let of_other = |what: &str| Refused::new(path, "newer", format!("{what}; update the program"));
    let policy: Policy = header.policy.parse().map_err(|_| of_other("its policy is not known"))?;
    let format = match &*header.format {
        "toml" => Format::Toml,
        "yaml" => Format::Yaml,
        _ => return Err(of_other("its workload is in a language that is not known")),
    };
    let source = Source::parse(header.workload.as_bytes(), format, Path::new(&header.file))
        .map_err(|e| Refused::new(path, "workload", e))?;
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &source.workload, policy.config())
        .map_err(|e| Refused::new(path, "workload", e))?;
    Ok(Opened { log, workload: source.workload, policy, scheduler, plan, tasks })
}

impl Opened {
    /// Feeds the log again; `watch` also gets what the scheduler recorded at each entry.
    pub(crate) fn replay_events(
        &mut self,
        watch: impl FnMut(&Scheduler<Robot>, &Entry, &[Event]),
    ) -> Result<Replay, Broken> {
        let Self { log, scheduler, plan, tasks, .. } = self;
        let change = |scheduler: &mut Scheduler<Robot>, number: u32, now| {
            let change = plan.changes.get(number as usize).ok_or(red_core::CommitError::UnknownTask)?;
            build::apply(scheduler, change, tasks[change.task], now)
        };
        replay_events(log, scheduler, change, watch)
    }
}

fn differs<C: Capacity>(difference: &Difference, names: &Names, scheduler: &Scheduler<C>) -> Differs {
    let with = |text: String, name: Option<String>| match name {
        Some(name) => format!("{text}: {name}"),
        None => text,
    };
    let of_unit = |unit: Option<UnitId>| names.of_unit(unit?, scheduler);
    let answer = |answer: &red_record::Answer| match answer {
        red_record::Answer::Started(started) | red_record::Answer::Ahead(started) => {
            with(answer.to_string(), names.of_start(started))
        }
        _ => with(answer.to_string(), of_unit(answer.unit())),
    };
    let Difference { input, before, recorded, now } = difference;
    let entry = |entry: &Entry| with(entry.to_string(), of_unit(entry.call.unit().or(entry.answer.unit())));
    Differs {
        input: *input,
        at_ns: recorded.now.as_nanos(),
        call: with(recorded.call.to_string(), of_unit(recorded.call.unit())),
        recorded: answer(&recorded.answer),
        replayed: answer(now),
        before: before.iter().map(entry).collect(),
    }
}

fn text(header: &Header, report: &Compared) -> String {
    let Compared { inputs, actions, .. } = report;
    let lanes = if header.realtime { "in real time" } else { "best effort" };
    let (program, policy) = (shown(&header.program), shown(&header.policy));
    let recorded = if header.config.is_some() {
        format!("recorded by {program}: set up by calls, under policy {policy}, {lanes}")
    } else {
        let (file, time) = (shown(&header.file), time(Some(header.duration_ns)));
        format!("recorded by {program}: {file} under policy {policy}, {time} {lanes}")
    };
    let Some(difference) = &report.difference else {
        let tasks =
            report.tasks.as_ref().map(|tasks| format!("\n\n{}", kept::tasks(tasks))).unwrap_or_default();
        return format!("{recorded}\n{inputs} inputs fed, {actions} actions compared: no difference{tasks}");
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
