//! The report of both runs, from their logs.

use crate::happened;
use crate::outcome::Failure;
use crate::paper::real::PAPER;
use crate::place::Place;
use crate::report::{self, Answer, Found, Report};
use crate::session::{RunSummary, Session};
use red_report::page::{self, Compared};
use serde::Serialize;

#[derive(Serialize)]
struct Runs {
    runs: Vec<Answer>,
}

/// Writes the page of these runs. `tries`: whether changes are tried that would have saved the jobs that missed.
pub(super) fn write(place: &Place, sessions: &[Session], tries: bool) -> Result<(), Failure> {
    let (mut runs, mut answers, mut head) = (Vec::new(), Vec::new(), None);
    for session in sessions {
        let Some(log) = &session.record else { continue };
        match report::follow(log.path(), place.path(), tries, &session.summary.report.pools)? {
            Found::Equal(report) => {
                let Report { mut run, answer, head: made } = *report;
                run.facts.extend(
                    happened::notes(&session.summary).into_iter().map(|note| ("machine".to_owned(), note)),
                );
                runs.push(run);
                answers.push(answer);
                head.get_or_insert(made);
            }
            Found::Differs(input) => {
                return Err(Failure::Machine(format!(
                    "{} differs in replay at input {input}, so there is no report; `redrt replay` shows the difference",
                    log.path().display()
                )));
            }
        }
    }
    let mut head = head.unwrap_or_default();
    head.title = "Obstacle cruising under EDF and REDRT".to_owned();
    head.about =
        "Real networks on this machine, the same jobs under both policies; an obstacle comes and goes"
            .to_owned();
    head.command = "redrt demo".to_owned();
    head.data = report::to_json(&Runs { runs: answers })?;
    let summaries: Vec<&RunSummary> = sessions.iter().map(|session| &session.summary).collect();
    place.write_text(&page::of_runs(&head, &runs, &compared(&summaries)))
}

/// Both policies in what the paper compares its system with EDF in.
fn compared(runs: &[&RunSummary]) -> Vec<Compared> {
    let [latency, misses, quality] = PAPER.map(|percent| Some((percent, "RED against EDF".to_owned())));
    let of = |what: &str, unit: &str, paper_percent, less_is_better, value: &dyn Fn(&RunSummary) -> f64| {
        Compared {
            what: what.to_owned(),
            unit: unit.to_owned(),
            values: runs.iter().map(|run| (run.report.policy.to_uppercase(), value(run))).collect(),
            paper_percent,
            less_is_better,
        }
    };
    let task = |run: &RunSummary| run.report.tasks.first().cloned();
    vec![
        of("mean response time", "ms", latency, true, &|run| {
            task(run).and_then(|task| task.response_ns.mean).map_or(0.0, |ns| ns as f64 / 1e6)
        }),
        of("deadlines missed", "%", misses, true, &|run| {
            task(run)
                .map_or(0.0, |task| 100.0 * task.missed as f64 / (task.on_time + task.missed).max(1) as f64)
        }),
        of("quality of experience, lambda 1", "", quality, false, &|run| {
            task(run).and_then(|task| task.qoe.get("1").copied().flatten()).unwrap_or(0.0)
        }),
        of("encoder runs saved", "", None, false, &|run| run.report.encoder_runs_saved as f64),
    ]
}
