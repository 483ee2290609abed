//! Bodies that go wrong, in a run: their jobs fail, everything else goes on, and it is told.

#[path = "process/alone.rs"]
mod alone;
#[path = "process/plugin.rs"]
mod plugin;
#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;

use alone::alone;
use process::{command, file};
use serde_json::Value;
use std::process::Output;

/// Half a second of task `t`, whose node `a` has the body `symbol`, and what else the workload has.
fn run(symbol: &str, more: &str) -> Output {
    let object = plugin::built("faults", symbol);
    let text = format!(
        "pool = [{{ name = \"cpu\", lanes = 1 }}]\n\
         [[task]]\nname = \"t\"\nperiod = \"50ms\"\ndeadline = \"20s\"\n\
         node = [{{ name = \"a\", wcet = \"1ms\", body = {{ plugin = {object:?}, symbol = {symbol:?} }} }}]\n{more}"
    );
    let path = file(&format!("{symbol}.toml"), text.as_bytes());
    let arguments = ["run", path.to_str().unwrap(), "--best-effort", "--duration", "500ms", "--json"];
    let _alone = alone();
    command(&arguments).output().expect("the command starts")
}

/// The summary of a run that ended well, and what was told.
fn summary(output: &Output) -> (Value, String) {
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{told}");
    (serde_json::from_slice(&output.stdout).expect("one JSON object"), told)
}

fn count(task: &Value, key: &str) -> u64 {
    task[key].as_u64().unwrap_or_else(|| panic!("{key} of {task}"))
}

#[test]
fn a_body_that_fails_fails_its_own_job_and_its_reason_is_told() {
    let (summary, told) = summary(&run("fails", ""));
    let task = &summary["tasks"][0];
    assert_eq!((count(task, "released"), count(task, "completed"), count(task, "shed")), (10, 9, 1));
    assert_eq!((&summary["failed"], &summary["lanes_lost"]), (&1.into(), &0.into()));
    assert!(told.contains("job 1: node `t.a`") && told.contains("returned 7"), "{told}");
}

#[test]
fn a_body_may_release_another_task_while_it_runs() {
    let sporadic = "[[task]]\nname = \"s\"\nmin_interarrival = \"10ms\"\ndeadline = \"20s\"\n\
                    node = [{ name = \"b\", wcet = \"1ms\", body = { spin = \"10us\" } }]\n";
    let (summary, _) = summary(&run("releases", sporadic));
    let tasks = &summary["tasks"];
    assert_eq!((count(&tasks[0], "released"), count(&tasks[1], "released")), (10, 10));
    assert_eq!((count(&tasks[0], "completed"), count(&tasks[1], "completed")), (10, 10));
}

#[test]
fn a_plugin_is_told_times_of_the_clock() {
    let (summary, told) = summary(&run("reads_the_clock", ""));
    assert_eq!((count(&summary["tasks"][0], "completed"), &summary["failed"]), (10, &0.into()), "{told}");
}
