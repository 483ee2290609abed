//! Overload as a user sees it: who loses, in virtual time and on threads. Nothing here knows by what rule.
//!
//! Bodies spin until the clock says that their time is over, so that a busy machine makes them late and not longer. What is
//! asked of threads leaves room for that: `redrt paper overload` and the figures in docs say how close they come.

#[path = "process/alone.rs"]
mod alone;
#[path = "process/plugin.rs"]
mod plugin;
mod process;

use alone::alone;
use process::{command, file, run};
use serde_json::Value;
use std::fmt::Write;
use std::process::Stdio;
use std::time::Duration;

/// A task of the files below.
struct Task {
    name: &'static str,
    period_us: u64,
    deadline_us: u64,
    more: &'static str,
    /// Of each node: its time in microseconds, and those that it waits for, by number.
    nodes: &'static [(u64, &'static [usize])],
}

const fn task(
    name: &'static str,
    ms: u64,
    more: &'static str,
    nodes: &'static [(u64, &'static [usize])],
) -> Task {
    Task { name, period_us: ms * 1_000, deadline_us: ms * 1_000, more, nodes }
}

/// A perception graph of 40 ms: two of its branches run side by side.
const GRAPH: &[(u64, &[usize])] = &[
    (1_000, &[]),
    (9_000, &[0]),
    (12_000, &[0]),
    (5_000, &[1]),
    (4_000, &[1]),
    (3_000, &[1]),
    (6_000, &[2, 3, 4, 5]),
];
/// The same work one after the other.
const CHAIN: &[(u64, &[usize])] = &[
    (1_000, &[]),
    (9_000, &[0]),
    (12_000, &[1]),
    (5_000, &[2]),
    (4_000, &[3]),
    (3_000, &[4]),
    (6_000, &[5]),
];

/// A workload; on threads every body takes 19 parts of 20 of its time.
fn workload(name: &str, lanes: usize, tasks: &[&Task]) -> String {
    let mut text = format!("[[pool]]\nname = \"cpu\"\nlanes = {lanes}\n");
    for Task { name, period_us, deadline_us, more, nodes } in tasks {
        let _infallible = writeln!(
            text,
            "[[task]]\nname = \"{name}\"\nperiod = \"{period_us}us\"\ndeadline = \"{deadline_us}us\"\n{more}"
        );
        for (number, (us, after)) in nodes.iter().enumerate() {
            let after: Vec<String> = after.iter().map(|node| format!("\"n{node}\"")).collect();
            let _infallible = writeln!(
                text,
                "[[task.node]]\nname = \"n{number}\"\nwcet = \"{us}us\"\nafter = [{}]\nbody = {{ spin = \"{}us\" }}",
                after.join(", "),
                us * 19 / 20
            );
        }
    }
    file(name, text.as_bytes()).to_str().expect("a path in UTF-8").to_owned()
}

fn told((status, out, err): (i32, String, String)) -> Value {
    assert_eq!(status, 0, "{err}");
    serde_json::from_str(&out).expect("one object")
}

fn sim(file: &str, policy: &str, horizon: &str) -> Value {
    told(run(&["sim", file, "--policy", policy, "--horizon", horizon, "--json"]))
}

fn on_threads(file: &str, policy: &str, duration: &str) -> Value {
    let log = format!("{file}.{policy}.redlog");
    let _alone = alone();
    let run_of = [
        "run",
        file,
        "--policy",
        policy,
        "--best-effort",
        "--duration",
        duration,
        "--json",
        "--force",
        "--record",
        &log,
    ];
    let said = told(run(&run_of));
    let (status, out, err) = run(&["replay", &log]);
    assert_eq!(status, 0, "replay: {out}{err}");
    said
}

/// A figure of a task.
fn of(report: &Value, task: &str, key: &str) -> u64 {
    let tasks = report["tasks"].as_array().expect("tasks");
    let task = tasks.iter().find(|found| found["name"] == task).expect("the task");
    task[key].as_u64().unwrap_or_else(|| panic!("{key} of {task}"))
}

fn on_time(report: &Value, task: &str) -> f64 {
    of(report, task, "on_time") as f64 / of(report, task, "released") as f64
}

/// Jobs given up of all tasks for a reason.
fn given_up(report: &Value, reason: &str) -> u64 {
    let tasks = report["tasks"].as_array().expect("tasks");
    tasks.iter().map(|task| task["given_up"][reason].as_u64().unwrap_or(0)).sum()
}

