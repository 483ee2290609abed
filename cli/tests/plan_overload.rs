//! What `redrt plan` predicts to be lost, beside what `redrt sim` loses.

mod process;

use process::{file, run};
use serde_json::Value;

const LANE: &str = "pool = [{ name = \"cpu\", lanes = 1 }]\n";

/// A task of one node with deadline and period of 30 ms.
fn task(name: &str, wcet_ms: u32, more: &str) -> String {
    format!(
        "[[task]]\nname = \"{name}\"\ndeadline = \"30ms\"\nperiod = \"30ms\"\n{more}\n\
         node = [{{ name = \"n\", wcet = \"{wcet_ms}ms\" }}]\n"
    )
}

fn planned(name: &str, text: &str) -> (i32, Value, String) {
    let path = file(name, text.as_bytes());
    let path = path.to_string_lossy();
    let (status, json, err) = run(&["plan", &path, "--json"]);
    assert!(status <= 1, "{err}");
    let (again, text, _) = run(&["plan", &path]);
    assert_eq!(status, again);
    (status, serde_json::from_str(&json).expect("JSON"), text)
}

fn of<'a>(plan: &'a Value, task: &str) -> &'a Value {
    let tasks = plan["overload"]["tasks"].as_array().expect("a prediction");
    tasks.iter().find(|other| other["name"] == task).expect("the task")
}

#[test]
fn the_higher_value_is_predicted_to_win_in_either_order_of_the_file() {
    let (high, low) = (task("high", 20, "value = 10"), task("low", 20, "value = 1"));
    for (name, tasks) in [("first.toml", [&high, &low]), ("last.toml", [&low, &high])] {
        let (status, plan, text) = planned(name, &format!("{LANE}{}{}", tasks[0], tasks[1]));
        assert_eq!(status, 1);
        let (high, low) = (of(&plan, "high"), of(&plan, "low"));
        assert_eq!(high["on_time"], high["released"], "{plan}");
        assert!(low["on_time"].as_u64() < low["released"].as_u64());
        let reason = low["reason"].as_str().expect("a sentence");
        assert!(reason.contains("its value 1 is below that of `high` (10)"), "{reason}");
        assert!(reason.contains("133 % of 1 lane"), "{reason}");
        assert!(text.contains(reason) && text.contains("what will be given up"), "{text}");
    }
}

#[test]
fn what_fits_is_predicted_nothing() {
    let (status, plan, text) = planned("fits.toml", &format!("{LANE}{}", task("a", 20, "")));
    assert_eq!((status, &plan["overload"]), (0, &Value::Null));
    assert!(!text.contains("given up"), "{text}");
    let last = plan.as_object().expect("an object").keys().any(|key| key == "overload");
    assert!(last, "the key is there also where nothing is predicted");
}

#[test]
fn what_no_test_accepts_and_no_job_misses_is_predicted_nothing() {
    // Two lanes and two jobs at a time: more than one period each.
    let text = "pool = [{ name = \"cpu\", lanes = 2 }]\n[[task]]\nname = \"a\"\ndeadline = \"50ms\"\nperiod = \"30ms\"\n\
                node = [{ name = \"n\", wcet = \"40ms\" }]\n";
    let (status, plan, shown) = planned("pipelined.toml", text);
    assert_eq!((status, &plan["overload"]), (1, &Value::Null));
    assert!(shown.contains("no job is lost in a simulation of 60.000 s"), "{shown}");
}

