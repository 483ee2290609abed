//! The clusters that `redrt plan` proposes, written into the file: nobody is worse off with them.

#[path = "process/model.rs"]
mod model;
mod process;

use model::{Model, drawn};
use process::{file, run};
use serde_json::Value;

fn json(arguments: &[&str]) -> (i32, Value) {
    let (status, out, err) = run(arguments);
    assert!(status <= 1, "{err}");
    (status, serde_json::from_str(&out).expect("JSON"))
}

/// With the clusters of a plan's JSON.
fn divided(model: &Model, division: &Value) -> Model {
    let mut model = model.clone();
    for cluster in division["clusters"].as_array().expect("a list") {
        let text = |key: &str| cluster[key].as_str().expect("a text").to_owned();
        let pool: usize = text("pool").strip_prefix('p').expect("a pool").parse().expect("its number");
        model.clusters[pool].push((text("name"), cluster["lanes"].as_u64().expect("lanes")));
        for task in cluster["tasks"].as_array().expect("a list") {
            let task: usize = task
                .as_str()
                .and_then(|name| name.strip_prefix('t'))
                .expect("a task")
                .parse()
                .expect("its number");
            model.tasks[task].cluster = Some(text("name"));
        }
    }
    model
}

#[test]
fn under_a_division_no_task_is_worse_off() {
    let mut found = 0;
    for seed in 0..60 {
        let model = drawn(seed, (20, 110));
        let [before, after] = ["before.toml", "after.toml"].map(|name| format!("division-{name}"));
        let before = file(&before, model.text().as_bytes());
        let before = before.to_string_lossy();
        let (was, plan) = json(&["plan", &before, "--json"]);
        let Some(division) = plan.get("division") else { continue };
        found += 1;
        let after = file(&after, divided(&model, division).text().as_bytes());
        let after = after.to_string_lossy();
        let (is, divided) = json(&["plan", &after, "--json"]);
        assert!(is <= was, "seed {seed}: {division}");
        let (mut proved, [old, new]) = (0, [&plan, &divided].map(|plan| &plan["certificate"]["tasks"]));
        let worlds = ["wcet", "uniform:0.5..1"].map(|times| {
            [&before, &after].map(|file| json(&["sim", file, "--execution", times, "--json"]).1)
        });
        for task in 0..model.tasks.len() {
            let [old, new] = [old, new].map(|tasks| tasks[task]["response_ns"].as_u64());
            proved += u64::from(new.is_some());
            assert!(old.is_none_or(|old| new.is_some_and(|new| new <= old)), "seed {seed}: {division}");
            // Not what was on time: the last job may be undecided in one of them.
            let missed = |report: &Value| report["tasks"][task]["missed"].as_u64();
            for [ran, runs] in &worlds {
                assert!(missed(runs) <= missed(ran), "seed {seed}: {division}");
            }
            let alone = |plan: &Value| plan["tasks"][task]["certificate"]["response_ns"].as_u64();
            assert!(new.is_some() || alone(&divided) <= alone(&plan), "seed {seed}: {division}");
        }
        assert_eq!(division["proved"].as_u64(), Some(proved));
    }
    assert!(found > 2, "{found}");
}
