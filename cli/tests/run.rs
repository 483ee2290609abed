//! `redrt run` as a process, best effort, so that no right is needed.

#[path = "process/alone.rs"]
mod alone;
mod process;

use alone::alone;
use process::{file, run};

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

/// Runs `name`, a file of this content, alone and without a need for rights.
fn best_effort(name: &str, content: &str, arguments: &[&str]) -> (i32, String, String) {
    let file = file(name, content.as_bytes());
    let _alone = alone();
    run(&[&["run", file.to_str().unwrap(), "--best-effort"], arguments].concat())
}

#[test]
fn a_run_prints_one_object_and_every_job_is_accounted_for() {
    let (status, out, err) = best_effort("run.toml", FILE, &["--duration", "600ms", "--json"]);
    assert_eq!(status, 0, "{err}");
    let summary: serde_json::Value = serde_json::from_str(&out).unwrap();
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
    let trace = file("run.trace.json", b"");
    let arguments = ["--duration", "600ms", "--policy", "edf", "--force", "--trace", trace.to_str().unwrap()];
    let (status, _, err) = best_effort("run-edits.toml", FILE, &arguments);
    assert_eq!(status, 0, "{err}");
    let trace: serde_json::Value = serde_json::from_slice(&std::fs::read(&trace).unwrap()).unwrap();
    let ran = |name: &str| trace["traceEvents"].as_array().unwrap().iter().any(|event| event["name"] == name);
    assert!(ran("+b") && ran("+c"), "both graphs were in force");
    assert!(ran("b") && ran("c"), "and jobs had them");
}

#[test]
fn under_strict_a_miss_is_a_no() {
    let strict = |deadline: &str| {
        let text = format!(
            "pool = [{{ name = \"cpu\", lanes = 1 }}]\n[[task]]\nname = \"t\"\nonce = true\ndeadline = \"{deadline}\"\n\
             node = [{{ name = \"a\", wcet = \"1ms\", body = {{ spin = \"1ms\" }} }}]\n"
        );
        let status = |more: &[&str]| {
            let arguments = [&["--duration", "100ms", "--policy", "edf"], more].concat();
            best_effort(&format!("run-strict-{deadline}.toml"), &text, &arguments).0
        };
        (status(&["--strict"]), status(&[]))
    };
    assert_eq!(strict("1us"), (1, 0));
    assert_eq!(strict("20s"), (0, 0));
}

#[test]
fn a_sporadic_task_that_nothing_releases_is_named_with_the_cure() {
    let text = "pool = [{ name = \"cpu\", lanes = 1 }]\n[[task]]\nname = \"door\"\nmin_interarrival = \"10ms\"\n\
                deadline = \"10ms\"\nnode = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"1ms\" } }]\n";
    let told = |text: &str| {
        let (status, _, err) = best_effort("run-sporadic.toml", text, &["--duration", "50ms"]);
        assert_eq!(status, 0, "{err}");
        err.contains("task `door` was never released") && err.contains("give it `period`")
    };
    assert!(told(text));
    assert!(!told(&text.replace("min_interarrival", "period")));
}