#[test]
fn the_numbers_are_those_of_a_simulation() {
    let text = format!(
        "{LANE}{}{}{}",
        task("a", 14, "value = 2"),
        task("b", 11, "floor = [1, 3]"),
        task("c", 12, "")
    );
    let (status, plan, shown) = planned("three.toml", &text);
    assert_eq!(status, 1);
    let path = file("three.toml", text.as_bytes());
    let horizon = format!("{}ns", plan["overload"]["horizon_ns"]);
    let simulated = run(&["sim", &path.to_string_lossy(), "--json", "--schedule", "--horizon", &horizon]).1;
    let simulated: Value = serde_json::from_str(&simulated).expect("JSON");
    let sheds = simulated["sheds"].as_array().expect("a list");
    for task in simulated["tasks"].as_array().expect("a list") {
        let name = task["name"].as_str().expect("a name");
        let predicted = of(&plan, name);
        for key in ["released", "on_time"] {
            assert_eq!(predicted[key], task[key], "{name} {key}");
        }
        let given_up = predicted["given_up"].as_object().expect("counts by reason");
        for reason in ["full", "hopeless", "overload", "late"] {
            let shed = sheds.iter().filter(|shed| shed["task"] == name && shed["reason"] == reason).count();
            assert_eq!(
                given_up.get(reason).and_then(Value::as_u64).unwrap_or(0),
                shed as u64,
                "{name} {reason}"
            );
        }
        let row = shown.lines().find(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(name) && words.next() == Some(&task["released"].to_string())
        });
        let on_time = row.and_then(|row| row.split_whitespace().nth(2)).expect("a row of the table");
        assert_eq!(on_time, task["on_time"].to_string());
    }
    let floor = &of(&plan, "b")["floor"];
    assert_eq!((&floor["m"], &floor["k"], &floor["kept"]), (&1.into(), &3.into(), &true.into()), "{plan}");
    assert!(floor["worst"].as_u64() >= Some(1));
    assert_eq!(of(&plan, "c")["floor"], Value::Null);
}

#[test]
fn a_task_that_loses_alone_is_told_so() {
    let text = format!("{LANE}{}{}", task("long", 40, "value = 9"), task("short", 1, ""));
    let (_, plan, _) = planned("long.toml", &text);
    let reason = of(&plan, "long")["reason"].as_str().expect("a sentence");
    assert!(reason.contains("even alone"), "{reason}");
    assert!(
        reason.contains("its longest path of 40.000 ms at WCET exceeds its deadline of 30.000 ms"),
        "{reason}"
    );
}

/// A floor that asks for more than there is breaks whoever else is there, and who is told is not sent to look for others.
#[test]
fn a_floor_that_breaks_alone_is_told_so() {
    for (floor, is_told) in [("[1, 2]", false), ("[3, 4]", true)] {
        let much = format!(
            "[[task]]\nname = \"much\"\ndeadline = \"90ms\"\nperiod = \"30ms\"\nfloor = {floor}\n\
             node = [{{ name = \"n\", wcet = \"50ms\" }}]\n"
        );
        let (_, plan, _) = planned("much.toml", &format!("{LANE}{much}{}", task("short", 1, "value = 9")));
        let reason = of(&plan, "much")["reason"].as_str().expect("a sentence");
        assert!(reason.contains("even alone"), "{reason}");
        assert_eq!(reason.contains("its floor"), is_told, "{reason}");
    }
}

