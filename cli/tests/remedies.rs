//! What `redrt plan` says makes a workload fit, done in the file as a user would, and planned again.

#[path = "process/model.rs"]
mod model;
mod process;

use model::{Model, Node, Task, drawn};
use process::{file, run};

impl Model {
    /// What a user does who reads this line.
    fn with(&self, line: &str) -> Self {
        let mut model = self.clone();
        if let Some(share) = share(line, "all periods at ") {
            model.tasks.iter_mut().for_each(|task| task.period = scaled(task.period, share));
        } else if let Some(share) = share(line, "all deadlines and periods at ") {
            for task in &mut model.tasks {
                (task.deadline, task.period) = (scaled(task.deadline, share), scaled(task.period, share));
            }
        } else if let Some(share) = share(line, "all costs at ") {
            for node in model.tasks.iter_mut().flat_map(|task| &mut task.nodes) {
                (node.wcet, node.bcet) = (scaled(node.wcet, share), scaled(node.bcet, share));
            }
        } else if let Some(rest) = line.strip_prefix("pool `p") {
            let (pool, lanes) = rest.split_once("`: ").expect("a pool");
            let lanes = lanes.strip_suffix(" lanes").expect("lanes").parse().expect("a number");
            model.lanes[pool.parse::<usize>().expect("a pool's number")] = lanes;
        } else {
            line.split("; ").for_each(|part| model.change_task(part));
        }
        model
    }

    /// Such as "task `t0`: deadline 2.000 ms and period 3.000 ms", or "task `t0`, node `n1`: wcet 1.000 ms".
    fn change_task(&mut self, part: &str) {
        let rest = part.strip_prefix("task `t").unwrap_or_else(|| panic!("{part}"));
        let (number, rest) = rest.split_once('`').expect("a name");
        let task = &mut self.tasks[number.parse::<usize>().expect("a task's number")];
        if let Some(rest) = rest.strip_prefix(", node `n") {
            let (number, wcet) = rest.split_once("`: wcet ").expect("a node and its cost");
            let node = &mut task.nodes[number.parse::<usize>().expect("a node's number")];
            node.wcet = nanoseconds(wcet);
            node.bcet = node.bcet.min(node.wcet);
            return;
        }
        for change in rest.strip_prefix(": ").expect("times").split(" and ") {
            match change.split_once(' ') {
                Some(("deadline", time)) => task.deadline = nanoseconds(time),
                Some(("period", time)) => task.period = nanoseconds(time),
                _ => panic!("{part}"),
            }
        }
    }
}

/// Thousandths.
fn share(line: &str, what: &str) -> Option<u64> {
    let share = line.strip_prefix(what)?.strip_suffix(" % of what they are")?;
    Some(share.replace('.', "").parse().expect("a number with one decimal"))
}

/// The nearest whole number.
fn scaled(ns: u64, thousandths: u64) -> u64 {
    (ns * thousandths + 500) / 1_000
}

fn nanoseconds(time: &str) -> u64 {
    let (number, unit) = time.split_once(' ').expect("a number and a unit");
    let unit = match unit {
        "s" => 1_000_000_000,
        "ms" => 1_000_000,
        "us" => 1_000,
        "ns" => 1,
        _ => panic!("{time}"),
    };
    let (whole, decimals) = number.split_once('.').unwrap_or((number, ""));
    let digits = |text: &str| text.parse::<u64>().unwrap_or(0);
    digits(whole) * unit + digits(decimals) * unit / 10_u64.pow(decimals.len() as u32)
}

fn planned(model: &Model, name: &str) -> (i32, String) {
    let file = file(name, model.text().as_bytes());
    let (status, out, err) = run(&["plan", &file.to_string_lossy()]);
    assert!(status <= 1, "{err}\n{}", model.text());
    (status, out)
}

/// The lines of the list of changes.
fn offered(out: &str) -> Vec<String> {
    let after = |head: &str| out.split_once(head).map(|(_, rest)| rest);
    let list = after("any one of these makes it fit:\n").or_else(|| after("together these do:\n"));
    let lines = list.unwrap_or("").lines().take_while(|line| line.starts_with("  "));
    lines.map(|line| line.trim().to_owned()).collect()
}

#[test]
fn every_change_that_is_offered_makes_it_fit() {
    let (mut refused, mut tried) = (0, 0);
    for seed in 0..30 {
        let model = drawn(seed, (60, 180));
        let (status, out) = planned(&model, "before.toml");
        if status == 0 {
            assert!(!out.contains("does not fit"), "{out}");
            continue;
        }
        refused += 1;
        assert!(out.contains("does not fit: "), "{out}");
        for line in offered(&out) {
            tried += 1;
            let (status, after) = planned(&model.with(&line), "after.toml");
            assert_eq!(status, 0, "seed {seed}: {line}\n{}\n{after}", model.text());
        }
    }
    assert!(refused > 15 && tried > 2 * refused, "{refused} that do not fit, {tried} changes");
}

#[test]
fn where_no_single_change_helps_it_is_said_and_what_would() {
    // A thousandth of the costs is still too much, and two tasks are too short of time in two ways.
    let node = Node { wcet: 3_000_000, bcet: 0, pool: 0, after: Vec::new() };
    let task = Task { deadline: 1_000, period: 1_000, value: 1, cluster: None, nodes: vec![node] };
    let model = Model { lanes: vec![1], clusters: vec![Vec::new()], tasks: vec![task.clone(), task] };
    let (status, out) = planned(&model, "hard.toml");
    assert_eq!(status, 1);
    assert!(out.contains("no single change of deadlines, periods, lanes or costs was found"), "{out}");
    let [line] = &offered(&out)[..] else { panic!("{out}") };
    assert!(line.starts_with("all deadlines and periods at "), "{line}");
    assert_eq!(planned(&model.with(line), "paced.toml").0, 0);
}
