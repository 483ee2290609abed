//! The command on a machine without a device: that its checks run on a stand-in, and fail where something is wrong there.
//! Those that need `redrt` are among its tests.

use red_cuda_stand_in::StandIn;
use std::process::Command;

fn run(script: Option<&str>, words: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_red-gpu-tests"));
    command.args(words);
    let stand_in = script.map(StandIn::new);
    if let Some(stand_in) = &stand_in {
        stand_in.give(&mut command);
    }
    let ended = command.output().expect("it starts");
    let told = [ended.stdout, ended.stderr].concat();
    (ended.status.code(), String::from_utf8_lossy(&told).into_owned())
}

#[test]
fn the_checks_hold_where_a_device_does_what_it_should() {
    let (status, told) = run(Some("computes 1"), &["compute", "graph", "precedence", "latency"]);
    assert_eq!(status, Some(0), "{told}");
    let lines = [
        "138240 numbers of three launches are the same",
        "1000 graphs",
        "while it sleeps",
        "every check held",
    ];
    for line in lines {
        assert!(told.contains(line), "no `{line}` in: {told}");
    }
}

#[test]
fn each_fails_where_it_does_not() {
    let cases = [
        ("wrong 1", "compute", "46080 of 46080 numbers are not what the CPU computes"),
        ("wrong 1", "graph", "46080 of 46080 numbers are not what the CPU computes"),
        ("ignores waits 1", "precedence", "ns before the end of node"),
        ("fault stamp 9 719", "precedence", "CUDA_ERROR_719"),
        ("fault gate 2 719", "latency", "CUDA_ERROR_719"),
        ("", "scene", "name it by --redrt"),
    ];
    for (script, check, words) in cases {
        let (status, told) =
            run(Some(&format!("computes 1\n{script}")), &["--redrt", "/nowhere/redrt", check]);
        assert!(told.contains("FAILED: ") && told.contains(words), "no `{words}` in: {told}");
        assert_eq!((status, told.contains("NOT every check held")), (Some(1), true), "{told}");
    }
}

#[test]
fn without_a_device_or_with_wrong_arguments_it_says_so() {
    let cases: [(&[&str], i32, &str); 4] = [
        (&[], 3, "libcuda.so.1"),
        (&["speed"], 2, "there is no check speed"),
        (&["--redrt"], 2, "takes a path"),
        (&["--help"], 0, "begins before its predecessors end"),
    ];
    for (words, expected, part) in cases {
        let (status, told) = run(None, words);
        assert_eq!((status, told.contains(part)), (Some(expected), true), "{words:?}: {told}");
    }
}
