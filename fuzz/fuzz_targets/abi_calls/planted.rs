//! Bugs as the library might have them, one for each thing that is judged: with the feature `planted`, the one that the
//! environment names has to be found.

use std::sync::LazyLock;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bug {
    /// A handle's generation is not compared: a closed one reaches what was opened in its place.
    Generation,
    /// A call that is refused writes an output.
    Output,
    /// A call that is refused changes something open.
    Refused,
    /// Memory that was given back is written.
    Closed,
    /// A lane is not taken out of its pool.
    Lane,
    /// A status that the header does not list.
    Status,
    /// A unit is given out twice.
    Twice,
    /// A call that is not in the log.
    Log,
    /// A body is given for no node of a runtime's graph, and taken.
    Body,
}

const BUGS: [(Bug, &str); 9] = [
    (Bug::Generation, "generation"),
    (Bug::Output, "output"),
    (Bug::Refused, "refused"),
    (Bug::Closed, "closed"),
    (Bug::Lane, "lane"),
    (Bug::Status, "status"),
    (Bug::Twice, "twice"),
    (Bug::Log, "log"),
    (Bug::Body, "body"),
];

static PLANTED: LazyLock<Bug> = LazyLock::new(|| {
    let name = std::env::var("RED_PLANTED").unwrap_or_else(|_| "generation".to_owned());
    let bug = BUGS.iter().find(|(_, word)| *word == name);
    bug.unwrap_or_else(|| panic!("no bug {name:?}")).0
});

pub(crate) fn has(bug: Bug) -> bool {
    cfg!(feature = "planted") && *PLANTED == bug
}
