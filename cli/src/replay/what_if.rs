//! `--what-if`: the recorded releases and execution times under another policy, deadline or number of lanes.

use crate::options;
use crate::table::{Table, time};
use red_sim::Report;
use red_workload::metrics::TaskMetrics;
use red_workload::model::Workload;
use red_workload::policy::Policy;
use red_workload::shown;
use std::str::FromStr;

/// Lanes of all pools at most.
const LANES: u32 = 32;

const EXPECTED: &str = "expected policy=POLICY, deadline=TIME or deadline.TASK=TIME, lanes=N or lanes.POOL=N";

/// What is otherwise.
#[derive(Clone, Debug)]
pub(crate) enum Change {
    Policy(Policy),
    /// Of the task of this name, or of all.
    Deadline(Option<String>, u64),
    /// Of the pool of this name, or of the first.
    Lanes(Option<String>, u32),
}

impl FromStr for Change {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or(EXPECTED)?;
        let (key, name) = match key.split_once('.') {
            Some((key, name)) => (key, Some(name.trim().to_owned())),
            None => (key, None),
        };
        let (key, value) = (key.trim(), value.trim());
        match key {
            "policy" if name.is_none() => value.parse().map(Self::Policy),
            "deadline" => options::duration_ns(value).map(|ns| Self::Deadline(name, ns)),
            "lanes" => match value.parse() {
                Ok(lanes @ 1..=LANES) => Ok(Self::Lanes(name, lanes)),
                _ => Err("expected 1 to 32 lanes".to_owned()),
            },
            _ => Err(EXPECTED.to_owned()),
        }
    }
}

impl Change {
    /// What it is of, as it is written.
    fn key(&self) -> String {
        let of = |key: &str, name: &Option<String>| {
            name.as_ref().map_or_else(|| key.to_owned(), |name| format!("{key}.{name}"))
        };
        match self {
            Self::Policy(_) => "policy".to_owned(),
            Self::Deadline(name, _) => of("deadline", name),
            Self::Lanes(name, _) => of("lanes", name),
        }
    }
}

/// Makes the changes, in their order.
///
/// # Errors
/// A name that the workload does not have, with those that it has; or two changes of one thing.
pub(super) fn apply(changes: &[Change], workload: &mut Workload, policy: &mut Policy) -> Result<(), String> {
    let unknown = |what: &str, name: &str, known: Vec<&str>| {
        format!("--what-if: there is no {what} `{}`; the log has {}", shown(name), known.join(", "))
    };
    for (i, change) in changes.iter().enumerate() {
        let key = change.key();
        if changes.iter().take(i).any(|before| before.key() == key) {
            return Err(format!("--what-if: {} is given twice; give it once", shown(&key)));
        }
        match change {
            Change::Policy(other) => *policy = *other,
            Change::Deadline(None, ns) => workload.tasks.iter_mut().for_each(|task| task.deadline_ns = *ns),
            Change::Deadline(Some(name), ns) => {
                match workload.tasks.iter_mut().find(|task| task.name == *name) {
                    Some(task) => task.deadline_ns = *ns,
                    None => {
                        let known = workload.tasks.iter().map(|task| &*task.name).collect();
                        return Err(unknown("task", name, known));
                    }
                }
            }
            Change::Lanes(name, lanes) => {
                let named = |pool: &&mut red_workload::model::Pool| {
                    name.as_ref().is_none_or(|name| pool.name == *name)
                };
                match workload.pools.iter_mut().find(named) {
                    Some(pool) => pool.lanes = *lanes,
                    None => {
                        let known = workload.pools.iter().map(|pool| &*pool.name).collect();
                        return Err(unknown("pool", name.as_deref().unwrap_or_default(), known));
                    }
                }
            }
        }
    }
    // Of several pools at once, so that no single change is at fault.
    match workload.pools.iter().map(|pool| pool.lanes).sum() {
        0..=LANES => Ok(()),
        lanes => Err(format!(
            "--what-if: lanes: the pools have {lanes} together, expected {LANES} at most; give another pool fewer with \
             lanes.POOL=N"
        )),
    }
}

/// Until when a run of `duration_ns` that ended at `end_ns` is judged after a change of its workload: as it drains, unless
/// it was stopped before. One that drained has waited for its jobs as long as the longest deadline, or until none was open.
pub(crate) fn horizon_ns(
    duration_ns: u64,
    end_ns: u64,
    left_open: bool,
    [recorded, changed]: [&Workload; 2],
) -> u64 {
    let drained = |workload: &Workload| {
        let longest = workload.tasks.iter().map(|task| task.deadline_ns).max();
        duration_ns.saturating_add(longest.unwrap_or(0))
    };
    let stopped = end_ns < duration_ns || left_open && end_ns < drained(recorded);
    if stopped { end_ns } else { drained(changed) }
}

/// Both runs beside each other.
pub(super) fn text(recorded: &Report, what_if: &Report, at_wcet: &[String]) -> String {
    let mut table = Table::new(&["", "recorded", "what if"]);
    table.row(["policy", recorded.policy, what_if.policy].map(str::to_owned));
    let lanes = |report: &Report| report.pools.iter().map(|pool| pool.lanes).sum::<u32>().to_string();
    table.row(["lanes".to_owned(), lanes(recorded), lanes(what_if)]);
    for (before, after) in recorded.tasks.iter().zip(&what_if.tasks) {
        let mut row = |title: &str, of: &dyn Fn(&TaskMetrics) -> String| {
            table.row([format!("{} {title}", before.name), of(before), of(after)]);
        };
        row("released", &|task| task.released.to_string());
        row("on time", &|task| task.on_time.to_string());
        row("missed", &|task| task.missed.to_string());
        row("of them given up", &|task| task.shed.to_string());
        row("response p50", &|task| time(task.response_ns.p50));
        row("response p99", &|task| time(task.response_ns.p99));
        row("response max", &|task| time(task.response_ns.max));
    }
    let mut row = |title: &str, of: fn(&Report) -> u64| {
        table.row([title.to_owned(), of(recorded).to_string(), of(what_if).to_string()]);
    };
    row("encoder runs saved", |report| report.encoder_runs_saved);
    row("units dispatched", |report| report.units_dispatched);
    let unknown = match at_wcet {
        [] => String::new(),
        nodes => format!(" Never executed, so at their WCET: {}.", nodes.join(", ")),
    };
    format!(
        "{table}\n\nWhat if: in virtual time, with the recorded releases and execution times; a node that was not executed \
         in a job takes its mean, or that of the encoders of its weights and frame, and a body that failed fails \
         again.{unknown}"
    )
}

#[cfg(test)]
mod tests;
