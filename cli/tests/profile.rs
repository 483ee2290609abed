//! `redrt profile`: what it writes, and what it refuses. Times are the machine's; only their bounds are checked.

#[path = "process/plugin.rs"]
mod plugin;
mod process;

use process::{file, run};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

const WORKLOAD: &str = r#"# Guessed by hand.
[[pool]]
name  = "cpu"
lanes = 3   # too many

[[task]]
name     = "t"
deadline = "50ms"
period   = "50ms"

[[task.node]]
name = "camera"
wcet = "40ms"   # surely less
body = { spin = "200us" }

[[task.node]]
name    = "see"
after   = ["camera"]
mimonet = { weights = "w", frame = "f", encoder = { wcet = "1us", body = { spin = "300us" } }, decoders = [
  { name = "lane", wcet = "1us", body = { spin = "100us" } } ] }

[[task.node]]
name       = "act"
after      = ["see"]
wcet       = "1us"
atomic     = true
contention = "7s"
body       = { spin = "100us" }

[[event]]
at   = "1s"
task = "t"
add  = [ { name = "detect", wcet = "1us", after = ["camera"], body = { spin = "400us" } } ]
"#;

const NODES: [(&str, u64); 5] = [
    ("camera", 200_000),
    ("see.encoder", 300_000),
    ("see.lane", 100_000),
    ("act", 100_000),
    ("detect", 400_000),
];

/// The workload, and a place for its copy where nothing is yet.
fn places(name: &str) -> (PathBuf, PathBuf) {
    let input = file(&format!("{name}.toml"), WORKLOAD.as_bytes());
    let copy = input.with_extension("profiled.toml");
    let _none_there = fs::remove_file(&copy);
    (input, copy)
}

/// A short profile with or without rights.
fn profile(input: &str, more: &[&str]) -> (i32, String, String) {
    let short = ["profile", input, "--best-effort", "--runs", "20", "--budget", "20ms"];
    run(&[&short[..], more].concat())
}

#[test]
fn the_copy_has_the_measured_times_and_everything_else() {
    let (input, copy) = places("measured");
    let (status, out, err) = profile(input.to_str().unwrap(), &["--json"]);
    assert_eq!(status, 0, "{err}");
    let report: Value = serde_json::from_str(&out).expect("one JSON object");
    assert_eq!(report["file"], copy.to_str().unwrap());
    assert!(report["realtime"].is_boolean());
    let nodes = report["nodes"].as_array().unwrap();
    assert_eq!(nodes.len(), NODES.len());

    let text = fs::read_to_string(&copy).unwrap();
    assert!(text.starts_with("# Profiled by redrt from measured.toml.\n"), "{text}");
    for kept in
        ["# Guessed by hand.", "   # too many", "   # surely less", "after   = [\"camera\"]", "rho = "]
    {
        assert!(text.contains(kept), "no `{kept}` in: {text}");
    }
    assert_eq!(fs::read_to_string(&input).unwrap(), WORKLOAD);
    let written = red_workload::load(&copy).expect("the copy is a workload");
    let task = &written.tasks[0];
    for (row, (name, spin_ns)) in nodes.iter().zip(NODES) {
        let ns = |key: &str| row[key].as_u64().unwrap_or_else(|| panic!("{key} of {row}"));
        assert_eq!((&row["task"], &row["node"]), (&"t".into(), &name.into()));
        assert!(ns("runs") >= 3 && ns("min_ns") >= spin_ns, "{row}");
        assert!(ns("min_ns") <= ns("median_ns") && ns("median_ns") <= ns("p99_ns"), "{row}");
        assert!(ns("p99_ns") <= ns("max_ns") && ns("max_ns") * 12 / 10 <= ns("wcet_ns"), "{row}");
        assert!(ns("bcet_ns") <= ns("min_ns") && ns("wcet_ns") >= spin_ns, "{row}");
    }
    let red_workload::model::Work::Plain(camera) = &task.nodes[0].work else { panic!("a node") };
    assert_eq!(
        (camera.wcet_ns, camera.bcet_ns),
        (nodes[0]["wcet_ns"].as_u64().unwrap(), nodes[0]["bcet_ns"].as_u64().unwrap())
    );
    let red_workload::model::Work::Plain(act) = &task.nodes[2].work else { panic!("a node") };
    // One CPU alone measures no contention, and leaves what is there.
    assert_eq!(act.contention_ns, nodes[3]["contention_ns"].as_u64().unwrap_or(7_000_000_000));
    let pool = &report["pools"][0];
    assert_eq!(pool["lanes"].as_u64().unwrap(), pool["rho"].as_f64().unwrap().floor().max(1.0) as u64);
    assert_eq!(u64::from(written.pools[0].lanes), pool["lanes"].as_u64().unwrap());
    assert!(run(&["plan", copy.to_str().unwrap()]).0 <= 1, "it plans");
}

#[test]
fn nobody_loses_a_file() {
    let (input, copy) = places("kept");
    let input = input.to_str().unwrap();
    fs::write(&copy, "mine").unwrap();
    let refused = |more: &[&str], word: &str| {
        let (status, out, err) = profile(input, more);
        assert_eq!((status, &*out), (2, ""), "{err}");
        assert!(err.contains(word), "{err}");
    };
    refused(&[], "--force");
    refused(&["--out", input, "--force"], "--out");
    refused(&["--out", "no-such-folder/copy.toml"], "no-such-folder");
    refused(&["--margin", "20"], "such as 20%");
    assert_eq!(fs::read_to_string(&copy).unwrap(), "mine");
    assert_eq!(fs::read_to_string(input).unwrap(), WORKLOAD);
    let (status, _, err) = profile(input, &["--force"]);
    assert_eq!(status, 0, "{err}");
    assert!(red_workload::load(&copy).is_ok());
}

#[test]
fn what_cannot_be_measured_is_named() {
    let refused = |name: &str, content: String, status: i32, words: &[&str]| {
        let path = file(name, content.as_bytes());
        let (ended, out, err) = profile(path.to_str().unwrap(), &[]);
        assert_eq!((ended, &*out), (status, ""), "{name}: {err}");
        assert!(words.iter().all(|word| err.contains(word)), "{err}");
        assert!(!path.with_extension("profiled.toml").exists());
    };
    let yaml = "pool: [{name: cpu, lanes: 1}]\ntask: [{name: t, deadline: 1ms, once: true, node: [{name: a, wcet: 1ms}]}]\n";
    refused("profile.yaml", yaml.to_owned(), 2, &["convert", "TOML"]);
    refused(
        "bodiless.toml",
        WORKLOAD.replace("body = { spin = \"200us\" }", ""),
        2,
        &["t.camera", "no body"],
    );
    refused("cuda.toml", WORKLOAD.replace("lanes = 3", "kind = \"cuda\"\nlanes = 3"), 3, &["`cpu`", "cuda"]);
}

#[test]
fn a_body_that_never_returns_is_named_and_nothing_is_written() {
    let object = plugin::built("faults", "profile");
    let body = format!("body = {{ plugin = {object:?}, symbol = \"always_hangs\" }}");
    let path = file("hung.toml", WORKLOAD.replace("body = { spin = \"200us\" }", &body).as_bytes());
    let (status, out, err) = profile(path.to_str().unwrap(), &["--timeout", "100ms"]);
    assert_eq!((status, &*out), (2, ""), "{err}");
    assert!(err.contains("`t.camera`") && err.contains("--timeout"), "{err}");
    assert!(!path.with_extension("profiled.toml").exists());
}
