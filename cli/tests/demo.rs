//! `redrt demo` as a process: both policies do the same work, and sharing does not lose.

#[path = "process/page.rs"]
mod page;
mod process;

use process::{file, run};
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

fn keys(value: &Value) -> Vec<&String> {
    value.as_object().expect("an object").keys().collect()
}

/// What both the demo and its report say of a run.
const BOTH: [&str; 7] =
    ["policy", "horizon_ns", "tasks", "nodes_missed", "units_dispatched", "encoder_runs_saved", "pools"];

/// The first run and key of the demo that is another in its report.
fn difference(demo: &Value, report: &Value) -> Option<(usize, &'static str)> {
    let runs = |of: &Value| of["runs"].as_array().expect("runs").len();
    assert_eq!((runs(demo), runs(report)), (2, 2));
    let all = (0..2).flat_map(|run| BOTH.map(|key| (run, key)));
    all.into_iter().find(|(run, key)| {
        let [demo, report] = [demo, report].map(|of| &of["runs"][run][key]);
        demo.is_null() || demo != report
    })
}

#[test]
fn both_policies_get_the_same_jobs_and_redrt_meets_no_fewer_deadlines() {
    let out = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("demo");
    let _none_there = fs::remove_dir_all(&out);
    let (status, answer, err) = run(&["demo", "--duration", "2s", "--json", "--out", out.to_str().unwrap()]);
    assert_eq!(status, 0, "{err}");
    assert_eq!(answer.lines().count(), 1);
    let answer: Value = serde_json::from_str(&answer).expect("one JSON object");
    assert_eq!(keys(&answer), ["runs"]);
    let [edf, redrt] = answer["runs"].as_array().unwrap().as_slice() else { panic!("two runs: {answer}") };
    assert_eq!((&edf["policy"], &redrt["policy"]), (&"edf".into(), &"redrt".into()));

    let quick = "pool = [{ name = \"cpu\", lanes = 1 }]\n[[task]]\nname = \"t\"\nonce = true\ndeadline = \"1s\"\n\
                 node = [{ name = \"a\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";
    let path = file("demo-keys.toml", quick.as_bytes());
    let one = run(&["run", path.to_str().unwrap(), "--best-effort", "--duration", "100ms", "--json"]).1;
    let one: Value = serde_json::from_str(&one).expect("one JSON object");
    for policy in [edf, redrt] {
        assert_eq!(keys(policy), keys(&one));
        assert_eq!(keys(&policy["tasks"][0]), keys(&one["tasks"][0]));
        assert_eq!((&policy["allocations"], &policy["horizon_ns"]), (&0.into(), &2_000_000_000u64.into()));
    }

    let count = |run: &Value, key: &str| run["tasks"][0][key].as_u64().expect("a count");
    assert!(count(edf, "released") > 0);
    assert_eq!(count(edf, "released"), count(redrt, "released"));
    assert!(count(redrt, "on_time") >= count(edf, "on_time"), "{edf}\n{redrt}");
    assert_eq!(edf["encoder_runs_saved"], 0);
    assert!(redrt["encoder_runs_saved"].as_u64().unwrap() > 0);
    for policy in ["edf", "redrt"] {
        let trace = fs::read(out.join(format!("{policy}.trace.json"))).unwrap();
        let trace: Value = serde_json::from_slice(&trace).expect("a whole trace");
        assert_eq!(trace["otherData"]["policy"], policy);
        let log = out.join(format!("{policy}.redlog"));
        let (status, said, err) = run(&["replay", log.to_str().unwrap()]);
        assert!(status == 0 && said.contains("no difference"), "{said}{err}");
    }

    let told = page::data(&fs::read_to_string(out.join("report.html")).expect("the report"));
    assert_eq!(difference(&answer, &told), None, "{answer}\n{told}");
    let mut planted = told;
    planted["runs"][1]["tasks"][0]["response_ns"]["max"] = 1.into();
    assert_eq!(difference(&answer, &planted), Some((1, "tasks")), "a difference is found");

    let scene = out.join("demo.toml");
    let arguments = ["run", scene.to_str().unwrap(), "--best-effort", "--duration", "300ms", "--json"];
    let (status, again, err) = run(&arguments);
    assert_eq!(status, 0, "the scene can be run again: {err}");
    let again: Value = serde_json::from_str(&again).expect("one JSON object");
    assert!(count(&again, "released") > 0);
}
