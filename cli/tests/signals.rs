//! Ctrl-C and SIGTERM: the run so far is the answer, and a second signal takes nothing away.

#[path = "process/alone.rs"]
mod alone;
#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;

use alone::alone;
use process::command;
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::PathBuf;
use std::process::{Child, ChildStderr, Command, Stdio};

/// Longer than any of these runs, which signals end.
const LONG: &str = "600s";

/// A process that has told a line with this word, and its standard error from there on.
fn started(arguments: &[&str], folder: &PathBuf, word: &str) -> (Child, BufReader<ChildStderr>) {
    fs::create_dir_all(folder).unwrap();
    let mut command = command(arguments);
    command.env("TMPDIR", folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the command starts");
    let mut told = BufReader::new(child.stderr.take().expect("it is piped"));
    let mut line = String::new();
    while !line.contains(word) {
        line.clear();
        assert_ne!(told.read_line(&mut line).expect("UTF-8"), 0, "it ended and never told `{word}`");
    }
    (child, told)
}

/// Sends signals by their names, at once.
fn send(child: &Child, signals: &[&str]) {
    let pid = child.id();
    let all: Vec<String> = signals.iter().map(|signal| format!("kill -{signal} {pid}")).collect();
    // Those after the last one that was needed may find nobody any more.
    Command::new("sh")
        .args(["-c", &all.join("; ")])
        .stderr(Stdio::null())
        .status()
        .expect("there is a shell");
}

/// Exit status, standard output, and the rest of standard error.
fn ended(mut child: Child, mut told: BufReader<ChildStderr>) -> (Option<i32>, String, String) {
    let (mut out, mut err) = (String::new(), String::new());
    child.stdout.take().expect("it is piped").read_to_string(&mut out).expect("UTF-8");
    told.read_to_string(&mut err).expect("UTF-8");
    (child.wait().unwrap().code(), out, err)
}

fn folder(name: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _none_there = fs::remove_dir_all(&folder);
    folder
}

#[test]
fn a_signal_ends_a_run_with_its_summary_and_a_second_one_takes_nothing_away() {
    let _alone = alone();
    for (i, signals) in [&["INT"][..], &["TERM"], &["INT", "INT", "TERM"]].into_iter().enumerate() {
        let folder = folder(&format!("signals-run-{i}"));
        let trace = folder.join("trace.json");
        let arguments =
            ["run", "examples/cruise.toml", "--best-effort", "--duration", LONG, "--json", "--trace"];
        let arguments = [&arguments[..], &[trace.to_str().unwrap()]].concat();
        let (child, told) = started(&arguments, &folder, "of 600 s");
        send(&child, signals);
        let (status, out, err) = ended(child, told);
        assert_eq!(status, Some(0), "{signals:?}: {err}");
        let summary: Value = serde_json::from_str(&out).expect("one JSON object");
        let by = summary["stopped_by"].as_str().expect("a signal's name");
        assert!(signals.iter().any(|signal| by == format!("SIG{signal}")), "{by}");
        assert!(err.contains("stopped by") && !err.contains("panicked"), "{err}");
        let ran_ns = summary["horizon_ns"].as_u64().unwrap();
        assert!(
            ran_ns > 0 && ran_ns < 600_000_000_000,
            "the duration that was run, not the one that was asked for"
        );
        let trace: Value = serde_json::from_slice(&fs::read(trace).unwrap()).expect("a whole trace");
        assert!(!trace["traceEvents"].as_array().unwrap().is_empty());
    }
}

#[test]
fn a_signal_ends_the_demo_with_the_runs_so_far_and_nothing_stays_behind() {
    let _alone = alone();
    let folder = folder("signals-demo");
    let out = folder.join("out");
    let arguments = ["demo", "--duration", LONG, "--json", "--out", out.to_str().unwrap()];
    let (child, told) = started(&arguments, &folder, "of 600 s");
    send(&child, &["INT", "TERM"]);
    let (status, answer, err) = ended(child, told);
    assert_eq!(status, Some(0), "{err}");
    let answer: Value = serde_json::from_str(&answer).expect("one JSON object");
    let runs = answer["runs"].as_array().unwrap();
    assert_eq!((runs.len(), &runs[0]["policy"]), (1, &"edf".into()));
    let names = |folder: &PathBuf| -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(names(&folder), ["out"], "nothing is left elsewhere");
    let networks = ["control.onnx", "demo.toml", "detect.onnx"];
    let rest = ["edf.redlog", "edf.trace.json", "encoder.onnx", "lane.onnx", "report.html", "segment.onnx"];
    assert_eq!(names(&out), [&networks[..], &rest[..]].concat());
}

#[test]
fn a_signal_while_the_demo_measures_ends_it_without_an_answer() {
    let _alone = alone();
    let folder = folder("signals-measuring");
    let (child, told) = started(&["demo", "--json"], &folder, "measuring");
    send(&child, &["TERM"]);
    let (status, answer, err) = ended(child, told);
    assert_eq!((status, &*answer), (Some(1), ""), "{err}");
    assert!(err.contains("stopped"), "{err}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0, "the unpacked networks are gone");
}
