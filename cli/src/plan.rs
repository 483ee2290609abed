//! `redrt plan`: whether a workload fits, why, and what would make it fit.

mod text;

pub(crate) use text::of_limit;

use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{self, Force, Place, Places};
use crate::progress;
use crate::terminal::{self, wrap};
use red_certificate::Certificate;
use red_sim::{Execution, Lab, Options, simulate};
use red_workload::model::{Arrival, Workload};
use red_workload::plan::{Admission, Guarantee, Plan, cures, division, plan};
use red_workload::policy::Policy;
use std::io;
use std::path::PathBuf;

/// Shortest simulation that counts as evidence, unless it would be too long.
const EVIDENCE_NS: u64 = 60_000_000_000;
/// Longest simulation in sub-jobs: a few seconds.
const MOST_SUB_JOBS: u128 = 2_000_000;

/// Plans a workload: sub-deadlines by every rule, bounds, and whether it fits.
#[derive(clap::Args)]
#[command(after_help = "Exit status 0 if it fits, 1 if it does not.

Example:
  redrt plan examples/cruise.toml")]
pub(crate) struct Args {
    /// Workload file, TOML or YAML.
    file: PathBuf,
    /// Write the certificate to this file, for `redrt verify`.
    #[arg(long, value_name = "FILE.json")]
    certificate: Option<PathBuf>,
    #[command(flatten)]
    force: Force,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Plans and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let workload = red_workload::load(&args.file)?;
    let mut places = Places::new(&args.force, Failure::Machine).but(place::WORKLOAD, &args.file);
    let mut place = |path: &PathBuf| places.add("certificate", "--certificate", path);
    let place = args.certificate.as_ref().map(&mut place).transpose()?;
    let (plan, mut why) = planned(&workload)?;
    if let Some(place) = &place {
        write(place, &plan.certificate)?;
    }
    if why.is_empty() {
        why = text::refusal(&plan, &cures::<Lab>(&workload, &plan));
    }
    if args.json {
        output::json(&plan)?;
        why.iter().for_each(|line| output::note(line));
    } else {
        let text = text::text(&workload, &plan, &why);
        output::line(&if terminal::moves(&io::stdout()) { wrapped(&text) } else { text })?;
    }
    Ok(Answer::of(plan.admission.fits))
}

/// A plan with the evidence of a simulation, and why it does not fit where only that shows it.
fn planned(workload: &Workload) -> Result<(Plan, Vec<String>), Failure> {
    let mut plan = progress::during("planning", || plan::<Lab>(workload))?;
    plan.division = progress::during("looking for a division", || division::<Lab>(workload, &plan))?;
    let mut why = Vec::new();
    if plan.admission.fits && plan.admission.guarantee != Guarantee::Analytic {
        match progress::during("simulating", || simulated(workload))? {
            Seen::OnTime => plan.admission.guarantee = Guarantee::Empirical,
            Seen::TooLittle => plan.admission.guarantee = Guarantee::BestEffort,
            Seen::Missed(missed) => {
                why = missed.refuse(&mut plan.admission);
            }
        }
    }
    Ok((plan, why))
}

/// A plan as `--json` prints it.
pub(crate) fn value(workload: &Workload) -> Result<serde_json::Value, Failure> {
    let (plan, _) = planned(workload)?;
    serde_json::to_value(&plan).map_err(|error| Failure::Machine(format!("cannot write the plan: {error}")))
}

fn write(place: &Place, certificate: &Certificate) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(certificate)
        .map_err(|error| Failure::Machine(format!("cannot write the certificate as JSON: {error}")))?;
    place.write_text(&(text + "\n"))
}

/// Prose for a terminal: broken between words. Tables stay whole.
fn wrapped(text: &str) -> String {
    let line = |line: &str| if line.trim_start().contains("  ") { line.to_owned() } else { wrap(line, 4) };
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// What a simulation under the default policy at WCET shows.
enum Seen {
    /// At least one job of each task, after every event too, and all of them on time.
    OnTime,
    /// Not every task, or not every event.
    TooLittle,
    Missed(Missed),
}

/// The task that missed most.
struct Missed {
    task: String,
    jobs: u64,
    of: u64,
    tardiness_ns: u64,
}

impl Missed {
    /// A job that misses shows that the workload does not fit, whatever the tests say. Why, in lines.
    fn refuse(self, admission: &mut Admission) -> Vec<String> {
        let Self { task, jobs, of, tardiness_ns } = self;
        admission.fits = false;
        admission.guarantee = Guarantee::BestEffort;
        admission.binding = format!("deadlines of task `{task}` in a simulation");
        // Jobs that were given up have no finish: late by something.
        admission.margin_ns = -i128::from(tardiness_ns.max(1));
        vec![
            format!(
                "does not fit: every bound holds, but in a simulation at WCET under redrt task `{task}` misses {jobs} of {of} \
                 deadlines"
            ),
            "other offsets may miss fewer or more; `redrt sim FILE --schedule` shows where".to_owned(),
        ]
    }
}

fn simulated(workload: &Workload) -> Result<Seen, Failure> {
    let horizon_ns = horizon_ns(workload);
    let options = Options {
        policy: Policy::default(),
        horizon_ns,
        seed: 1,
        execution: Execution::Wcet,
        preempt: false,
        schedule: false,
    };
    let report = simulate(workload, &options)?;
    let sees_events = workload.events.iter().all(|event| event.at_ns < horizon_ns);
    let missed = report.tasks.iter().filter(|task| task.missed > 0).max_by_key(|task| task.missed);
    Ok(match missed {
        Some(task) => Seen::Missed(Missed {
            task: task.name.clone(),
            jobs: task.missed,
            of: task.released,
            tardiness_ns: task.tardiness_ns.max.unwrap_or(0),
        }),
        None if sees_events && report.tasks.iter().all(|task| task.on_time > 0) => Seen::OnTime,
        None => Seen::TooLittle,
    })
}

/// Past the last event by two jobs of every task; shorter where that would take too long.
fn horizon_ns(workload: &Workload) -> u64 {
    let period = |arrival| match arrival {
        Arrival::Periodic { period_ns: t } | Arrival::Sporadic { min_interarrival_ns: t } => Some(t),
        Arrival::Once => None,
    };
    let last_event = workload.events.iter().map(|event| event.at_ns).max().unwrap_or(0);
    let two_jobs = workload.tasks.iter().map(|task| {
        let jobs = period(task.arrival).unwrap_or(0).saturating_mul(2).saturating_add(task.deadline_ns);
        jobs.saturating_add(task.offset_ns).saturating_add(1)
    });
    let wanted = last_event.saturating_add(two_jobs.max().unwrap_or(0)).max(EVIDENCE_NS);
    let sub_jobs = workload.tasks.iter().enumerate().map(|(i, task)| {
        let added = workload.events.iter().filter(|event| event.task == i).flat_map(|event| &event.add);
        let nodes = (task.nodes.len() + added.count()) as u128;
        nodes * period(task.arrival).map_or(1, |period| u128::from(wanted / period) + 1)
    });
    let affordable = u128::from(wanted) * MOST_SUB_JOBS / sub_jobs.sum::<u128>().max(MOST_SUB_JOBS);
    u64::try_from(affordable).unwrap_or(wanted)
}
