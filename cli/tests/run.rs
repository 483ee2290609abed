//! `redrt run` as a process, best effort, so that no right is needed.

#[path = "process/alone.rs"]
mod alone;

use alone::alone;
use std::process::{Command, Output};

/// The job of 80 ms runs until both edits have come, so that the second has to wait for it. The other lane keeps the
/// time meanwhile.
const FILE: &str = r#"
[[pool]]
name = "cpu"
lanes = 2
[[task]]
name = "t"
deadline = "200ms"
period = "40ms"
[[task.node]]
name = "a"
wcet = "35ms"
body = { spin = "5ms" }
[[event]]
at = "81ms"
task = "t"
add = [ { name = "b", wcet = "5ms", after = ["a"], body = { spin = "1ms" } } ]
[[event]]
at = "82ms"
task = "t"
add = [ { name = "c", wcet = "5ms", after = ["a"], body = { spin = "1ms" } } ]
"#;

fn run(arguments: &[&str]) -> Output {
    let folder = std::env::temp_dir().join(format!("redrt-run-{}-{}", std::process::id(), arguments.len()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("w.toml");
    std::fs::write(&file, FILE).unwrap();
    let _alone = alone();
    let mut command = Command::new(env!("CARGO_BIN_EXE_redrt"));
    let output =
        command.arg("run").arg(&file).args(["--duration", "600ms", "--best-effort"]).args(arguments).output();
    std::fs::remove_dir_all(folder).unwrap();
    output.unwrap()
}

#[test]
fn a_run_prints_one_object_and_every_job_is_accounted_for() {
    let output = run(&["--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let task = &summary["tasks"][0];
    let number = |key: &str| task[key].as_u64().unwrap();
    assert_eq!(number("released"), 15);
    assert!(number("on_time") + number("missed") <= number("released"));
    for key in ["realtime", "dispatch_ns", "overhead_ns_per_unit", "page_faults", "scheduler_bytes"] {
        assert!(!summary[key].is_null(), "{key}");
    }
    assert_eq!(summary["allocations"], 0);
    assert_eq!(summary["failed"], 0);
}

#[test]
fn both_graph_edits_take_effect_though_the_second_has_to_wait() {
    let trace = std::env::temp_dir().join(format!("redrt-edits-{}.json", std::process::id()));
    let output = run(&["--policy", "edf", "--trace", trace.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read(&trace).unwrap();
    std::fs::remove_file(trace).unwrap();
    let trace: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let ran = |name: &str| trace["traceEvents"].as_array().unwrap().iter().any(|event| event["name"] == name);
    assert!(ran("+b") && ran("+c"), "both graphs were in force");
    assert!(ran("b") && ran("c"), "and jobs had them");
}

#[test]
fn under_strict_a_miss_is_a_no() {
    let strict = |deadline: &str| {
        let file = std::env::temp_dir().join(format!("redrt-strict-{}-{deadline}.toml", std::process::id()));
        let text = format!(
            "pool = [{{ name = \"cpu\", lanes = 1 }}]\n[[task]]\nname = \"t\"\nonce = true\ndeadline = \"{deadline}\"\n\
             node = [{{ name = \"a\", wcet = \"1ms\", body = {{ spin = \"1ms\" }} }}]\n"
        );
        std::fs::write(&file, text).unwrap();
        let run = |more: &[&str]| {
            let _alone = alone();
            let mut command = Command::new(env!("CARGO_BIN_EXE_redrt"));
            command.arg("run").arg(&file).args(["--duration", "100ms", "--best-effort", "--policy", "edf"]);
            command.args(more).output().unwrap().status.code()
        };
        let statuses = (run(&["--strict"]), run(&[]));
        std::fs::remove_file(file).unwrap();
        statuses
    };
    assert_eq!(strict("1us"), (Some(1), Some(0)));
    assert_eq!(strict("20s"), (Some(0), Some(0)));
}
