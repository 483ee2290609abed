//! `cargo xtask paper`: docs/paper.md, which is what `redrt paper` prints.

use std::ffi::OsStr;

use crate::kept::keep;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::workspace::Workspace;

/// What writes the file.
const TASK: &str = "paper";
/// How a promise is told that is not kept.
const FAILS: &str = "| fails |";

/// Writes the tables, or compares them with what is there.
///
/// # Errors
/// The command fails, or a promise of the scoreboard is not kept; with `check`, the file is not what is printed.
pub(crate) fn run(workspace: &Workspace, check: bool) -> Result<Tally, Failure> {
    let made = released(workspace, "red-paper")?.text()?;
    let file = workspace.root.join("docs/paper.md");
    if check {
        let planted = made.replacen("20 seeds", "21 seeds", 1);
        match keep(&file, &planted, TASK, true) {
            Err(differs) => say!("found, as it should be: {differs}"),
            Ok(()) => return Err(Failure::Wrong("a changed table is not found".to_owned())),
        }
    }
    if let Some(line) = made.lines().find(|line| line.contains(FAILS)) {
        return Err(Failure::Wrong(format!("a promise is not kept: {line}")));
    }
    keep(&file, &made, TASK, check)?;
    Ok(Tally::default())
}

/// The policies beside each other, on a terminal.
///
/// # Errors
/// The command fails.
pub(crate) fn scoreboard(workspace: &Workspace, arguments: &[&str]) -> Result<Tally, Failure> {
    released(workspace, "redrt")?.args(&["paper", "scoreboard"]).args(arguments).stream()
}

/// The released program of a package.
fn released(workspace: &Workspace, package: &str) -> Result<Run, Failure> {
    workspace.cargo(&["build", "--release", "--package", package]).stream()?;
    let program = workspace.target.join("release").join(package);
    Ok(Run::new(OsStr::new(&program), &workspace.root))
}
