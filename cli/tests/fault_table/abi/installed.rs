//! Rows 31 and 49: the library as it is installed.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Where the library and its headers were installed for these tests.
pub(crate) fn prefix() -> &'static Path {
    static PREFIX: OnceLock<PathBuf> = OnceLock::new();
    PREFIX.get_or_init(|| {
        let prefix = Path::new(env!("CARGO_TARGET_TMPDIR")).join("abi");
        let install = ["run", "--quiet", "--package", "xtask", "--", "install", "--prefix"];
        let installed =
            Command::new(env!("CARGO")).args(install).arg(&prefix).output().expect("cargo starts");
        let said = String::from_utf8_lossy(&installed.stderr);
        assert!(installed.status.success(), "{said}");
        prefix
    })
}

/// A program of this folder, compiled with these arguments besides, and what it says.
pub(crate) fn said_by(compiler: &str, source: &str, link: &[&str], arguments: &[&Path]) -> (String, bool) {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fault_table/abi").join(source);
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(source).with_extension("program");
    let include = format!("-I{}", prefix().join("include").display());
    let compiled = Command::new(compiler)
        .args(["-Wall", "-Wextra", "-Werror", &include, "-o"])
        .args([&program, &here])
        .args(link)
        .output()
        .unwrap_or_else(|error| panic!("{compiler}: {error}; install it: apt-get install gcc g++"));
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let ran = Command::new(&program).args(arguments).output().expect("it was built");
    (String::from_utf8_lossy(&ran.stdout).into_owned(), ran.status.success())
}

#[test]
fn row_49_two_copies_of_the_library_keep_their_handles_apart() {
    let lib = prefix().join("lib");
    let (own, foreign) = ("0", "8");
    let [archive, first, second] =
        ["libred_core.a", "libred_core.so", "libred.so"].map(|name| lib.join(name));
    let archive = archive.to_str().expect("a name in UTF-8");
    for library in [first, second] {
        let (said, ended_well) = said_by("cc", "two_copies.c", &[archive, "-ldl"], &[&library]);
        assert!(ended_well, "{said}");
        let answers: Vec<&str> =
            said.lines().map(|line| line.rsplit(' ').next().unwrap_or_default()).collect();
        let expected = ["1", own, own, foreign, foreign, foreign, foreign, own, own, own, own];
        assert_eq!(answers, expected, "{said}");
        assert!(said.starts_with("versions: 1 and 1"), "{said}");
    }
}

#[test]
fn row_31_an_exception_out_of_a_body_is_caught_and_fails_its_job() {
    let archive = prefix().join("lib/libred.a");
    let archive = archive.to_str().expect("a name in UTF-8");
    let link = ["-std=c++17", archive, "-lpthread", "-ldl", "-lm", "-lgcc_s"];
    let (said, ended_well) = said_by("g++", "throws.cpp", &link, &[]);
    // Every other job is given up with the reason `fault`; the body that would wait for its own lane is told `Busy`.
    let expected = "released 10, on time 5, shed 5, threw 5\nfrom the body: 11 11 11\nfaults 5\n";
    assert!(ended_well && said == expected, "{said}");
}
