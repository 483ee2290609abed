//! The C ABI as it ships: its header, its libraries, what they are found by, and the step that looks at all of it.

mod beside;
mod binutils;
mod build;
mod compile;
mod declared;
mod elf;
mod exports;
mod header;
mod install;
mod layer;
mod loader;
mod package;
mod readme;
mod table;
mod tree;

pub(crate) use header::run as header;
pub(crate) use install::{Wish, run as install};

use std::fs;
use std::path::{Path, PathBuf};

use binutils::Target;
use declared::Declared;
use layer::Layer;

use crate::cross::{AARCH64, CORTEX_M4};
use crate::depth::Depth;
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

/// What the step needs, and who builds with CMake: programs and their packages.
pub(crate) const TOOLS: &[(&str, &[&str])] = &[
    ("g++", &["g++"]),
    ("clang++", &["clang"]),
    ("cmake", &["cmake"]),
    ("make", &["make"]),
    ("pkg-config", &["pkg-config"]),
];

/// # Errors
/// Something is not as it should be, or what is planted is not found.
pub(crate) fn step(workspace: &Workspace, depth: Depth) -> Result<Tally, Failure> {
    for (program, packages) in TOOLS {
        tools::present(workspace, program, packages)?;
    }
    header(workspace, true)?;
    let folder = workspace.target.join("abi");
    let [made, prefix, firmware, by_cmake] =
        ["made", "prefix", "firmware", "by-cmake"].map(|name| folder.join(name));
    for old in [&made, &prefix, &firmware, &by_cmake] {
        let _old = fs::remove_dir_all(old);
    }
    installed(workspace, &made, &[])?;
    installed(workspace, &firmware, &["--target", CORTEX_M4])?;
    // What was installed may be moved.
    fs::rename(&made, &prefix).map_err(Failure::of_file(&prefix))?;

    let mut passed = 1 + compile::check(workspace, &prefix)? + exports::check(workspace, &prefix)?;
    passed += exports::check_firmware(workspace, &firmware)?;
    if depth == Depth::Deep {
        let board = folder.join("board");
        installed(workspace, &board, &["--target", AARCH64])?;
        passed += exports::check(workspace, &board)?;
    }
    passed += beside::check(workspace, &prefix)? + loader::check(workspace, &prefix)?;
    passed += readme::check(workspace, &prefix)?;

    let build = folder.join("build").display().to_string();
    let cmake = |arguments: &[&str]| workspace.command("cmake").args(arguments).text();
    cmake(&["-S", "ffi", "-B", &build])?;
    cmake(&["--build", &build])?;
    cmake(&["--install", &build, "--prefix", &by_cmake.display().to_string()])?;
    tree::same(&by_cmake, &prefix, &firmware)?;
    // The allocator is the library's: other tests are built without it.
    let counts = ["test", "--package", "red-ffi", "--features", "counts", "--test", "allocations"];
    let counts = workspace.cargo(&counts).stream()?;
    Ok(Tally { passed: passed + 1 + counts.passed, ..Tally::default() })
}

/// Names of the functions that the library of the core has.
///
/// # Errors
/// The header cannot be read.
pub(crate) fn functions_of_the_core(workspace: &Workspace) -> Result<Vec<String>, Failure> {
    let names = Declared::of_workspace(workspace)?.functions.into_iter().map(|function| function.name);
    Ok(names.filter(|name| Layer::Core.has(name)).collect())
}

/// What cargo makes of the core's functions, here or for another target.
///
/// # Errors
/// It does not build.
pub(crate) fn archive_of_the_core(workspace: &Workspace, target: Option<&str>) -> Result<PathBuf, Failure> {
    let target = match target {
        Some(triple) => Target::of(triple, None).map_err(Failure::Wrong)?,
        None => Target::here(),
    };
    build::compile(workspace, Layer::Core, &target).map(|(archive, _)| archive)
}

/// `cargo xtask install`.
pub(crate) fn installed(workspace: &Workspace, prefix: &Path, more: &[&str]) -> Result<(), Failure> {
    let prefix = prefix.display().to_string();
    let words = [&["--prefix", &prefix], more].concat();
    install(workspace, &Wish::of(&words).map_err(Failure::Wrong)?)
}
