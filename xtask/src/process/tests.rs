use std::path::Path;

use super::*;

fn shell(script: &str) -> Run {
    Run::new("/bin/sh".as_ref(), Path::new(".")).args(&["-c", script])
}

#[test]
fn a_failing_program_is_named_with_what_it_was_given() {
    let failure = shell("exit 3").env("COLOUR", "red").stream().unwrap_err();
    assert_eq!(failure.to_string(), "`COLOUR=\"red\" sh -c exit 3`: exit status: 3");
}

#[test]
fn tests_are_counted_also_when_some_fail() {
    let script = "echo 'test result: FAILED. 4 passed; 1 failed; 0 ignored; 0 measured'; exit 101";
    let Err(Failure::Status { tally, .. }) = shell(script).stream() else { panic!("it fails") };
    assert_eq!(tally, Tally { passed: 4, failed: 1, ignored: 0 });
}

#[test]
fn a_program_that_is_not_there_is_a_failure() {
    let run = Run::new("no-such-program".as_ref(), Path::new("."));
    assert!(matches!(run.output(), Err(Failure::Start { .. })));
}
