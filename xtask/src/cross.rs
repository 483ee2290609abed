//! Other processors: their libraries, linkers and emulators.

use std::path::Path;

use crate::process::{Failure, Run};
use crate::tools;
use crate::workspace::Workspace;

/// The microcontroller that firmware here is for.
pub(crate) const CORTEX_M4: &str = "thumbv7em-none-eabihf";
/// The least that the core and the synchronizers are built for: no compare-and-swap.
pub(crate) const CORTEX_M0: &str = "thumbv6m-none-eabi";
/// The processor of robots' Linux boards.
pub(crate) const AARCH64: &str = "aarch64-unknown-linux-gnu";

/// What stops an emulator that hangs, in seconds.
const PATIENCE: &str = "900";

/// The standard or core library for a target.
///
/// # Errors
/// rustup is missing, or cannot get it.
pub(crate) fn library(workspace: &Workspace, target: &str) -> Result<(), Failure> {
    let libraries = ["--print", "target-libdir", "--target", target];
    let folder = workspace.command("rustc").args(&libraries).output()?;
    if Path::new(&folder).is_dir() {
        return Ok(());
    }
    let add = ["target", "add", target];
    match workspace.command("rustup").args(&add).stream() {
        Ok(_) => Ok(()),
        Err(Failure::Start { .. }) => Err(Failure::Missing {
            what: "the library for another processor",
            install: format!("rustup {} (or your system's package of it)", add.join(" ")),
        }),
        Err(failure) => Err(failure),
    }
}

const AARCH64_LINKER: &str = "aarch64-linux-gnu-gcc";
/// Where Debian puts what programs for it link.
const AARCH64_LIBRARIES: &str = "/usr/aarch64-linux-gnu";

/// A program, its package installed if it is not there. It is stopped if it hangs.
///
/// # Errors
/// It is missing and cannot be installed.
pub(crate) fn tool(workspace: &Workspace, program: &'static str, packages: &[&str]) -> Result<Run, Failure> {
    tools::present(workspace, program, packages)?;
    Ok(workspace.command("timeout").args(&["--foreground", PATIENCE, program]))
}

/// The emulated Cortex-M board with a program in it. Semihosting gives it our standard output and exit status, and
/// the words of `-append` as its command line.
///
/// # Errors
/// The emulator is missing and cannot be installed.
pub(crate) fn cortex_m(workspace: &Workspace, program: &Path) -> Result<Run, Failure> {
    let board = ["-machine", "mps2-an386", "-display", "none", "-monitor", "none"];
    let host = ["-semihosting-config", "enable=on,target=native", "-kernel"];
    let board_emulator = tool(workspace, "qemu-system-arm", &["qemu-system-arm"])?;
    Ok(board_emulator.args(&board).args(&host).args(&[program]))
}

/// Firmware of ours that is told to make a mistake, an encoder that is not shared, has to find it.
///
/// # Errors
/// It cannot be started, or it finds something else, or nothing.
pub(crate) fn finds_planted(board: Run) -> Result<(), Failure> {
    let (said, passes) = board.args(&["-append", "other-frame"]).all_text()?;
    let finds = |line: &str| line.starts_with("encoders run ") && line.ends_with("WRONG");
    match !passes && said.lines().any(|line| finds(line.trim_end())) {
        true => Ok(()),
        false => {
            Err(Failure::Wrong(format!("the firmware does not say that an encoder is not shared:\n{said}")))
        }
    }
}

/// The emulator of a Linux process on AArch64.
///
/// # Errors
/// It is missing and cannot be installed.
pub(crate) fn qemu_aarch64(workspace: &Workspace) -> Result<Run, Failure> {
    Ok(tool(workspace, "qemu-aarch64", &["qemu-user"])?.args(&["-L", AARCH64_LIBRARIES]))
}

/// Cargo for AArch64: what it links runs under the emulator.
///
/// # Errors
/// Something is missing and cannot be installed.
pub(crate) fn aarch64(workspace: &Workspace, arguments: &[&str]) -> Result<Run, Failure> {
    library(workspace, AARCH64)?;
    let _linker = tool(workspace, AARCH64_LINKER, &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"])?;
    let _there = qemu_aarch64(workspace)?;
    let runner = format!("timeout --foreground {PATIENCE} qemu-aarch64 -L {AARCH64_LIBRARIES}");
    Ok(workspace
        .cargo(arguments)
        .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", AARCH64_LINKER)
        .env("CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_RUNNER", runner)
        .args(&["--target", AARCH64]))
}
