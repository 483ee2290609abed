//! Programs in C and C++ that use the library as it is installed: the tests of the C ABI, plain and under tools that look at
//! memory, and the examples.

mod examples;
mod library;

use std::fs;
use std::path::Path;
use std::time::Instant;

use library::Library;

use crate::abi;
use crate::depth::Depth;
use crate::nightly::Nightly;
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

/// One way to build and run the tests of the C ABI.
struct Way {
    name: &'static str,
    /// Where it is built; in that of another way, what was built there is run again.
    folder: &'static str,
    compilers: [&'static str; 2],
    library: Library,
    options: &'static [&'static str],
}

const GNU: [&str; 2] = ["gcc", "g++"];
const CLANG: [&str; 2] = ["clang", "clang++"];

/// Planted mistakes are among the tests, so that each tool is seen to be in. One way is of the core alone, all others of the
/// library with the runtime.
const WAYS: &[Way] = &[
    Way { name: "gnu", folder: "gnu", compilers: GNU, library: Library::Shipped, options: &[] },
    Way {
        name: "valgrind",
        folder: "gnu",
        compilers: GNU,
        library: Library::Shipped,
        options: &["-DRED_VALGRIND=ON"],
    },
    Way {
        name: "clang",
        folder: "clang",
        compilers: CLANG,
        library: Library::Shipped,
        options: &["-DRED_TARGET=red::core"],
    },
    Way { name: "sanitized", folder: "sanitized", compilers: GNU, library: Library::Address, options: &[] },
    Way { name: "thread", folder: "thread", compilers: CLANG, library: Library::Thread, options: &[] },
];

/// # Errors
/// A test fails, a tool reports something, or an example does not end well.
pub(crate) fn step(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    for (program, packages) in abi::TOOLS.iter().chain(&[("valgrind", ["valgrind"].as_slice())]) {
        tools::present(workspace, program, packages)?;
    }
    let nightly = Nightly::with(workspace, &["rust-src"])?;
    let folder = workspace.target.join("clients");
    let shipped = folder.join("prefix");
    abi::installed(workspace, &shipped, &[])?;
    let mut passed = 0;
    for way in WAYS {
        let begin = Instant::now();
        let prefix = way.library.installed(workspace, &nightly, &shipped)?;
        let count = tried(workspace, way, &prefix, &folder.join(way.folder))?;
        say!("{}: {count} tests, {:.1} s", way.name, begin.elapsed().as_secs_f64());
        passed += count;
    }
    passed += examples::run_all(workspace, &shipped, &folder)?;
    Ok(Tally { passed, ..Tally::default() })
}

/// Builds and runs the tests of the C ABI in one way; how many there were.
fn tried(workspace: &Workspace, way: &Way, prefix: &Path, folder: &Path) -> Result<u32, Failure> {
    let [cc, cxx] = way.compilers;
    let configure = [
        format!("-DCMAKE_C_COMPILER={cc}"),
        format!("-DCMAKE_CXX_COMPILER={cxx}"),
        format!("-DCMAKE_PREFIX_PATH={}", prefix.display()),
    ];
    if way.folder == way.name {
        // Whatever was configured before, with another library, is forgotten.
        let _old = fs::remove_dir_all(folder);
    }
    let cmake = workspace.command("cmake").args(&["-S", "ffi/tests", "-B"]).args(&[folder]);
    let cmake = cmake.args(&configure).args(way.options);
    cmake.args(way.library.option(prefix).as_slice()).text()?;
    run(workspace, folder, way.name)
}

/// Builds what CMake configured in a folder, and runs its tests; how many there were.
fn run(workspace: &Workspace, folder: &Path, name: &str) -> Result<u32, Failure> {
    workspace.command("cmake").args(&["--build"]).args(&[folder]).args(&["--parallel", "2"]).text()?;
    // What hangs fails here, and not at the end of everybody's patience: in seconds.
    let ctest = ["--output-on-failure", "--timeout", "240", "--parallel", "2", "--test-dir"];
    let said = workspace.command("ctest").args(&ctest).args(&[folder]).text()?;
    passed(&said).ok_or_else(|| Failure::Wrong(format!("{name}: no test was run:\n{said}")))
}

/// How many tests ctest says passed, if all did and there were some.
fn passed(said: &str) -> Option<u32> {
    let line =
        said.lines().find_map(|line| line.strip_prefix("100% tests passed, 0 tests failed out of "))?;
    line.trim().parse().ok().filter(|count| *count > 0)
}

#[cfg(test)]
mod tests;
