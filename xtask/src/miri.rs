//! The unit tests of core and synchronizers in an interpreter that sees undefined behaviour, under several schedules.

use crate::depth::Depth;
use crate::nightly::{Nightly, hear};
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// Pointers keep to what they were made from, and are aligned by more than chance.
const STRICT: &str = "-Zmiri-strict-provenance -Zmiri-symbolic-alignment-check";

/// # Errors
/// A test fails, behaviour is undefined, or a planted race is not seen.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let nightly = Nightly::with(workspace, &["miri", "rust-src"])?;
    let seeds = match depth {
        Depth::Quick => 4,
        Depth::Deep => 16,
    };
    let miri = |arguments: &[&str], flags: &str| {
        let target = nightly.target("miri");
        nightly.cargo(&["miri"]).args(arguments).env("MIRIFLAGS", flags).env("CARGO_TARGET_DIR", target)
    };
    let planted = ["run", "--quiet", "--package", "red-planted", "--"];
    for bug in ["race", "freed"] {
        let words = if bug == "race" { "Data race detected" } else { "dangling" };
        hear(miri(&planted, STRICT).args(&[bug]))?.found(bug, words)?;
    }
    hear(miri(&planted, STRICT).args(&["sound"]))?.well("a lock that is right")?;
    let flags = format!("{STRICT} -Zmiri-many-seeds=0..{seeds}");
    let tests = ["test", "--package", "red-core", "--package", "red-sync", "--lib"];
    let tally = miri(&tests, &flags).stream()?;
    say!("{seeds} seeds");
    Ok(Tally { passed: tally.passed + 3, ..tally })
}
