//! `redrt doctor`: what this machine does to real time, and the cure.

use crate::executable;
use crate::outcome::{Answer, Failure};
use crate::output;
use crate::progress;
use crate::terminal::{self, Paint, wrap};
use red_rt::preflight::{Finding, Severity, device, examine, measure};
use serde::Serialize;
use std::io;
use std::path::Path;
use std::time::Duration;

/// Long enough for the housekeeping of a kernel to show.
const MEASUREMENT: Duration = Duration::from_secs(5);

/// Checks every real-time precondition of this machine; each finding has its fix.
#[derive(clap::Args)]
#[command(after_help = "Exit status 1 if a check fails: the runtime would refuse to run in real time.

Example:
  redrt doctor --quick")]
pub(crate) struct Args {
    /// Only read settings; leave out the measurement of 5 seconds, and what the CUDA driver tells.
    #[arg(long)]
    quick: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Everything that was found.
#[derive(Serialize)]
struct Report<'a> {
    pass: usize,
    warn: usize,
    fail: usize,
    findings: Vec<Line<'a>>,
}

/// One finding.
#[derive(Serialize)]
struct Line<'a> {
    id: &'a str,
    severity: &'static str,
    value: &'a str,
    why: &'a str,
    fix: &'a str,
}

/// Examines, measures and reports.
pub(crate) fn main(args: &Args) -> Result<Answer, Failure> {
    let mut findings = examine(Path::new("/"));
    if !args.quick {
        findings.extend(progress::during("measuring for 5 s", || measure(MEASUREMENT)));
        findings.push(device());
    }
    findings.iter_mut().for_each(|finding| finding.fix = executable::named_in(&finding.fix));
    let report = report(&findings);
    if args.json {
        output::json(&report)?;
    } else {
        // Programs that read along get one line for each finding.
        let shown = if terminal::moves(&io::stdout()) { on_terminal } else { Finding::to_string };
        let lines: String = findings.iter().map(|finding| shown(finding) + "\n").collect();
        output::line(&format!("{lines}{} pass, {} warn, {} fail", report.pass, report.warn, report.fail))?;
    }
    Ok(Answer::of(report.fail == 0))
}

/// A finding for people: what has to be mended stands out, with its reason and its cure on lines of their own.
fn on_terminal(finding: &Finding) -> String {
    let paint = Paint::on(&io::stdout());
    let severity = match finding.severity {
        Severity::Pass => paint.green("PASS"),
        Severity::Warn => paint.yellow("WARN"),
        Severity::Fail => paint.red("FAIL"),
    };
    let head = format!("{severity} {}", wrap(&format!("{}: {}", finding.id, finding.value), 7));
    if finding.severity == Severity::Pass {
        return head;
    }
    format!("{head}\n       {}\n       {}", wrap(finding.why, 7), wrap(&format!("fix: {}", finding.fix), 7))
}

fn report<'a>(findings: &'a [Finding]) -> Report<'a> {
    let count = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
    let line = |finding: &'a Finding| Line {
        id: finding.id,
        severity: match finding.severity {
            Severity::Pass => "pass",
            Severity::Warn => "warn",
            Severity::Fail => "fail",
        },
        value: &finding.value,
        why: finding.why,
        fix: &finding.fix,
    };
    Report {
        pass: count(Severity::Pass),
        warn: count(Severity::Warn),
        fail: count(Severity::Fail),
        findings: findings.iter().map(line).collect(),
    }
}
