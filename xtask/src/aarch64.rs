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
/// The C ABI with its runtime: what C gives has other types there, as `char` has no sign.
const ABI: &[&str] = &["--package=red-ffi", "--lib"];
/// The C ABI of the core alone, which is a library of its own.
const ABI_OF_THE_CORE: &[&str] = &["check", "--package=red-ffi", "--no-default-features"];
/// Packages whose tests the emulator of one process cannot run, and why.
const APART: &[(&str, &str)] = &[
    ("redrt", "starts redrt, which this machine's kernel cannot execute"),
    ("xtask", "starts itself, likewise"),
    ("red-bodies", "loads objects that this machine's compiler made"),
];

/// The step: what decides; all there is where there is time.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let test = || cross::aarch64(workspace, &["test", "--no-fail-fast"]);
    cross::aarch64(workspace, ABI_OF_THE_CORE)?.stream()?;
    if depth == Depth::Deep {
        APART.iter().for_each(|(package, why)| say!("not run: the tests of {package}: it {why}"));
        let apart: Vec<&str> = APART.iter().flat_map(|(package, _)| ["--exclude", package]).collect();
        return test()?.args(&["--workspace"]).args(&apart).stream();
    }
    let executive = test()?.args(EXECUTIVE).stream()?;
    let oracle = test()?.args(ORACLE).env("SEEDS", SEEDS).stream()?;
    let abi = test()?.args(ABI).stream()?;
    Ok(executive + oracle + abi)
}
