//! The tests on another Linux processor, emulated.

use crate::cross;
use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// The core, what shares it, and what drives it in virtual time.
const EXECUTIVE: &[&str] = &["--package=red-core", "--package=red-sync", "--package=red-sim"];
/// The core in the simulator beside the oracle, on this many random workloads for each comparison.
const ORACLE: &[&str] = &["--package=red-tests", "--test=differential"];
const SEEDS: &str = "5";
/// Packages whose tests the emulator of one process cannot run, and why.
const APART: &[(&str, &str)] = &[
    ("redrt", "starts redrt, which this machine's kernel cannot execute"),
    ("xtask", "starts itself, likewise"),
    ("red-bodies", "loads objects that this machine's compiler made"),
];

/// The step: what decides; all there is where there is time.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let test = || cross::aarch64(workspace, &["test", "--no-fail-fast"]);
    if depth == Depth::Deep {
        APART.iter().for_each(|(package, why)| say!("not run: the tests of {package}: it {why}"));
        let apart: Vec<&str> = APART.iter().flat_map(|(package, _)| ["--exclude", package]).collect();
        return test()?.args(&["--workspace"]).args(&apart).stream();
    }
    let executive = test()?.args(EXECUTIVE).stream()?;
    let oracle = test()?.args(ORACLE).env("SEEDS", SEEDS).stream()?;
    Ok(executive + oracle)
}