/// By the files of `examples/overload` that lose most of a task to a lower value.
#[test]
fn what_lower_values_cost_is_told() {
    for (name, task, words) in [
        ("two-of-each", "navigation-1", "without the tasks of lower value it would lose 0; these are `"),
        ("fewer-than-alone", "lane", "without the tasks of lower value it would lose"),
    ] {
        let path = format!("{}/../examples/overload/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(path).expect("an example");
        let (_, plan, _) = planned(&format!("{name}.toml"), &text);
        let reason = of(&plan, task)["reason"].as_str().expect("a sentence");
        assert!(reason.contains(words), "{reason}");
    }
    // Nobody is below one of two.
    let (_, plan, text) =
        planned("two.toml", &format!("{LANE}{}{}", task("high", 20, "value = 9"), task("low", 20, "")));
    assert!(of(&plan, "low")["on_time"].as_u64() == Some(0) && !text.contains("without the tasks"), "{text}");
}

#[test]
fn an_encoder_that_tasks_share_is_told_to_count_for_each() {
    let net = |name: &str| {
        format!(
            "[[task]]\nname = \"{name}\"\ndeadline = \"30ms\"\nperiod = \"30ms\"\n[[task.node]]\nname = \"p\"\n\
             mimonet = {{ weights = \"w\", frame = \"f\", encoder = {{ wcet = \"9ms\" }}, \
             decoders = [{{ name = \"d\", wcet = \"16ms\" }}] }}\n"
        )
    };
    // Without a sensor each job has a frame of its own, and nothing is shared.
    for (sensor, is_told) in [("[[sensor]]\nname = \"f\"\nperiod = \"30ms\"\n", true), ("", false)] {
        let (_, plan, _) = planned("nets.toml", &format!("{LANE}{sensor}{}{}", net("a"), net("b")));
        let reason = of(&plan, "a")["reason"].as_str().expect("a sentence");
        assert_eq!(reason.contains("an encoder that tasks share counts for each"), is_told, "{reason}");
    }
}

#[test]
fn declared_best_cases_are_tried_too() {
    let text = format!(
        "{LANE}{}{}",
        task("a", 20, "value = 2"),
        task("b", 20, "").replace("wcet = \"20ms\"", "wcet = \"20ms\", bcet = \"2ms\"")
    );
    let (_, plan, shown) = planned("bcet.toml", &text);
    let less = plan["overload"]["from_bcet"].as_array().expect("what is lost then");
    assert_eq!(less.len(), 2);
    assert!(less[1]["on_time"].as_u64() > of(&plan, "b")["on_time"].as_u64(), "{plan}");
    assert!(shown.contains("execution times anywhere from `bcet` to WCET"), "{shown}");
}

#[test]
fn a_task_whose_node_never_fits_between_jobs_of_a_higher_value_is_told_so() {
    let control = "[[task]]\nname = \"control\"\nvalue = 1000\nperiod = \"25ms\"\ndeadline = \"18ms\"\n\
                   node = [{ name = \"n\", wcet = \"11ms\" }]\n";
    let map = |wcet_ms: u32| {
        format!(
            "[[task]]\nname = \"map\"\nperiod = \"500ms\"\ndeadline = \"250ms\"\n\
             node = [{{ name = \"n\", wcet = \"{wcet_ms}ms\" }}]\n"
        )
    };
    let (_, plan, text) = planned("held.toml", &format!("{LANE}{control}{}", map(24)));
    let reason = of(&plan, "map")["reason"].as_str().expect("a sentence");
    let why = "its longest node of 24.000 ms does not start where a job to come of `control` (1000) would be late behind it";
    assert!(reason.contains(why) && text.contains(why), "{reason}");
    let control_on_time = of(&plan, "control")["on_time"].as_u64() >= Some(2_390);
    assert!(control_on_time, "{plan}");
    let (status, plan, _) = planned("fits-between.toml", &format!("{LANE}{control}{}", map(16)));
    assert_eq!((status, &plan["overload"]), (0, &Value::Null), "{plan}");
}

/// Two equals that do not fit, beside a long node that never runs.
#[test]
fn what_never_runs_is_not_to_blame() {
    let task = |name: &str, wcet: u32, period: u32, deadline: u32, value: u32| {
        format!(
            "[[task]]\nname = \"{name}\"\ndeadline = \"{deadline}ms\"\nperiod = \"{period}ms\"\nvalue = {value}\n\
             node = [{{ name = \"n\", wcet = \"{wcet}ms\" }}]\n"
        )
    };
    let equals = task("x", 6, 10, 10, 2) + &task("y", 6, 10, 20, 2);
    let (_, plan, _) = planned("never.toml", &format!("{LANE}{}{equals}", task("never", 24, 40, 80, 1)));
    for name in ["x", "y"] {
        let reason = of(&plan, name)["reason"].as_str().expect("a sentence");
        assert!(reason.contains("its value 2 is also that of") && !reason.contains("never"), "{reason}");
    }
}

#[test]
fn what_comes_once_is_told_who_ranks_above_it() {
    let once = "[[task]]\nname = \"o\"\nonce = true\ndeadline = \"20ms\"\noffset = \"1s\"\n\
                node = [{ name = \"n\", wcet = \"15ms\" }]\n";
    let (_, plan, _) = planned("once.toml", &format!("{LANE}{}{once}", task("c", 24, "value = 10")));
    let reason = of(&plan, "o")["reason"].as_str().expect("a sentence");
    assert!(reason.contains("its value 1 is below that of `c` (10)"), "{reason}");
}
