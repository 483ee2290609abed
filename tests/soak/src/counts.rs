//! What happened, in numbers: the soak is worth what it tried.

use std::fmt;
use std::ops::{AddAssign, Index, IndexMut};

/// Something that happens in a soak.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Count {
    Workloads,
    RealTime,
    Released,
    Outside,
    Refused,
    GivenUp,
    SubJobs,
    Hits,
    Ordered,
    EditsMade,
    EditsBusy,
    EditsRefused,
    Removed,
    Failed,
    Panicked,
    Hung,
    Died,
    Standstills,
    Replayed,
}

/// Whether a soak that has none of it has tried too little.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Promise {
    Made,
    /// Only where the machine grants real time.
    WithRights,
    /// It depends on the workloads.
    Open,
}

use Count::{
    Died, EditsBusy, EditsMade, EditsRefused, Failed, GivenUp, Hits, Hung, Ordered, Outside, Panicked,
    RealTime, Refused, Released, Removed, Replayed, Standstills, SubJobs, Workloads,
};
use Promise::{Made, Open, WithRights};

/// In the order of [`Count`], with the words of the summary.
const ALL: [(Count, &str, Promise); 19] = [
    (Workloads, "workloads", Made),
    (RealTime, "of them in real time", WithRights),
    (Released, "jobs released", Made),
    (Outside, "releases accepted from outside", Made),
    (Refused, "jobs refused, too many in flight", Open),
    (GivenUp, "jobs given up", Made),
    (SubJobs, "sub-jobs started", Made),
    (Hits, "encoder results used again", Open),
    (Ordered, "starts held against the order of keys", Made),
    (EditsMade, "edits committed", Made),
    (EditsBusy, "edits refused as busy, and made later", Made),
    (EditsRefused, "edits refused for good, as they have to be", Made),
    (Removed, "tasks removed with jobs in flight", Made),
    (Failed, "bodies failed", Made),
    (Panicked, "bodies panicked", Made),
    (Hung, "bodies hung", Made),
    (Died, "lane threads died", Made),
    (Standstills, "standstills of the process", Made),
    (Replayed, "inputs replayed", Made),
];

/// From so many workloads on, what was promised has happened; fewer say too little.
pub(crate) const ENOUGH: u64 = 12;

/// How often each happened.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Counts([u64; ALL.len()]);

impl Index<Count> for Counts {
    type Output = u64;

    fn index(&self, count: Count) -> &u64 {
        &self.0[count as usize]
    }
}

impl IndexMut<Count> for Counts {
    fn index_mut(&mut self, count: Count) -> &mut u64 {
        &mut self.0[count as usize]
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, more: Self) {
        self.0.iter_mut().zip(more.0).for_each(|(sum, more)| *sum += more);
    }
}

impl Counts {
    /// What was promised and did not happen, though there were workloads enough.
    pub(crate) fn missing(&self, has_rights: bool) -> Vec<&'static str> {
        let promised = |promise: Promise| promise == Made || promise == WithRights && has_rights;
        let missing = ALL.iter().filter(|(count, _, promise)| promised(*promise) && self[*count] == 0);
        if self[Workloads] < ENOUGH { Vec::new() } else { missing.map(|(_, words, _)| *words).collect() }
    }

    /// The counts of a summary, as `Display` writes it; lines of others are passed over.
    pub(crate) fn read(text: &str) -> Self {
        let mut counts = Self::default();
        for line in text.lines() {
            let Some((number, words)) = line.trim_start().split_once(' ') else { continue };
            let known = ALL.iter().find(|(_, name, _)| *name == words.trim_start());
            if let (Some((count, _, _)), Ok(number)) = (known, number.parse()) {
                counts[*count] = number;
            }
        }
        counts
    }

    /// The most telling ones in a line.
    pub(crate) fn line(&self) -> String {
        let faults = [Failed, Panicked, Hung, Died].map(|count| self[count]).iter().sum::<u64>();
        format!(
            "{} workloads ({} in real time), {} jobs ({} given up), {} edits, {faults} faults of bodies and threads, \
             {} inputs replayed",
            self[Workloads], self[RealTime], self[Released], self[GivenUp], self[EditsMade], self[Replayed]
        )
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        ALL.iter().try_for_each(|(count, words, _)| writeln!(f, "{:>12}  {words}", self[*count]))
    }
}

#[cfg(test)]
mod tests;