#[test]
fn the_higher_value_wins_in_either_order() {
    const ONE: &[(u64, &[usize])] = &[(6_000, &[])];
    const THREE: &[(u64, &[usize])] = &[(10_000, &[]), (10_000, &[0]), (10_000, &[1])];
    let pairs = [
        (task("low", 10, "value = 1", ONE), task("high", 10, "value = 1000\nfloor = [1, 1]", ONE)),
        (task("low", 50, "value = 1", THREE), task("high", 50, "value = 10", THREE)),
    ];
    for (number, (low, high)) in pairs.iter().enumerate() {
        for (order, tasks) in [[low, high], [high, low]].iter().enumerate() {
            let file = workload(&format!("either-{number}-{order}.toml"), 1, tasks);
            for policy in ["redrt", "redrt-lookahead"] {
                let report = sim(&file, policy, "5s");
                assert_eq!(of(&report, "high", "missed"), 0, "{file} {policy}: {report}");
                let shares = [on_time(&report, "low"), on_time(&report, "high")];
                assert!(shares[0] < 0.1, "both do not fit: {shares:?}");
            }
            let report = on_threads(&file, "redrt", "2s");
            assert!(on_time(&report, "high") > 0.85, "{file}: {}", report["tasks"]);
        }
    }
}

#[test]
fn a_graph_at_133_percent_reaches_what_its_lanes_can_carry() {
    // Of 40 ms each: by how much the lanes are asked for more than they have.
    for (shape, nodes) in [("graph", GRAPH), ("chain", CHAIN)] {
        for (lanes, period_ms) in [(1, 30), (1, 36), (2, 15), (2, 18), (4, 8)] {
            let task = Task { deadline_us: 66_000, ..task("t", period_ms, "floor = [2, 3]", nodes) };
            let file = workload(&format!("{shape}-{lanes}-{period_ms}.toml"), lanes, &[&task]);
            let report = sim(&file, "redrt", "20s");
            let capacity = 20_000.0 * lanes as f64 / 40.0;
            let share =
                of(&report, "t", "on_time") as f64 / capacity.min(of(&report, "t", "released") as f64);
            assert!(share >= 0.97, "{file}: {share} of its capacity");
        }
    }
}

#[test]
fn who_is_in_time_and_what_is_given_up_are_alike_on_threads() {
    let graph = Task { deadline_us: 66_000, ..task("t", 30, "floor = [2, 3]", GRAPH) };
    let chain = Task { deadline_us: 66_000, ..task("t", 30, "", CHAIN) };
    let values = [
        task("high", 40, "value = 100", &[(9_000, &[]), (8_000, &[0])]),
        task("middle", 50, "value = 10", &[(14_000, &[]), (9_000, &[])]),
        task("low", 60, "value = 1", &[(10_000, &[]), (15_000, &[0])]),
    ];
    for (name, tasks) in [
        ("alike.toml", &[&graph][..]),
        ("alike-chain.toml", &[&chain]),
        ("alike-values.toml", &values.each_ref()),
    ] {
        let file = workload(name, 1, tasks);
        for (policy, reasons) in [("redrt", &["hopeless", "overload"][..]), ("red", &["urgency"])] {
            let (virtually, really) = (sim(&file, policy, "4s"), on_threads(&file, policy, "4s"));
            let on_time =
                |report| tasks.iter().map(|task| of(report, task.name, "on_time")).sum::<u64>() as f64;
            let [expected, found] = [&virtually, &really].map(on_time);
            assert!(
                found >= 0.8 * expected,
                "{name}, {policy}: {found} on threads, {expected} in virtual time: {really}"
            );
            let sum = |report| reasons.iter().map(|reason| given_up(report, reason)).sum::<u64>() as f64;
            let [expected, found] = [&virtually, &really].map(sum);
            assert!(
                expected > 0.0 && found >= 0.6 * expected,
                "{name}, {policy}: {found} given up, {expected} in virtual time: {really}"
            );
        }
    }
}

/// With the times that a run measured, virtual time gives up the same: of each task, not only in all.
#[test]
fn a_run_sheds_by_urgency_what_its_own_times_say() {
    let full = [
        task("brake", 20, "value = 1000", &[(2_000, &[])]),
        Task { deadline_us: 200_000, ..task("imu", 1, "value = 1", &[(2_000, &[])]) },
    ];
    let mixed = [
        Task { deadline_us: 60_000, ..task("wide", 20, "", &[(6_000, &[]), (5_000, &[0]), (5_000, &[0])]) },
        Task { deadline_us: 50_000, ..task("short", 15, "value = 5", &[(3_000, &[]), (3_000, &[0])]) },
    ];
    for (name, tasks) in [("urgency-full.toml", &full), ("urgency-mixed.toml", &mixed)] {
        let file = workload(name, 1, &tasks.each_ref());
        let really = on_threads(&file, "red", "3s");
        assert!(given_up(&really, "urgency") > 10, "{really}");
        let log = format!("{file}.red.redlog");
        let virtually = &told(run(&["replay", &log, "--what-if", "policy=red", "--json"]))["what_if"];
        for task in tasks {
            let all = of(&really, task.name, "released");
            for key in ["on_time", "shed"] {
                let [found, expected] = [&really, virtually].map(|report| of(report, task.name, key));
                assert!(
                    10 * found.abs_diff(expected) <= all,
                    "{name}, {key} of {}: {found} on threads and {expected} in virtual time, of {all}",
                    task.name
                );
            }
        }
    }
}

