//! Why jobs were given up, counted for people.

use crate::session::Robot;
use red_core::{Capacity, ShedReason};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

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
        ShedReason::Full => "no place for a 65th job, and it had the lowest rank",
        ShedReason::Hopeless => "not even its best case could end by the deadline",
        ShedReason::Overload => "others would have been late beside it, and it had the lowest rank",
        ShedReason::Urgency => "lasting overload, and it had the lowest urgency",
        ShedReason::Late => "past its deadline",
        ShedReason::Fault => "one of its bodies failed",
        ShedReason::Removed => "its task was removed",
    }
}

// What the words of `Full` say.
const _: () = assert!(Robot::JOBS == 64 && red_sim::Lab::JOBS == 64);

/// Jobs that were given up, by the name of the reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct GivenUp(BTreeMap<&'static str, u64>);

impl FromIterator<&'static str> for GivenUp {
    fn from_iter<I: IntoIterator<Item = &'static str>>(reasons: I) -> Self {
        let mut counts = BTreeMap::new();
        reasons.into_iter().for_each(|reason| *counts.entry(reason).or_default() += 1);
        Self(counts)
    }
}

impl GivenUp {
    /// Whether no job was.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// How many there are.
    pub(crate) fn total(&self) -> u64 {
        self.0.values().sum()
    }

    /// The reasons that occurred, with their counts and their words.
    fn reasons(&self) -> impl Iterator<Item = (&'static str, u64, &'static str)> {
        ORDER.into_iter().filter_map(|reason| {
            let name = reason.name();
            self.0.get(name).map(|count| (name, *count, words(reason)))
        })
    }
}

/// Such as `full 8, hopeless 3`.
impl fmt::Display for GivenUp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts: Vec<String> = self.reasons().map(|(name, count, _)| format!("{name} {count}")).collect();
        f.write_str(if counts.is_empty() { "-" } else { "" })?;
        f.write_str(&counts.join(", "))
    }
}

/// What the names of the reasons mean, of those that occurred; empty where none did.
pub(crate) fn legend<'a>(all: impl IntoIterator<Item = &'a GivenUp>) -> Vec<String> {
    let all: GivenUp = all.into_iter().flat_map(|given_up| given_up.0.keys().copied()).collect();
    all.reasons().map(|(name, _, words)| format!("  {name}: {words}")).collect()
}

/// A line for each task with such jobs, and the legend; empty where there are none.
pub(crate) fn by_task<'a>(tasks: impl Iterator<Item = (&'a str, &'a GivenUp)> + Clone) -> String {
    let some = tasks.clone().filter(|(_, given_up)| !given_up.is_empty());
    let lines = some.map(|(task, given_up)| format!("  {task} gave up: {given_up}"));
    lines.chain(legend(tasks.map(|(_, given_up)| given_up))).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests;
