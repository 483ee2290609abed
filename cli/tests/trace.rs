//! `run --trace`: what viewers of the Chrome trace event format rely on.

mod process;

use process::{file, run};
use serde_json::Value;
use std::collections::{HashMap, HashSet};
use std::fs;
use std::sync::LazyLock;

/// More than the lane can do, so that deadlines are missed, and an edit on the way.
const BUSY: &str = r#"
pool = [{ name = "cpu", lanes = 1 }]
[[task]]
name = "t"
period = "20ms"
deadline = "30ms"
node = [
  { name = "camera", wcet = "1ms", body = { spin = "1ms" } },
  { name = "see", after = ["camera"], mimonet = { weights = "w", frame = "f",
    encoder = { wcet = "10ms", body = { spin = "10ms" } }, decoders = [ { name = "lane", wcet = "2ms", body = { spin = "2ms" } } ] } },
  { name = "again", after = ["see"], mimonet = { weights = "w", frame = "f",
    encoder = { wcet = "10ms", body = { spin = "10ms" } }, decoders = [ { name = "lane", wcet = "2ms", body = { spin = "2ms" } } ] } },
]
[[event]]
at = "200ms"
task = "t"
add = [ { name = "detect", wcet = "9ms", after = ["camera"], body = { spin = "9ms" } } ]
[[event]]
at = "500ms"
task = "t"
remove = ["detect"]
"#;

/// Process and row.
fn row(event: &Value) -> (u64, u64) {
    (event["pid"].as_u64().expect("a process"), event["tid"].as_u64().expect("a row"))
}

/// A time in nanoseconds; the format has microseconds with a point.
fn ns(event: &Value, key: &str) -> i64 {
    (event[key].as_f64().unwrap_or_else(|| panic!("{key} of {event}")) * 1_000.0).round() as i64
}

/// The events of a run under edf, and under redrt, one after the other.
static EVENTS: LazyLock<[Vec<Value>; 2]> = LazyLock::new(|| ["edf", "redrt"].map(events));

fn events(policy: &str) -> Vec<Value> {
    let input = file(&format!("busy-{policy}.toml"), BUSY.as_bytes());
    let trace = input.with_extension("trace.json");
    let arguments =
        ["run", input.to_str().unwrap(), "--best-effort", "--duration", "800ms", "--policy", policy];
    let (status, _, err) = run(&[&arguments[..], &["--force", "--trace", trace.to_str().unwrap()]].concat());
    assert_eq!(status, 0, "{err}");
    let trace: Value = serde_json::from_slice(&fs::read(trace).unwrap()).expect("one JSON object");
    trace["traceEvents"].as_array().expect("a list").clone()
}

fn id(event: &Value) -> u64 {
    event["id"].as_u64().expect("a number")
}

fn of_kind<'a>(events: &'a [Value], phase: &str) -> Vec<&'a Value> {
    events.iter().filter(|event| event["ph"] == phase).collect()
}

#[test]
fn rows_are_named_and_times_go_forward_in_each() {
    let events = &EVENTS[1];
    let named: HashSet<(u64, u64)> =
        events.iter().filter(|event| event["name"] == "thread_name").map(row).collect();
    let mut last: HashMap<(u64, u64), i64> = HashMap::new();
    for event in events.iter().filter(|event| event["ph"] != "M") {
        assert!(named.contains(&row(event)), "{event}");
        let before = last.insert(row(event), ns(event, "ts")).unwrap_or(0);
        assert!(before <= ns(event, "ts"), "{event} after {before} ns");
    }
}

#[test]
fn slices_of_a_row_are_apart_or_one_in_the_other() {
    let events = &EVENTS[1];
    let mut open: HashMap<(u64, u64), i64> = HashMap::new();
    for slice in of_kind(events, "X") {
        let (start, end) = (ns(slice, "ts"), ns(slice, "ts") + ns(slice, "dur"));
        let until = open.entry(row(slice)).or_insert(0);
        assert!(start >= *until || end <= *until, "{slice} overlaps what ends at {until} ns");
        *until = end.max(*until);
    }
}

#[test]
fn every_arrow_connects_two_slices() {
    let events = &EVENTS[1];
    let slices = of_kind(events, "X");
    let inside = |end: &Value| {
        slices.iter().any(|slice| {
            let start = ns(slice, "ts");
            row(slice) == row(end) && (start..=start + ns(slice, "dur")).contains(&ns(end, "ts"))
        })
    };
    let starts: HashMap<u64, &Value> =
        of_kind(events, "s").into_iter().map(|event| (id(event), event)).collect();
    let finishes = of_kind(events, "f");
    assert!(!finishes.is_empty());
    assert_eq!(starts.len(), finishes.len());
    for finish in finishes {
        let start = starts.get(&id(finish)).unwrap_or_else(|| panic!("no start of {finish}"));
        assert_eq!((&start["cat"], &start["name"]), (&finish["cat"], &finish["name"]));
        assert!(ns(start, "ts") <= ns(finish, "ts"), "{start} {finish}");
        assert!(inside(start) && inside(finish), "{start} {finish}");
    }
}

#[test]
fn sub_deadlines_misses_sheds_and_edits_are_there() {
    for (policy, events) in ["edf", "redrt"].iter().zip(&*EVENTS) {
        let nodes: Vec<&Value> =
            of_kind(events, "X").into_iter().filter(|event| event["cat"] == "node").collect();
        assert!(!nodes.is_empty());
        for node in &nodes {
            let args = &node["args"];
            let due = args["sub_deadline_ns"].as_u64().unwrap_or_else(|| panic!("{node}"));
            assert!(due <= args["deadline_ns"].as_u64().unwrap(), "{node}");
        }
        let names: Vec<&str> = events.iter().filter_map(|event| event["name"].as_str()).collect();
        let has = |start: &str| names.iter().any(|name| name.starts_with(start));
        // Ours gives those up that would be late.
        assert!(has("sub-deadline missed: ") || *policy == "redrt", "{policy}");
        assert!(has("+detect") && has("-detect") && has("as in the file"), "{policy}");
        assert!(has(if *policy == "edf" { "deadline missed" } else { "shed: " }), "{policy}");
        assert_eq!(has("hit: again.encoder"), *policy == "redrt");
    }
}
