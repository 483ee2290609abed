//! Plugins for tests, from C.

use std::path::Path;
use std::process::Command;

/// Builds a file of `tests/plugin` beside the other files of tests, and returns its name there; `name` must be its own
/// among all tests.
pub(crate) fn built(source: &str, name: &str) -> String {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let object = format!("{name}.so");
    let status = Command::new("cc")
        .args(["-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-O1", "-I"])
        .arg(package.join("../bodies/include"))
        .arg("-o")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join(&object))
        .arg(package.join("tests/plugin").join(format!("{source}.c")))
        .status()
        .expect("no C compiler; install it with: apt-get install gcc libc6-dev");
    assert!(status.success(), "cc: {status}");
    object
}
