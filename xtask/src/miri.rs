//! The unit tests of core, synchronizers and C ABI in an interpreter that sees undefined behaviour, under several schedules.

use crate::depth::Depth;
use crate::nightly::{Nightly, hear};
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// Pointers keep to what they were made from, and are aligned by more than chance.
const STRICT: &str = "-Zmiri-strict-provenance -Zmiri-symbolic-alignment-check";

/// Bugs of `red-planted`, and the words that each is found by.
const PLANTED: [(&str, &str); 4] = [
    ("race", "Data race detected"),
    ("freed", "dangling"),
    ("looked", "only grants SharedReadOnly"),
    ("lent", "dangling"),
];

/// # Errors
/// A test fails, behaviour is undefined, or a planted bug is not seen.
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
    for (bug, words) in PLANTED {
        hear(miri(&planted, STRICT).args(&[bug]))?.found(bug, words)?;
    }
    hear(miri(&planted, STRICT).args(&["sound"]))?.well("what is right")?;
    let tests = |packages: &[&str], seeds: u32| {
        let flags = format!("{STRICT} -Zmiri-many-seeds=0..{seeds}");
        miri(&["test", "--lib"], &flags).args(packages).stream()
    };
    let tally = tests(&["--package", "red-core", "--package", "red-sync"], seeds)?;
    // Most of these are of one thread, and long.
    let tally = tally + tests(&["--package", "red-ffi"], seeds / 2)?;
    say!("{seeds} seeds, of which the C ABI has half");
    Ok(Tally { passed: tally.passed + PLANTED.len() as u32 + 1, ..tally })
}
