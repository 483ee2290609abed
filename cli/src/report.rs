//! `redrt report`: a recorded run as one HTML file.

mod answer;
mod calls;
mod certificate;
mod collect;
mod graphs;
mod made;
mod rescue;
mod worlds;

use crate::outcome::{self, Failure};
use crate::output;
use crate::place::{Force, Places};
use crate::progress;
use crate::replay::refused::Refused;
use crate::replay::{self, Log, what_if};
use crate::table;
use answer::About;
pub(crate) use answer::Answer;
use calls::Followed;
use collect::Collector;
use red_record::class::{self, with_class};
use red_record::{Broken, Header, Replay};
use red_report::model::Run;
use red_report::page::{self, Head};
use red_sim::{Lab, PoolMetrics};
use red_workload::{shown, shown_path};
use rescue::Recorded;
use std::path::{Path, PathBuf};

/// Makes one HTML file of a recorded run: timeline, response times, and what each missed deadline was made of.
#[derive(clap::Args)]
#[command(after_help = "\
The page needs no network and no other file. For each job that missed it has the critical chain in pieces that add up to
the response, and the smallest of a list of single changes that would have saved it, found by simulating the recorded
releases and execution times. Exit status 1, and no page, where the log differs in replay; 2 where it is not whole; 3 where
the page cannot be written.

Example:
  redrt run examples/cruise.toml --duration 5s --record cruise.redlog
  redrt report cruise.redlog --out cruise.html")]
pub(crate) struct Args {
    /// Log of `redrt run --record`, or of a program that records its calls.
    log: PathBuf,
    /// Where the page goes; beside the log unless told.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object with the numbers of the page.
    #[arg(long)]
    json: bool,
}

/// A run that was followed to its end.
pub(crate) struct Report {
    /// What its page is made of.
    pub(crate) run: Run,
    /// What programs read.
    pub(crate) answer: Answer,
    /// Its title and what it says of itself.
    pub(crate) head: Head,
}

/// What became of a log.
pub(crate) enum Found {
    /// It is as it was.
    Equal(Box<Report>),
    /// It is not, from this input on.
    Differs(u64),
}

/// Follows a log, and writes its page.
pub(crate) fn main(args: &Args) -> Result<outcome::Answer, Failure> {
    let out = args.out.clone().unwrap_or_else(|| args.log.with_extension("html"));
    // What is no log is told before what is no place.
    drop(replay::read(&args.log).map_err(|refused| refused.tell(false, None, None))?);
    let mut places = Places::new(&args.force, Failure::Machine).but("log", &args.log);
    let place = places.add("page", "--out", &out)?;
    let followed = match follow(&args.log, &out, true, &[])? {
        Found::Equal(followed) => followed,
        Found::Differs(input) => {
            let log = shown_path(&args.log);
            output::note(&format!(
                "`{log}` differs in replay at input {input}, so no page is written from it; `redrt replay` shows the difference"
            ));
            return Ok(outcome::Answer::No);
        }
    };
    let Report { run, answer, mut head } = *followed;
    head.data = to_json(&answer)?;
    place.write_text(&page::of_runs(&head, &[run], &[]))?;
    let told = format!("report: {}", shown_path(&out));
    if args.json {
        output::line(&head.data)?;
        output::note(&told);
    } else {
        output::line(&told)?;
    }
    Ok(outcome::Answer::Yes)
}

/// As it stands in the page and on standard output.
pub(crate) fn to_json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string(value)
        .map_err(|e| Failure::Machine(format!("cannot write the answer as JSON: {e}")))
}

/// Follows a log to its end. `tries`: whether changes are tried that would have saved the jobs that missed. `measured`: pools as
/// their lanes saw them, where that is known; a log has when a unit was given to its lane, and not when that began.
pub(crate) fn follow(
    path: &Path,
    page: &Path,
    tries: bool,
    measured: &[PoolMetrics],
) -> Result<Found, Failure> {
    let refused = |refused: Refused| refused.tell(false, None, None);
    let log = replay::read(path).map_err(refused)?;
    let by_calls = log.header().config.is_some();
    if by_calls { of_calls(path, page, log) } else { of_workload(path, page, log, tries, measured) }
}

