//! `redrt run` as a process, best effort, so that no right is needed.

use std::process::{Command, Output};

/// Long jobs that overlap, so that the third version of the graph has to wait for the first to drain.
const FILE: &str = r#"
[[pool]]
name = "cpu"
lanes = 1
[[task]]
name = "t"
deadline = "200ms"
period = "40ms"
[[task.node]]
name = "a"
wcet = "30ms"
body = { spin = "20ms" }
[[event]]
at = "100ms"
task = "t"
add = [ { name = "b", wcet = "5ms", after = ["a"], body = { spin = "1ms" } } ]
[[event]]
at = "101ms"
task = "t"
add = [ { name = "c", wcet = "5ms", after = ["a"], body = { spin = "1ms" } } ]
"#;

fn run(arguments: &[&str]) -> Output {
    let folder = std::env::temp_dir().join(format!("redrt-run-{}-{}", std::process::id(), arguments.len()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("w.toml");
    std::fs::write(&file, FILE).unwrap();
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
    let output = run(&["--policy", "edf", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    // 15 jobs of one node, and two more nodes for most of them.
    assert!(summary["units_dispatched"].as_u64().unwrap() > 15 + 12, "{summary}");
}
