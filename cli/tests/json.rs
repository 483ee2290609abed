//! `--json`: one object with the keys of the contract, and the same bytes each time.

mod process;

use process::{command, ended, file, run};
use serde_json::Value;

fn object(arguments: &[&str]) -> Value {
    let (status, out, err) = run(arguments);
    assert!(status <= 1, "{arguments:?}: {err}");
    assert_eq!(out.matches('\n').count(), 1, "one line");
    let value: Value = serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"));
    assert!(value.is_object());
    value
}

fn keys(value: &Value) -> Vec<&str> {
    let mut keys: Vec<&str> = value.as_object().expect("an object").keys().map(String::as_str).collect();
    keys.sort_unstable();
    keys
}

#[test]
fn a_plan_has_the_keys_of_the_contract() {
    let plan = object(&["plan", "examples/cruise.toml", "--json"]);
    assert_eq!(keys(&plan), ["admission", "certificate", "overload", "scheduler_bytes", "tasks"]);
    assert_eq!(keys(&plan["admission"]), ["binding", "fits", "guarantee", "margin_ns"]);
    let task = &plan["tasks"][0];
    let of_task = ["certificate", "critical_path_ns", "deadline_ns", "levels", "name", "nodes", "work_ns"];
    assert_eq!(keys(task), of_task);
    assert_eq!(keys(&task["levels"][0]), ["cost_ns", "height", "share_ns"]);
    let of_node = [
        "cost_ns",
        "height",
        "latest_finish_ns",
        "latest_start_ns",
        "level_graham_ns",
        "level_sum_ns",
        "name",
        "path_proportional_ns",
    ];
    assert_eq!(keys(&task["nodes"][0]), of_node);
    assert_eq!(plan["admission"]["guarantee"], "analytic");
    assert_eq!(task["nodes"][1]["name"], "perception.encoder");
}

#[test]
fn a_simulation_has_the_keys_of_the_contract() {
    let report = object(&["sim", "examples/cruise.toml", "--json"]);
    let of_report = [
        "encoder_runs_saved",
        "horizon_ns",
        "nodes_missed",
        "policy",
        "pools",
        "seed",
        "tasks",
        "units_dispatched",
    ];
    assert_eq!(keys(&report), of_report);
    assert_eq!((&report["policy"], &report["seed"]), (&"redrt".into(), &1.into()));
    assert_eq!(report["horizon_ns"], 60_000_000_000u64);
    let of_task = [
        "completed",
        "early_ns",
        "floor",
        "given_up",
        "missed",
        "name",
        "nodes",
        "on_time",
        "qoe",
        "released",
        "response_ns",
        "shed",
        "tardiness_ns",
        "value_on_time",
        "value_released",
        "warned",
        "warned_on_time",
    ];
    assert_eq!(keys(&report["tasks"][0]), of_task);
    assert_eq!(keys(&report["tasks"][0]["early_ns"]), ["p50", "p99"]);
    let of_node = ["count", "execution_ns", "name", "overruns", "wcet_ns"];
    assert_eq!(keys(&report["tasks"][0]["nodes"][0]), of_node);
    assert_eq!(keys(&report["tasks"][0]["qoe"]), ["0.05", "1"]);
    assert_eq!(keys(&report["pools"][0]), ["busy_ns", "lanes", "name"]);

    let listed = object(&["sim", "examples/cruise.toml", "--json", "--schedule", "--horizon", "1s"]);
    assert_eq!(
        keys(&listed["schedule"][0]),
        ["finish_ns", "job", "lane", "node", "pool", "start_ns", "task"]
    );
    assert_eq!(listed["sheds"], Value::Array(Vec::new()));
}

#[test]
fn the_doctor_counts_what_it_lists() {
    let report = object(&["doctor", "--quick", "--json"]);
    assert_eq!(keys(&report), ["fail", "findings", "pass", "warn"]);
    let findings = report["findings"].as_array().expect("a list");
    assert_eq!(keys(&findings[0]), ["fix", "id", "severity", "value", "why"]);
    for severity in ["pass", "warn", "fail"] {
        let count = findings.iter().filter(|finding| finding["severity"] == severity).count();
        assert_eq!(report[severity], count, "{severity}");
    }
}

#[test]
fn same_arguments_give_the_same_bytes() {
    let scenario = "examples/scenarios/urban.toml";
    for arguments in [
        &["plan", scenario, "--json"][..],
        &["sim", scenario, "--json", "--schedule"],
        &["sim", scenario, "--json", "--schedule", "--execution", "uniform:0.5..1.0", "--policy", "red"],
        &["sim", scenario, "--preempt", "--seed", "7"],
    ] {
        assert_eq!(run(arguments), run(arguments), "{arguments:?}");
    }
}

#[test]
fn seeds_count_where_times_are_drawn() {
    let with = |seed| {
        run(&["sim", "examples/cruise.toml", "--execution", "uniform:0.5..1.0", "--seed", seed, "--schedule"])
            .1
    };
    assert_ne!(with("1"), with("2"));
}

#[test]
fn an_empty_horizon_has_no_jobs() {
    let report = object(&["sim", "examples/cruise.toml", "--json", "--horizon", "0s"]);
    assert_eq!(report["tasks"][0]["released"], 0);
    assert_eq!(report["tasks"][0]["response_ns"]["max"], Value::Null);
}

#[test]
fn toml_and_yaml_say_the_same() {
    let toml = file(
        "same.toml",
        b"pool = [{ name = \"gpu\", lanes = 2 }]\n[[task]]\nname = \"t\"\ndeadline = \"9ms\"\nonce = true\n\
          node = [{ name = \"a\", wcet = \"2ms\" }, { name = \"b\", wcet = \"20ms\", after = [\"a\"] }]\n",
    );
    let yaml = file(
        "same.yaml",
        b"\xef\xbb\xbfpool:\r\n- {name: gpu, lanes: 2}\r\ntask:\r\n- name: t\r\n  deadline: 9ms\r\n  once: true\r\n  \
          node:\r\n  - {name: a, wcet: 2ms}\r\n  - {name: b, wcet: 20ms, after: [a]}\r\n",
    );
    let plan = |path: &std::path::Path| ended(&command(&["plan", "--json"]).arg(path).output().unwrap());
    let (from_toml, from_yaml) = (plan(&toml), plan(&yaml));
    assert_eq!(from_toml, from_yaml);
    assert_eq!(from_toml.0, 1);
    assert!(from_toml.1.contains(r#""latest_start_ns":-13000000"#), "{}", from_toml.1);
}

#[test]
fn costs_beyond_the_signed_range_are_exact_numbers() {
    let huge = file(
        "huge.toml",
        b"pool = [{ name = \"gpu\", lanes = 1 }]\n[[task]]\nname = \"t\"\ndeadline = \"1ns\"\nonce = true\n\
          node = [{ name = \"a\", wcet = \"1ns\" }, { name = \"b\", wcet = \"18446744073709551614ns\", after = [\"a\"] }]\n",
    );
    let (status, out, _) = run(&["plan", huge.to_str().unwrap(), "--json"]);
    assert_eq!(status, 1);
    assert!(out.contains(r#""work_ns":18446744073709551615"#), "{out}");
    assert!(out.contains(r#""latest_start_ns":-18446744073709551614"#), "{out}");
    let (status, _, _) = run(&["sim", huge.to_str().unwrap(), "--json"]);
    assert_eq!(status, 0);
}
