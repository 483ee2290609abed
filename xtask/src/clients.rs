//! Programs in C and C++ that use the library as it is installed: the tests of the C ABI, plain and under tools that look at
//! memory, and the examples.

mod examples;

use std::fs;
use std::path::Path;

use crate::abi;
use crate::depth::Depth;
use crate::nightly::{HOST, Nightly};
use crate::process::Failure;
use crate::report::Tally;
use crate::tools;
use crate::workspace::Workspace;

/// Programs that are needed beside those of the step that installs, and their packages.
const TOOLS: &[(&str, &[&str])] = &[
    ("valgrind", &["valgrind"]),
    // With what clang's sanitizers link.
    ("clang++", &["clang", "libclang-rt-14-dev"]),
];

/// Which library the tests are built with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Library {
    /// As it ships.
    Shipped,
    /// The same sources, with AddressSanitizer in them.
    Address,
}

/// One way to build and run the tests of the C ABI.
struct Way {
    name: &'static str,
    compilers: [&'static str; 2],
    library: Library,
    options: &'static [&'static str],
}

const GNU: [&str; 2] = ["gcc", "g++"];
const CLANG: [&str; 2] = ["clang", "clang++"];

/// Of the core alone.
const CORE: &str = "-DRED_TARGET=red::core";

/// Planted mistakes are among the tests, so that each tool is seen to be in.
const WAYS: &[Way] = &[
    Way { name: "gnu", compilers: GNU, library: Library::Shipped, options: &[] },
    Way { name: "clang", compilers: CLANG, library: Library::Shipped, options: &[CORE] },
    Way {
        name: "sanitized",
        compilers: GNU,
        library: Library::Address,
        options: &[CORE, "-DRED_SANITIZE=address,undefined"],
    },
    Way {
        name: "valgrind",
        compilers: GNU,
        library: Library::Shipped,
        options: &[CORE, "-DRED_VALGRIND=ON"],
    },
];

/// # Errors
/// A test fails, a tool reports something, or an example does not end well.
pub(crate) fn step(workspace: &Workspace, _: Depth) -> Result<Tally, Failure> {
    for (program, packages) in TOOLS {
        tools::present(workspace, program, packages)?;
    }
    let folder = workspace.target.join("clients");
    let shipped = folder.join("prefix");
    abi::installed(workspace, &shipped, &[])?;
    let address = folder.join("prefix-address");
    sanitized(workspace, &shipped, &address)?;
    let mut passed = 0;
    for way in WAYS {
        let prefix = if way.library == Library::Shipped { &shipped } else { &address };
        passed += tried(workspace, way, prefix, &folder.join(way.name))?;
    }
    passed += examples::run_all(workspace, &shipped, &folder)?;
    Ok(Tally { passed, ..Tally::default() })
}

/// An installation like another one whose static library of the core has AddressSanitizer in it.
fn sanitized(workspace: &Workspace, like: &Path, prefix: &Path) -> Result<(), Failure> {
    let nightly = Nightly::with(workspace, &[])?;
    let target = nightly.target("address-ffi");
    let build =
        ["rustc", "--package", "red-ffi", "--no-default-features", "--profile", "release-ffi", "--lib"];
    let build = nightly.cargo(&build).args(&["--crate-type", "staticlib", "--target", HOST]);
    build.env("RUSTFLAGS", "-Zsanitizer=address").env("CARGO_TARGET_DIR", &target).stream()?;
    let _old = fs::remove_dir_all(prefix);
    workspace.command("cp").args(&["-a"]).args(&[like, prefix]).stream()?;
    let built = target.join(HOST).join("release-ffi/libred_ffi.a");
    let place = prefix.join("lib/libred_core.a");
    let copied = fs::copy(&built, &place);
    copied.map(drop).map_err(|reason| Failure::File { path: place.display().to_string(), reason })
}

/// Builds and runs the tests of the C ABI in one way; how many there were.
fn tried(workspace: &Workspace, way: &Way, prefix: &Path, folder: &Path) -> Result<u32, Failure> {
    let [cc, cxx] = way.compilers;
    let configure = [
        format!("-DCMAKE_C_COMPILER={cc}"),
        format!("-DCMAKE_CXX_COMPILER={cxx}"),
        format!("-DCMAKE_PREFIX_PATH={}", prefix.display()),
    ];
    // Whatever was configured before, with another library, is forgotten.
    let _old = fs::remove_dir_all(folder);
    let cmake = workspace.command("cmake").args(&["-S", "ffi/tests", "-B"]).args(&[folder]);
    cmake.args(&configure).args(way.options).text()?;
    run(workspace, folder, way.name)
}

/// Builds what CMake configured in a folder, and runs its tests; how many there were.
fn run(workspace: &Workspace, folder: &Path, name: &str) -> Result<u32, Failure> {
    workspace.command("cmake").args(&["--build"]).args(&[folder]).args(&["--parallel", "2"]).text()?;
    let ctest = workspace.command("ctest").args(&["--output-on-failure", "--test-dir"]).args(&[folder]);
    let said = ctest.text()?;
    let count = passed(&said).ok_or_else(|| Failure::Wrong(format!("{name}: no test was run:\n{said}")))?;
    say!("{name}: {count} tests");
    Ok(count)
}

/// How many tests ctest says passed, if all did and there were some.
fn passed(said: &str) -> Option<u32> {
    let line =
        said.lines().find_map(|line| line.strip_prefix("100% tests passed, 0 tests failed out of "))?;
    line.trim().parse().ok().filter(|count| *count > 0)
}

#[cfg(test)]
mod tests;
