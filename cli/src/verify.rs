//! `redrt verify`: a certificate against the workload that it is about.

mod unique;

use crate::outcome::{Answer, Failure};
use crate::output;
use red_certificate::{Certificate, Guarantee, verify};
use red_sim::Lab;
use red_workload::plan::set;
use red_workload::shown_path;
use serde::Serialize;
use serde_json::Value;
use std::path::{Path, PathBuf};
use unique::Unique;

/// Size of the largest certificate, in bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Checks an admission certificate again, against the workload alone: no search, and nothing of the code that made it.
#[derive(clap::Args)]
#[command(after_help = "\
Exit status 0 if every statement of the certificate holds for the workload, 1 with the first that does not.

Example:
  redrt plan examples/cruise.toml --certificate cruise.certificate.json
  redrt verify cruise.certificate.json examples/cruise.toml")]
pub(crate) struct Args {
    /// Certificate of `redrt plan --certificate`, or what `redrt plan --json` printed.
    certificate: PathBuf,
    /// Workload file, TOML or YAML.
    file: PathBuf,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Verdict {
    holds: bool,
    /// Whether it proves every task.
    analytic: bool,
    margin_ns: Option<u64>,
    binding: String,
    /// What does not hold.
    rejected: Option<String>,
}

/// Checks and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let workload = red_workload::load(&args.file)?;
    let set = set::<Lab>(&workload)?;
    let value = read(&args.certificate)?;
    let is_plan = value.get("certificate").is_some();
    let stated = value.get("certificate").unwrap_or(&value).clone();
    let certificate: Result<Certificate, _> = serde_json::from_value(stated);
    let found = match &certificate {
        Err(error) => Err(format!("it is not written as a certificate is: {error}")),
        Ok(certificate) => verify(certificate, &set).map_err(|rejected| rejected.to_string()),
    };
    // Of a whole plan, the rest is what planning gives again.
    let found = found.and_then(|()| if is_plan { same_plan(&workload, &value) } else { Ok(()) });
    let analytic = certificate.as_ref().is_ok_and(Certificate::is_analytic);
    let verdict = Verdict {
        holds: found.is_ok(),
        analytic: found.is_ok() && analytic,
        margin_ns: certificate.as_ref().ok().and_then(|certificate| certificate.margin_ns),
        binding: certificate.as_ref().map(|certificate| certificate.binding.clone()).unwrap_or_default(),
        rejected: found.err(),
    };
    if args.json {
        output::json(&verdict)?;
    } else {
        output::line(&text(&verdict, certificate.as_ref().ok()))?;
    }
    Ok(Answer::of(verdict.holds))
}

fn read(path: &Path) -> Result<Value, Failure> {
    let shown = shown_path(path);
    let wrong = |error: String| {
        Failure::Input(format!("{shown}: {error}; give it a file that `redrt plan --certificate` wrote"))
    };
    let metadata = std::fs::metadata(path).map_err(|error| wrong(format!("cannot read it: {error}")))?;
    if !metadata.is_file() || metadata.len() > MOST_BYTES {
        return Err(wrong(format!("not a regular file of at most {} MiB", MOST_BYTES >> 20)));
    }
    let bytes = std::fs::read(path).map_err(|error| wrong(format!("cannot read it: {error}")))?;
    let Unique(value) = serde_json::from_slice(&bytes).map_err(|error| wrong(format!("no JSON: {error}")))?;
    if value.is_object() { Ok(value) } else { Err(wrong("no JSON object".to_owned())) }
}

fn same_plan(workload: &red_workload::model::Workload, stated: &Value) -> Result<(), String> {
    let again = crate::plan::value(workload).map_err(|_| "the workload cannot be planned".to_owned())?;
    let differs = again.as_object().into_iter().flatten().find(|(key, value)| stated.get(key) != Some(value));
    let more = stated.as_object().into_iter().flatten().find(|(key, _)| again.get(key).is_none());
    match differs.map(|(key, _)| key).or(more.map(|(key, _)| key)) {
        None => Ok(()),
        Some(key) => {
            Err(format!("`{key}` of the plan is not what planning the workload gives: plan it anew"))
        }
    }
}

fn text(verdict: &Verdict, certificate: Option<&Certificate>) -> String {
    if let Some(rejected) = &verdict.rejected {
        return format!("rejected: {rejected}");
    }
    let clusters = certificate.into_iter().flat_map(|certificate| &certificate.clusters).map(|cluster| {
        let worth = match cluster.guarantee {
            Guarantee::Analytic => "analytic: every job is in time",
            Guarantee::BestEffort => {
                "best effort: a task has no proof, or its jobs may be given up for one that has none"
            }
        };
        let name = if cluster.pool == cluster.name {
            cluster.name.clone()
        } else {
            format!("{}.{}", cluster.pool, cluster.name)
        };
        let lanes = if cluster.lanes == 1 { "1 lane".to_owned() } else { format!("{} lanes", cluster.lanes) };
        format!("\n  {name}, {lanes}, {}: {worth}", cluster.tasks.join(", "))
    });
    format!("every statement holds\n{}", clusters.collect::<String>().trim_start_matches('\n'))
}
