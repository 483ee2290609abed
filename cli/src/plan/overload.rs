//! What a workload that does not fit will lose, before anything runs: the scheduler itself, in virtual time.

mod losses;
mod reason;

use super::between::Between;
use super::evidence;
use crate::outcome::Failure;
use crate::table::Table;
use losses::Losses;
use reason::Asked;
use red_core::Duration;
use red_sim::{Options, simulate};
use red_workload::model::Workload;
use red_workload::plan::Plan;
use serde::Serialize;

/// Periods of the slowest task that are simulated, unless these are too many sub-jobs.
const PERIODS: u64 = 20;
/// Longest simulation in sub-jobs: a second or less.
const MOST_SUB_JOBS: u128 = 300_000;

/// What is predicted to be lost. Field names and their order are a contract.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Overload {
    horizon_ns: u64,
    tasks: Vec<Predicted>,
    /// The same where nodes take anything from their `bcet` to their WCET; nothing where the file has none.
    from_bcet: Option<Vec<Losses>>,
}

/// What one task is predicted to lose.
#[derive(Clone, Debug, Serialize)]
struct Predicted {
    #[serde(flatten)]
    losses: Losses,
    reason: String,
}

impl Overload {
    /// Of a workload whose `plan` says no; nothing where no job is predicted to be lost.
    pub(super) fn predicted(workload: &Workload, plan: &Plan) -> Result<Option<Self>, Failure> {
        if plan.admission.fits {
            return Ok(None);
        }
        let options = options(workload);
        let losses = losses::of(simulate(workload, &options)?);
        let from_bcet = match Between::of(workload, options.seed) {
            Some(world) => Some(losses::of(world.simulate(&options)?)),
            None => None,
        };
        if losses.iter().chain(from_bcet.iter().flatten()).all(|task| task.lost() == 0) {
            return Ok(None);
        }
        let asked = Asked::of(workload, plan, [&losses, from_bcet.as_deref().unwrap_or_default()]);
        let mut tasks = Vec::with_capacity(losses.len());
        for (i, losses) in losses.into_iter().enumerate() {
            let between = from_bcet.as_ref().and_then(|tasks: &Vec<Losses>| tasks.get(i));
            let reason = reason::of(workload, &asked, &options, i, &losses, between)?;
            tasks.push(Predicted { losses, reason });
        }
        Ok(Some(Self { horizon_ns: options.horizon_ns, tasks, from_bcet }))
    }

    /// What people are told where nothing is predicted of a workload that does not fit.
    pub(super) fn none(workload: &Workload) -> String {
        format!(
            "no job is lost in a simulation of {} under redrt, every node at its WCET",
            Duration::from_nanos(options(workload).horizon_ns)
        )
    }

    /// For people.
    pub(super) fn text(&self) -> String {
        let at_wcet: Vec<&Losses> = self.tasks.iter().map(|task| &task.losses).collect();
        let mut parts = vec![
            format!(
                "what will be given up, in a simulation of {} under redrt, every node at its WCET:",
                Duration::from_nanos(self.horizon_ns)
            ),
            table(&at_wcet).to_string(),
        ];
        if let Some(tasks) = &self.from_bcet {
            parts.push("the same with execution times anywhere from `bcet` to WCET:".to_owned());
            parts.push(table(&tasks.iter().collect::<Vec<_>>()).to_string());
        }
        let reasons: Vec<String> = self.tasks.iter().map(|task| format!("  {}", task.reason)).collect();
        parts.push(reasons.join("\n"));
        parts.join("\n\n")
    }
}

fn options(workload: &Workload) -> Options {
    evidence::at_wcet(evidence::horizon_ns(workload, PERIODS, MOST_SUB_JOBS))
}

fn table(tasks: &[&Losses]) -> Table {
    let mut table = Table::new(&["task", "released", "on time", "late", "given up", "floor", "worst window"]);
    for task in tasks {
        table.row(task.cells());
    }
    table
}
