//! Why jobs were given up, counted for people.

use crate::session::Robot;
use red_core::{Capacity, ShedReason};
use red_workload::metrics::TaskMetrics;
use std::collections::BTreeMap;

/// Reasons in the order in which they are told.
const ORDER: [ShedReason; 7] = [
    ShedReason::Full,
    ShedReason::Hopeless,
    ShedReason::Overload,
    ShedReason::Urgency,
    ShedReason::Late,
    ShedReason::Fault,
    ShedReason::Removed,
];

/// A reason in words. Who adds one adds it to `ORDER` too.
const fn words(reason: ShedReason) -> &'static str {
    match reason {
        ShedReason::Full => "no place for a 65th job",
        ShedReason::Hopeless => "not even its best case could end by the deadline",
        ShedReason::Overload => {
            "a job of another task, or the next one of its own, would have been late beside it"
        }
        ShedReason::Urgency => "lasting overload, and it had the lowest urgency",
        ShedReason::Late => "past its deadline",
        ShedReason::Fault => "one of its bodies failed",
        ShedReason::Removed => "its task was removed",
    }
}

// What the words of `Full` say.
const _: () = assert!(Robot::JOBS == 64 && red_sim::Lab::JOBS == 64);

/// Jobs that were given up, by the name of the reason.
type Counts = BTreeMap<&'static str, u64>;

/// The reasons that occurred, with their counts and their words.
fn reasons(counts: &Counts) -> impl Iterator<Item = (&'static str, u64, &'static str)> {
    ORDER.into_iter().filter_map(|reason| {
        let name = reason.name();
        counts.get(name).map(|count| (name, *count, words(reason)))
    })
}

/// Such as `full 8, hopeless 3`.
pub(crate) fn list(counts: &Counts) -> String {
    let counts: Vec<String> = reasons(counts).map(|(name, count, _)| format!("{name} {count}")).collect();
    if counts.is_empty() { "-".to_owned() } else { counts.join(", ") }
}

/// What the names of the reasons mean, of those that occurred; empty where none did.
pub(crate) fn legend<'a>(all: impl IntoIterator<Item = &'a Counts>) -> Vec<String> {
    let all: Counts = all.into_iter().flatten().map(|(reason, count)| (*reason, *count)).collect();
    reasons(&all).map(|(name, _, words)| format!("  {name}: {words}")).collect()
}

/// A line for each task with such jobs, and the legend; empty where there are none.
pub(crate) fn by_task(tasks: &[TaskMetrics]) -> String {
    let some = tasks.iter().filter(|task| !task.given_up.is_empty());
    let lines = some.map(|task| format!("  {} gave up: {}", task.name, list(&task.given_up)));
    lines.chain(legend(tasks.iter().map(|task| &task.given_up))).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests;
