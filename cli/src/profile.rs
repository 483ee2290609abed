//! `redrt profile`: what the bodies of a workload cost on this machine, written into a copy of its file.
//!
//! ```text
//! file -> bodies on lanes -> times alone, against co-runners, of whole pools -> figures -> copy of the file
//! ```

mod edit;
mod figures;
mod lanes;
mod machine;
mod measure;
mod runner;
mod streams;

use crate::executable;
use crate::options;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{self, Force};
use crate::session::SessionError;
use crate::session::bodies::Bodies;
use crate::session::cuda::CudaPools;
use figures::{Report, Summary};
use lanes::{Bounds, Lanes, Place, Trouble};
use machine::Machine;
use measure::{Bench, Measured, Node};
use red_bodies::plugin::Host as PluginHost;
use red_core::{Duration, Empty, Scheduler};
use red_rt::setup;
use red_rt::stop::StopSignals;
use red_workload::build;
use red_workload::model::Body;
use red_workload::policy::Policy;
use red_workload::{Format, Source};
use runner::Runner;
use std::fs;
use std::path::PathBuf;
use std::sync::Arc;

/// Room for every workload file.
use crate::session::Robot as Room;

/// Measures the bodies of a workload on this machine and writes the times into a copy of its file.
#[derive(clap::Args)]
#[command(after_help = "\
Every node runs alone on a CPU, then against the nodes of the largest memory on all other CPUs; then all nodes of a \
pool run on one CPU and on all of them, which gives rho. Nodes of a pool of kind cuda run on streams instead, of which \
there are the pool's lanes and at least 4, and events on the device say what they took, copies included. The copy has `wcet` (largest time alone, and the margin), \
`bcet` (smallest), `contention` of atomic nodes (largest against the others less largest alone) and `lanes` of pools \
(rho rounded down, at least 1); the rest of the file stays as it is. rho has two decimals, and a pool that names its \
`cpus` is measured on these. YAML is refused: convert it to TOML, whose comments can be kept.
Ctrl-C ends it, with nothing written and exit status 1. Without real-time rights: exit status 3, with the fix.

Example:
  redrt profile examples/cruise.toml --out examples/cruise.here.toml")]
pub(crate) struct Args {
    /// Workload file, TOML.
    file: PathBuf,
    /// The copy; by default NAME.profiled.toml beside NAME.toml.
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Runs per measurement.
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    runs: u32,
    /// Time per measurement (two for each node, two for each pool); three runs are made in any case.
    #[arg(long, value_name = "TIME", default_value = "2s", allow_hyphen_values = true, value_parser = options::time_ns)]
    budget: u64,
    /// Longest time of one run; a body that takes longer counts as hung.
    #[arg(long, value_name = "TIME", default_value = "10s", allow_hyphen_values = true, value_parser = options::time_ns)]
    timeout: u64,
    /// What the WCET is above the largest time that was seen.
    #[arg(long, value_name = "PERCENT", default_value = "20%", value_parser = percent)]
    margin: u64,
    /// Go on without real-time rights; every output says so.
    #[arg(long)]
    best_effort: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// A share such as `20%`.
fn percent(text: &str) -> Result<u64, String> {
    let number = text.strip_suffix('%').and_then(|digits| digits.parse().ok());
    number
        .filter(|percent| *percent <= 1_000)
        .ok_or_else(|| "expected a whole percentage up to 1000%, such as 20%".to_owned())
}

/// Measures and writes.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let source = Source::load(&args.file)?;
    let workload = &source.workload;
    if Format::of(&args.file) == Format::Yaml {
        let why = "the file is YAML, and profile writes TOML, where it can keep comments; convert it to TOML, which \
                   has the same keys";
        return Err(Failure::Input(why.to_owned()));
    }
    let out = args.out.clone().unwrap_or_else(|| args.file.with_extension("profiled.toml"));
    let place = place::beside(&source, &args.force).add("copy", "--out", &out)?;
    let text = fs::read_to_string(&args.file)
        .map_err(|e| Failure::Input(format!("the file cannot be read as text: {e}")))?;

