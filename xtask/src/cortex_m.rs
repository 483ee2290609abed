//! The example firmware on the emulated board.

use crate::cross::{self, CORTEX_M4};
use crate::depth::Depth;
use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::workspace::Workspace;

const EXAMPLE: &str = "embassy-qemu";
/// What is only compiled for a microcontroller, so that no other step lints it. One at a time: they ask different
/// things of the start-up code.
const FIRMWARE: [&str; 2] = [EXAMPLE, "red-traces"];
/// Time is counted instructions: every run is the same, however busy this machine is.
const TIME: [&str; 2] = ["-icount", "shift=5,sleep=off"];
/// The serial line is for people, and standard output for frames of defmt.
const SERIAL: [&str; 2] = ["-serial", "file:/dev/stderr"];
/// Frames of defmt, at least: each unit is logged when it starts and by its body.
const LOGGED: usize = 2 * 210;

/// The step: the firmware passes its own checks and logs; with a planted mistake it does not pass.
pub(crate) fn step(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    cross::library(workspace, CORTEX_M4)?;
    let build = |arguments: &[&str], package| {
        let cargo = workspace.cargo(arguments).args(&["--package", package, "--target", CORTEX_M4]);
        cargo.env("DEFMT_LOG", "trace")
    };
    for package in FIRMWARE {
        build(&["clippy", "--quiet"], package).args(&["--", "--deny", "warnings"]).stream()?;
    }
    build(&["build", "--release"], EXAMPLE).stream()?;
    let program = workspace.target.join(CORTEX_M4).join("release").join(EXAMPLE);
    let board = || Ok::<Run, Failure>(cross::cortex_m(workspace, &program)?.args(&TIME).args(&SERIAL));

    let logged = board()?.capture()?;
    // Each frame ends with a zero byte.
    let frames = logged.matches('\0').count();
    if frames < LOGGED {
        return Err(Failure::Wrong(format!("{frames} frames of defmt came out, expected {LOGGED} or more")));
    }
    say!("{frames} frames of defmt");

    say!("with a planted mistake, to be found:");
    cross::finds_planted(board()?)?;
    Ok(Tally { passed: 3, ..Tally::default() })
}
