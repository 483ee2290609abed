//! `redrt plan`: whether a workload fits, why, and what would make it fit.

mod between;
mod compare;
mod evidence;
mod judge;
mod overload;
mod text;

pub(crate) use text::of_limit;

use crate::outcome::{Answer, Failure};
use crate::output;
use crate::place::{Force, Place, Places};
use crate::progress;
use crate::terminal::{self, wrap};
use evidence::{MOST_SUB_JOBS, Seen};
use judge::Verdict;
use overload::Overload;
use red_certificate::Certificate;
use red_sim::Lab;
use red_workload::Source;
use red_workload::model::Workload;
use red_workload::plan::{Guarantee, Plan, cures, division, plan};
use std::io;
use std::path::PathBuf;

/// Plans a workload: sub-deadlines by every rule, bounds, and whether it fits.
#[derive(clap::Args)]
#[command(after_help = "Exit status 0 if it fits, 1 if it does not.

Where it does not fit, it lists changes that make it fit, each of them planned again, and what each task will lose
until then, from a simulation of the scheduler.

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
    let source = Source::load(&args.file)?;
    let mut places = Places::new(&args.force, Failure::Machine).but_workload(&source);
    let workload = source.workload;
    let mut place = |path: &PathBuf| places.add("certificate", "--certificate", path);
    let place = args.certificate.as_ref().map(&mut place).transpose()?;
    let (planned, mut why) = planned(&workload)?;
    let plan = &planned.plan;
    if let Some(place) = &place {
        write(place, &plan.certificate)?;
    }
    if !plan.admission.fits {
        why.extend(remedies(&workload, plan));
    }
    if args.json {
        output::json(&planned)?;
        why.iter().for_each(|line| output::note(line));
    } else {
        let text = text::text(&workload, &planned, &why);
        output::line(&if terminal::moves(&io::stdout()) { wrapped(&text) } else { text })?;
    }
    Ok(Answer::of(plan.admission.fits))
}

/// A plan, and what it predicts, as `--json` prints it.
#[derive(serde::Serialize)]
struct Planned {
    #[serde(flatten)]
    plan: Plan,
    overload: Option<Overload>,
}

/// A plan with everything that is looked for beside it, and why it does not fit where it does not.
fn planned(workload: &Workload) -> Result<(Planned, Vec<String>), Failure> {
    let (mut plan, why) = progress::during("planning", || judged(workload))?;
    plan.division = progress::during("looking for a division", || {
        division::<Lab>(workload, &plan, |divided| compare::is_no_worse(workload, &plan, divided))
    })?;
    let overload = progress::during("simulating", || Overload::predicted(workload, &plan))?;
    Ok((Planned { plan, overload }, why))
}

/// A plan with the evidence of a simulation, where that matters, and why it does not fit where it does not.
fn judged(workload: &Workload) -> Result<(Plan, Vec<String>), Failure> {
    let mut plan = plan::<Lab>(workload)?;
    if !plan.admission.fits {
        let why = text::refusal(&plan);
        return Ok((plan, why));
    }
    let mut why = Vec::new();
    if plan.admission.guarantee != Guarantee::Analytic {
        match evidence::seen(workload, MOST_SUB_JOBS)? {
            Seen::OnTime => plan.admission.guarantee = Guarantee::Empirical,
            Seen::TooLittle => plan.admission.guarantee = Guarantee::BestEffort,
            Seen::Missed(missed) => why = missed.refuse(&mut plan.admission),
        }
    }
    Ok((plan, why))
}

/// What makes it fit, in lines. Each change was made in a copy, and that planned.
fn remedies(workload: &Workload, plan: &Plan) -> Vec<String> {
    let mut verdict = Verdict::new();
    let found =
        progress::during("looking for what makes it fit", || cures::<Lab>(workload, plan, &mut verdict));
    text::remedies(&found, verdict.is_cut_short())
}

/// A plan as `--json` prints it.
pub(crate) fn value(workload: &Workload) -> Result<serde_json::Value, Failure> {
    let (planned, _) = planned(workload)?;
    serde_json::to_value(&planned)
        .map_err(|error| Failure::Machine(format!("cannot write the plan: {error}")))
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