#[test]
fn what_fills_the_table_does_not_keep_the_brake_out() {
    let imu = Task { period_us: 1_000, deadline_us: 200_000, ..task("imu", 1, "value = 1", &[(1_500, &[])]) };
    let brake = task("brake", 20, "value = 1000\nfloor = [1, 1]", &[(500, &[])]);
    let file = workload("brake.toml", 1, &[&imu, &brake]);
    let report = sim(&file, "redrt", "10s");
    assert_eq!(of(&report, "brake", "missed"), 0, "{report}");
    let floor = &report["tasks"][1]["floor"];
    assert_eq!((&floor["worst"], &floor["kept"]), (&Value::from(1), &Value::from(true)));
    let report = on_threads(&file, "redrt", "2s");
    assert!(on_time(&report, "brake") > 0.85, "{}", report["tasks"]);
}

#[test]
fn one_slow_first_run_costs_one_job() {
    let object = plugin::built("warm", "warm");
    let node = format!(
        "{{ name = \"net\", wcet = \"12ms\", body = {{ plugin = \"{object}\", symbol = \"warm_step\" }} }}"
    );
    let text = format!(
        "[[pool]]\nname = \"cpu\"\nlanes = 1\n[[task]]\nname = \"camera\"\nperiod = \"10ms\"\ndeadline = \"10ms\"\nnode = [{node}]\n"
    );
    let file = file("warm.toml", text.as_bytes());
    let report = on_threads(file.to_str().expect("UTF-8"), "redrt", "3s");
    assert!(on_time(&report, "camera") > 0.85, "{}", report["tasks"]);
}

#[test]
fn a_predicted_miss_is_told_before_the_deadline() {
    let (low, high) = (task("low", 10, "", &[(6_000, &[])]), task("high", 10, "value = 9", &[(6_000, &[])]));
    let file = workload("early.toml", 1, &[&low, &high]);
    for report in [sim(&file, "redrt", "1s"), on_threads(&file, "redrt", "1s")] {
        let (missed, warned) = (of(&report, "low", "missed"), of(&report, "low", "warned"));
        assert!(missed >= 50 && warned * 10 >= missed * 9, "{warned} of {missed} misses were predicted");
        let ahead = report["tasks"][0]["early_ns"]["p50"].as_i64();
        assert!(
            ahead > Some(5_000_000),
            "they were known at the release, 10 ms before the deadline: {ahead:?}"
        );
    }
}

#[test]
fn a_body_is_not_blamed_for_a_halt() {
    let task = Task { period_us: 100_000, deadline_us: 5_000_000, ..task("plan", 100, "", &[(10_000, &[])]) };
    let file = workload("halted.toml", 1, &[&task]);
    let log = format!("{file}.redlog");
    let _alone = alone();
    let arguments =
        ["run", &file, "--best-effort", "--duration", "2s", "--json", "--force", "--record", &log];
    let mut halted = command(&arguments);
    let child = halted.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the command starts");
    let pid = nix::unistd::Pid::from_raw(child.id().cast_signed());
    let send = |signal| nix::sys::signal::kill(pid, signal).expect("it is there");
    // Longer together than the bound of a body, and often enough to meet one.
    std::thread::sleep(Duration::from_millis(500));
    for _ in 0..4 {
        send(nix::sys::signal::Signal::SIGSTOP);
        std::thread::sleep(Duration::from_millis(250));
        send(nix::sys::signal::Signal::SIGCONT);
        std::thread::sleep(Duration::from_millis(33));
    }
    let report = told(process::ended(&child.wait_with_output().expect("it ends")));
    assert!(report["standstills"].as_u64() >= Some(3), "{report}");
    assert_eq!((&report["failed"], &report["lanes_lost"]), (&Value::from(0), &Value::from(0)), "{report}");
    let longest = report["tasks"][0]["nodes"][0]["execution_ns"]["max"].as_u64().expect("executions");
    assert!(longest < 200_000_000, "a halt of 250 ms counts as execution: {longest}");
    let (status, out, err) = run(&["replay", &log]);
    assert_eq!(status, 0, "{out}{err}");
    let page = format!("{file}.html");
    let report = told(run(&["report", &log, "--out", &page, "--force", "--json"]));
    assert!(report["standstills"].as_array().expect("standstills").len() >= 3, "{report}");
}
