//! The tests on another Linux processor, emulated.

use crate::cross;
use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::workspace::Workspace;

/// What decides: the core, what shares it, and what drives it in virtual time.
const DECIDING: &[&str] =
    &["--package", "red-core", "--package", "red-sync", "--package", "red-workload", "--package", "red-sim"];

/// The step: what decides; all packages where there is time.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    let packages = if depth == Depth::Deep { &["--workspace"] } else { DECIDING };
    cross::aarch64(workspace, &["test", "--no-fail-fast"])?.args(packages).stream()
}
