//! The examples in C and C++, each built as its reader would build it, and run.

use std::fs;
use std::path::Path;

use super::run;
use crate::abi;
use crate::cross::{self, CORTEX_M4};
use crate::process::Failure;
use crate::tools;
use crate::workspace::Workspace;

/// Folders with a CMake project that runs itself as a test.
const PROJECTS: &[&str] = &["cpp-cmake", "cpp-runtime", "ros2-executor"];

/// Time is counted instructions: every run is the same.
const TIME: [&str; 2] = ["-icount", "shift=5,sleep=off"];

/// Builds and runs them; how many tests they are.
///
/// # Errors
/// One does not build, or does not end well.
pub(crate) fn run_all(workspace: &Workspace, prefix: &Path, folder: &Path) -> Result<u32, Failure> {
    let mut passed = 0;
    for project in PROJECTS {
        let build = folder.join(project);
        let _old = fs::remove_dir_all(&build);
        let source = workspace.root.join("examples").join(project);
        let cmake = workspace.command("cmake").args(&["-S"]).args(&[&source]).args(&["-B"]).args(&[&build]);
        cmake.args(&[format!("-DCMAKE_PREFIX_PATH={}", prefix.display())]).text()?;
        let count = run(workspace, &build, project)?;
        say!("{project}: {count} tests");
        passed += count;
    }
    Ok(passed + firmware(workspace, folder)?)
}

/// The program for a microcontroller, on an emulated board; with a planted mistake it does not pass.
fn firmware(workspace: &Workspace, folder: &Path) -> Result<u32, Failure> {
    // Both come with clang where that is not a package of its own; arm-none-eabi-gcc would be ten times as much to install.
    for program in ["clang", "ld.lld"] {
        tools::present(workspace, program, &["clang", "lld"])?;
    }
    cross::library(workspace, CORTEX_M4)?;
    let prefix = folder.join("firmware");
    abi::installed(workspace, &prefix, &["--target", CORTEX_M4])?;
    let program = prefix.join("scene.elf");
    let source = workspace.root.join("examples/c-baremetal");
    let clang =
        workspace.command("clang").at(&source).args(&["@flags", "-Werror", "main.c", "scene.c", "board.c"]);
    let clang = clang.args(&[format!("-I{}", prefix.join("include").display())]);
    clang.args(&[prefix.join("lib/libred_core.a").as_path(), "-o".as_ref(), &program]).text()?;
    let board = || Ok::<_, Failure>(cross::cortex_m(workspace, &program)?.args(&TIME));
    board()?.stream()?;
    cross::finds_planted(board()?)?;
    Ok(2)
}