    let Some((measured, machine)) = measure(args, &source)? else {
        output::note("stopped; nothing was written");
        return Ok(Answer::No);
    };
    let summary = Summary { workload, measured: &measured, machine: &machine, margin_percent: args.margin };
    let header = summary.header(&args.file);
    let written = edit::rewrite(&text, workload, &summary.times(), &summary.lanes(), &header)?;
    // What is written must be a workload: everything downstream reads it.
    red_workload::parse(written.as_bytes(), Format::Toml, &out.to_string_lossy())?;
    place.write_text(&written)?;
    let has_path = |node: &Node| !matches!(node.part.body, Body::Spin { .. });
    if out.parent() != args.file.parent() && measured.nodes.iter().any(has_path) {
        output::note("the copy is in another folder, and the paths of its bodies are relative to that one");
    }
    let report = Report::new(&summary, &out);
    if args.json {
        output::json(&report)?;
    } else {
        output::line(&report.text())?;
    }
    Ok(Answer::Yes)
}

/// Loads the bodies and measures them; nothing if a signal came first.
fn measure(args: &Args, source: &Source) -> Result<Option<(Measured, Machine)>, Failure> {
    let source = &streams::widened(source);
    let workload = &source.workload;
    // What the machine lacks comes before what its bodies lack.
    let cuda = CudaPools::open(workload)?;
    let mut scheduler: Box<Scheduler<Room>> = Box::new(Scheduler::EMPTY);
    let (plan, _) = build::admit(&mut scheduler, workload, Policy::Redrt.config())?;
    let stop = StopSignals::install().map_err(|e| Failure::Machine(e.to_string()))?;
    setup::malloc_for_real_time().map_err(|e| Failure::Machine(e.to_string()))?;
    // Nothing is released here, but a body that releases a task takes the way that it takes in a run.
    let host = PluginHost::new(|_| true);
    let bodies = Bodies::load(source, &plan.nodes, &host, None).map_err(SessionError::Bodies)?;
    let bodies = Arc::new(bodies);
    let on_device =
        cuda.as_ref().map(|cuda| streams::runners(cuda, source, &plan.nodes, &host)).transpose()?;
    let mut machine = Machine::take(workload, args.best_effort)?;
    machine.device = cuda.as_ref().map(|cuda| cuda.device_name().to_owned());
    if let Some(why) = &machine.denied {
        output::note(&executable::named_in(&format!("BEST EFFORT, not real time: {why}")));
    }
    // Held to the end; a machine without the device idles as deep as it likes, which doctor tells.
    let _awake = machine.realtime().then(setup::hold_cpu_dma_latency);
    let bounds = Bounds { runs: args.runs as usize, budget_ns: args.budget, timeout_ns: args.timeout };
    let on_host = (0..machine.cpus.len()).map(|lane| Runner::Host(bodies.handler(lane)));
    let runners = on_host.chain(on_device.into_iter().flatten()).collect();
    let measured = Lanes::with(runners, &machine, &stop, bounds, |lanes| {
        Bench { lanes, machine: &machine, workload, nodes: &plan.nodes }.measure()
    });
    let name = |place: Place| {
        let node = &plan.nodes[place.task][place.node.index()].name;
        format!("{}.{node}", workload.tasks[place.task].name)
    };
    match measured {
        Ok(measured) => Ok(Some((measured, machine))),
        Err(Trouble::Stopped) => Ok(None),
        Err(Trouble::Body(place, why)) => {
            let node = name(place);
            // A body that submitted nothing has said it; what it submitted is the driver's to tell.
            let said = cuda.and_then(|cuda| cuda.said().pop()).map(|(.., fault)| fault.told());
            let said = said.or(why.map(|error| error.to_string()));
            let said = said.map_or(String::new(), |said| format!(": {said}"));
            Err(Failure::Input(format!(
                "the body of node `{node}` fails here{said}; `redrt profile` needs bodies that run to their end"
            )))
        }
        Err(Trouble::Hung(place)) => {
            let (node, timeout) = (name(place), Duration::from_nanos(args.timeout));
            // What a stream that hangs uses is left to it.
            std::mem::forget(cuda);
            Err(Failure::Input(format!(
                "the body of node `{node}` did not return within {timeout}; mend the body, or give it longer with \
                 --timeout"
            )))
        }
        Err(Trouble::Setup(e)) => Err(Failure::Machine(e.to_string())),
        Err(Trouble::Thread(e)) => Err(Failure::Machine(e.to_string())),
    }
}
