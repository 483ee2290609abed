//! What tells itself without a build.

use std::process::Command;

/// Exit status, standard output and standard error.
fn xtask(arguments: &[&str]) -> (Option<i32>, String, String) {
    // No build may begin.
    let output = Command::new(env!("CARGO_BIN_EXE_xtask"))
        .args(arguments)
        .env("CARGO", "no-such-cargo")
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn help_needs_no_build() {
    for (arguments, words) in [
        (&["--help"][..], "models [--check]"),
        (&["test", "--help"], "clippy"),
        (&["bench", "--help"], "--quick"),
        (&["bench", "--quick", "-h"], "dispatch"),
    ] {
        let (status, out, err) = xtask(arguments);
        assert_eq!((status, &*err), (Some(0), ""), "{arguments:?}");
        assert!(out.contains(words), "{arguments:?}: {out}");
    }
}

#[test]
fn a_step_that_there_is_not_is_refused() {
    let (status, _, err) = xtask(&["test", "no-such"]);
    assert_eq!(status, Some(2));
    assert!(err.contains("no-such"), "{err}");
}

#[test]
fn an_install_that_says_not_where_to_is_refused_with_how_to_say_it() {
    let (status, _, err) = xtask(&["install"]);
    assert_eq!(status, Some(2));
    assert!(err.contains("--prefix"), "{err}");
}
