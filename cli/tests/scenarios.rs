//! The example workloads: all of them fit, and run under every policy.

#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;

use process::run;
use serde_json::Value;

const SCENARIOS: [&str; 5] = ["obstacle-free", "obstacle", "urban", "emergency", "night"];
const POLICIES: [&str; 6] = ["edf", "red-fg", "red-ida", "red", "redrt", "redrt-lookahead"];

fn answer(arguments: &[&str]) -> Value {
    let (status, out, err) = run(arguments);
    assert_eq!(status, 0, "{arguments:?}: {err}");
    serde_json::from_str(&out).expect("one JSON object")
}

#[test]
fn the_papers_scenarios_run_under_every_policy() {
    for scenario in SCENARIOS {
        let path = format!("examples/scenarios/{scenario}.toml");
        assert_eq!(answer(&["plan", &path, "--json"])["admission"]["fits"], true, "{scenario}");
        let mut saved = Vec::new();
        for policy in POLICIES {
            let report = answer(&["sim", &path, "--json", "--policy", policy]);
            let task = &report["tasks"][0];
            assert_eq!(
                (&task["released"], &task["completed"]),
                (&25.into(), &25.into()),
                "{scenario}, {policy}"
            );
            saved.push(report["encoder_runs_saved"].as_u64().expect("a count"));
        }
        let [edf, fg, ida, red, redrt, lookahead] = saved[..] else { panic!("six policies") };
        assert_eq!((edf, fg, ida), (0, 0, 0), "{scenario}: the baselines run the encoder in each call");
        assert!(red < redrt, "{scenario}: the frame cache shares across stages, merging within one");
        assert!(red < lookahead, "{scenario}: lanes that wait share as much");
    }
}

#[test]
fn the_cruise_example_meets_every_deadline_with_the_obstacle_too() {
    let report = answer(&["sim", "examples/cruise.toml", "--json", "--horizon", "10s"]);
    let task = &report["tasks"][0];
    assert_eq!((&task["released"], &task["on_time"], &task["missed"]), (&100.into(), &100.into(), &0.into()));
}
