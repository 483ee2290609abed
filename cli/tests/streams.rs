//! Full disks and readers that have gone: a clean end, and never a panic.

#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;

use process::{command, ended, file};
use std::fs::{File, OpenOptions};
use std::process::Stdio;

const QUICK: &str = "pool = [{ name = \"cpu\", lanes = 1 }]\n\
                     [[task]]\nname = \"t\"\nperiod = \"10ms\"\ndeadline = \"20s\"\n\
                     node = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";

fn full() -> File {
    OpenOptions::new().write(true).open("/dev/full").expect("Linux has it")
}

/// A run of 200 ms with these options.
fn run(name: &str, more: &[&str]) -> std::process::Command {
    let path = file(name, QUICK.as_bytes());
    let arguments = ["run", path.to_str().unwrap(), "--best-effort", "--duration", "200ms"];
    command(&[&arguments[..], more].concat())
}

#[test]
fn a_trace_that_cannot_be_written_is_told_by_its_name() {
    for (place, expected) in [("/dev/full", 3), ("no-such-folder/trace.json", 2)] {
        let (status, _, err) = ended(&run("trace-full.toml", &["--trace", place]).output().unwrap());
        assert_eq!(status, expected, "{err}");
        assert!(err.contains("cannot write the trace") && err.contains(place), "{err}");
        assert!(!err.contains("panicked"), "{err}");
    }
}

#[test]
fn an_answer_that_cannot_be_written_is_one_too() {
    for more in [&[][..], &["--json"]] {
        let (status, _, err) = ended(&run("answer-full.toml", more).stdout(full()).output().unwrap());
        assert_eq!(status, 3, "{err}");
        assert!(err.contains("cannot write") && !err.contains("panicked"), "{err}");
    }
}

#[test]
fn nobody_has_to_listen_to_messages() {
    let quiet = run("messages-full.toml", &["--json"]).stderr(full()).output().unwrap();
    assert_eq!(ended(&quiet).0, 0);
    let mut child =
        run("messages-gone.toml", &["--json"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    let (status, out, _) = ended(&child.wait_with_output().unwrap());
    assert_eq!((status, out.lines().count()), (0, 1));
    let mut child = run("answer-gone.toml", &["--json"]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert_eq!(child.wait().unwrap().code(), Some(0));
}