fn of_workload(
    path: &Path,
    page: &Path,
    log: Log,
    tries: bool,
    measured: &[PoolMetrics],
) -> Result<Found, Failure> {
    let mut opened = replay::set_up(path, log).map_err(|refused| refused.tell(false, None, None))?;
    let mut collector =
        Collector::new(&opened.workload, &opened.plan.nodes, &opened.scheduler, &opened.tasks);
    let found = progress::during("replaying", || {
        opened.replay_events(|scheduler, entry, events| collector.watch(scheduler, entry, events))
    });
    if let Some(input) = differs(path, found)? {
        return Ok(Found::Differs(input));
    }
    let header = opened.log.header().clone();
    let end_ns = collector.run.end_ns;
    let until_ns = header.duration_ns.min(end_ns);
    let (mut run, tasks, figures) =
        progress::during("explaining", || made::made(collector, until_ns, end_ns));
    for (pool, measured) in run.pools.iter_mut().zip(measured) {
        pool.busy_ns = measured.busy_ns;
    }
    if tries {
        let workload = &opened.workload;
        let horizon_ns = |changed: &_| {
            what_if::horizon_ns(header.duration_ns, end_ns, figures.left_open, [workload, changed])
        };
        let recorded =
            Recorded { workload, policy: opened.policy, figures: &figures, horizon_ns: &horizon_ns };
        progress::during("trying changes", || rescue::find(&mut run, &recorded, || true));
    }
    if let Ok(plan) = red_workload::plan::plan::<Lab>(&opened.workload) {
        run.certificate = certificate::words(&plan);
    }
    Ok(told(run, tasks, until_ns, &header, path, page))
}

fn of_calls(path: &Path, page: &Path, mut log: Log) -> Result<Found, Failure> {
    let header = log.header().clone();
    let mut collector = Collector::by_calls();
    let found = progress::during("replaying", || {
        with_class(header.capacities, Followed { log: &mut log, collector: &mut collector })
    });
    let found = found.ok_or_else(|| {
        let message = format!(
            "it was recorded with capacities (tasks, nodes, jobs, lanes, pools) that this program does not have: {:?}; it has \
             {:?}; make its report with the program that recorded it",
            header.capacities,
            class::ALL
        );
        Refused::new(path, "capacities", message).tell(false, None, None)
    })?;
    if let Some(input) = differs(path, found)? {
        return Ok(Found::Differs(input));
    }
    // Nobody said until when jobs come: all of them count, and the last end is in time.
    let end_ns = collector.run.end_ns.saturating_add(1);
    let (mut run, tasks, _) = made::made(collector, end_ns, end_ns);
    run.tried_note = "The log was set up by calls and has no workload file in which something could be changed, so nothing was tried."
        .to_owned();
    Ok(told(run, tasks, end_ns - 1, &header, path, page))
}

/// The input from which on a replay differs.
fn differs(path: &Path, found: Result<Replay, Broken>) -> Result<Option<u64>, Failure> {
    let found = found.map_err(|broken| Refused::after(path, &broken).tell(false, None, Some(&broken)))?;
    Ok(found.difference.map(|difference| difference.input))
}

/// The run with what its header says.
fn told(
    mut run: Run,
    tasks: Vec<red_workload::metrics::TaskMetrics>,
    horizon_ns: u64,
    header: &Header,
    path: &Path,
    page: &Path,
) -> Found {
    let by_calls = header.config.is_some();
    run.policy = if by_calls { shown(&header.policy).to_string() } else { header.policy.clone() };
    let mode = match (header.realtime, by_calls) {
        (true, _) => "real time",
        (false, true) => "as its program had them",
        (false, false) => "BEST EFFORT, not real time",
    };
    let text = |path: &Path| path.to_string_lossy().into_owned();
    let name = |file: &str| {
        Path::new(file).file_name().map_or(file.to_owned(), |name| name.to_string_lossy().into_owned())
    };
    let file = if by_calls { text(path) } else { header.file.clone() };
    let time = |ns| table::time(Some(ns));
    let fact = |title: &str, value: String| (title.to_owned(), value);
    run.facts = vec![
        fact("policy", run.policy.clone()),
        fact("lanes", mode.to_owned()),
        fact(if by_calls { "set up by calls, log" } else { "workload" }, file.clone()),
        fact("log", text(path)),
        fact("recorded by", header.program.clone()),
        fact("releases until", time(horizon_ns)),
        fact("ended at", time(run.end_ns)),
        fact("jobs", run.jobs.iter().map(Vec::len).sum::<usize>().to_string()),
        fact("executions", run.slices.len().to_string()),
    ];
    let head = Head {
        title: name(&file),
        program: concat!("redrt ", env!("CARGO_PKG_VERSION")).to_owned(),
        about: format!("policy {}, {} recorded by {}, {mode}", run.policy, time(horizon_ns), header.program),
        data: String::new(),
        command: format!("redrt report {}", name(&text(path))),
    };
    let about = About {
        horizon_ns,
        realtime: header.realtime,
        program: header.program.clone(),
        file: header.file.clone(),
        log: text(path),
        report: text(page),
    };
    let answer = Answer::of(&run, tasks, about);
    Found::Equal(Box::new(Report { run, answer, head }))
}
