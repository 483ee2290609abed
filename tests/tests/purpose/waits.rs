//! Lanes that wait for a higher rank: only for somebody who gains by it, and at nobody else's cost.

use red_sim::simulate;
use red_tests::differential::options;
use red_tests::oracle;
use red_workload::{Format, parse};

/// Of each task of a file on one lane, and on one of a `gpu`: how many jobs are on time in 20 s, of how many that were due.
pub(super) fn on_time(tasks: &str) -> Vec<(u64, u64)> {
    on_time_on(1, tasks)
}

/// As `on_time`, on so many lanes of the CPU.
pub(super) fn on_time_on(lanes: u8, tasks: &str) -> Vec<(u64, u64)> {
    let pools = format!("[[pool]]\nname = 'cpu'\nlanes = {lanes}\n[[pool]]\nname = 'gpu'\nlanes = 1\n");
    let file = format!("{pools}{tasks}");
    let workload =
        parse(file.as_bytes(), Format::Toml, "waits.toml").unwrap_or_else(|e| panic!("{e}\n{file}"));
    let options = options(oracle::Policy::Redrt, 20_000_000_000);
    let report = simulate(&workload, &options).expect("it fits");
    report.tasks.iter().map(|task| (task.on_time, task.on_time + task.missed)).collect()
}

/// A task with one node after another, each in a pool, all times in milliseconds.
pub(super) fn task(name: &str, rest: &str, period_deadline: (u64, u64), nodes: &[(&str, u64)]) -> String {
    let (period, deadline) = period_deadline;
    let mut text =
        format!("[[task]]\nname = '{name}'\nperiod = '{period}ms'\ndeadline = '{deadline}ms'\n{rest}\n");
    for (nth, (pool, wcet)) in nodes.iter().enumerate() {
        let after = if nth > 0 { format!("after = ['n{}']", nth - 1) } else { String::new() };
        text += &format!("[[task.node]]\nname = 'n{nth}'\npool = '{pool}'\nwcet = '{wcet}ms'\n{after}\n");
    }
    text
}

const LATE_ONCE: &str = "[[task]]\nname = 'late'\nonce = true\noffset = '1010ms'\ndeadline = '10ms'\n\
                         [[task.node]]\nname = 'n'\nwcet = '9ms'\n";

#[test]
fn nobody_waits_for_a_task_that_cannot_be_in_time() {
    // Four nodes of 10 ms side by side on one lane, due after 30.
    let hopeless = "[[task]]\nname = 'hopeless'\nvalue = 1000\nperiod = '40ms'\ndeadline = '30ms'\n\
                    node = [{ name = 'a', wcet = '10ms' }, { name = 'b', wcet = '10ms' }, { name = 'c', wcet = '10ms' }, \
                    { name = 'd', wcet = '10ms' }]\n";
    let long = task("long", "", (100, 100), &[("cpu", 65)]);
    let found = on_time(&format!("{hopeless}{long}{LATE_ONCE}"));
    assert!(found[1].0 + 2 >= found[1].1, "{found:?}");
}

#[test]
fn what_fits_into_the_gap_does_not_wait_with_a_long_node() {
    let tight = task("tight", "value = 1000", (20, 6), &[("cpu", 2)]);
    let long = task("long", "value = 5", (100, 200), &[("cpu", 24)]);
    let short = task("short", "value = 1", (20, 20), &[("cpu", 2)]);
    let found = on_time(&[tight, long, short].concat());
    assert!(100 * found[0].0 >= 98 * found[0].1 && 100 * found[2].0 >= 98 * found[2].1, "{found:?}");
}

#[test]
fn a_lane_waits_for_the_later_node_of_a_task_too() {
    let tight = task("tight", "value = 1000", (20, 20), &[("cpu", 1), ("gpu", 14)]);
    let long = task("long", "value = 1\noffset = '16ms'", (100, 200), &[("gpu", 24)]);
    let found = on_time(&[tight, long].concat());
    assert!(100 * found[0].0 >= 98 * found[0].1, "{found:?}");
}

/// A node that would come too early for a branch of a higher rank waits for it; its job is not given up.
#[test]
fn what_can_wait_is_not_given_up() {
    let high = task("high", "value = 1000", (40, 18), &[("gpu", 10), ("cpu", 6)]);
    for offset_ms in [0, 3, 6, 9, 12] {
        let long = task("long", &format!("offset = '{offset_ms}ms'"), (100, 200), &[("cpu", 20)]);
        let found = on_time(&format!("{high}{long}"));
        assert!(found.iter().all(|(on_time, due)| on_time == due), "{offset_ms} ms: {found:?}");
    }
}

/// A job above that others above interrupt has less time than it seems: 27 ms of `nav` and 4 ms every 10 fill 47 of 50.
#[test]
fn what_higher_values_take_together_is_left_to_them() {
    for offset_ms in [0, 3, 7] {
        let nav = task("nav", "value = 60", (50, 50), &[("cpu", 9), ("cpu", 9), ("cpu", 9)]);
        let control = task("control", "value = 900", (10, 10), &[("cpu", 4)]);
        let log = task("log", &format!("value = 2\noffset = '{offset_ms}ms'"), (25, 50), &[("cpu", 11)]);
        let found = on_time(&[nav, control, log].concat());
        assert!(found[..2].iter().all(|(on_time, due)| on_time + 9 >= *due), "{offset_ms} ms: {found:?}");
    }
}

/// A task that never fits makes no higher value lose jobs again and again because another one could do without waiting.
#[test]
fn one_lost_job_is_not_the_first_of_many() {
    let planner = task("planner", "value = 1000", (50, 50), &[("cpu", 18)]);
    let control = task("control", "value = 200", (10, 15), &[("cpu", 3)]);
    for (period, wcet) in [(8, 2), (9, 2), (8, 3)] {
        let radio = task("radio", "value = 10", (period, period), &[("cpu", wcet)]);
        let found = on_time(&[planner.clone(), control.clone(), radio].concat());
        assert!(found[..2].iter().all(|(on_time, due)| on_time + 9 >= *due), "{period} ms: {found:?}");
    }
}

/// A task that comes often and never has room costs a higher value no more than it takes to learn how long its nodes take.
#[test]
fn probes_of_what_comes_often_cost_little() {
    let high = task("high", "value = 1000", (30, 30), &[("cpu", 29)]);
    for period_ms in [5, 20] {
        let low = task("low", "", (period_ms, 60), &[("cpu", 4)]);
        let found = on_time(&format!("{high}{low}"));
        assert!(found[0].0 + 9 >= found[0].1, "{period_ms} ms: {found:?}");
    }
}

#[test]
fn a_job_of_an_older_graph_finds_its_lane_free() {
    let high = task("high", "value = 1000", (20, 18), &[("gpu", 10), ("cpu", 6)]);
    let long = task("long", "offset = '6ms'", (1000, 100), &[("cpu", 20)]);
    let edit = "[[event]]\nat = '5ms'\ntask = 'high'\nremove = ['n1']\n";
    let found = on_time(&format!("{high}{long}{edit}"));
    assert!(found[0].0 == found[0].1 && found[1].0 == found[1].1, "{found:?}");
}

#[test]
fn one_wait_of_a_task_with_time_is_not_remembered_for_hours() {
    let high = task("high", "value = 10", (20, 20), &[("cpu", 6)]);
    let low = task("low", "", (10, 8), &[("cpu", 4)]);
    let once = |name: &str, value: u32, wcet_ms: u64, deadline: &str| {
        format!(
            "[[task]]\nname = '{name}'\nonce = true\nvalue = {value}\ndeadline = '{deadline}'\n\
             [[task.node]]\nname = 'n'\nwcet = '{wcet_ms}ms'\n"
        )
    };
    let found = on_time(&[high, low, once("burst", 10, 9, "20ms"), once("idle", 1, 24, "3600s")].concat());
    assert!(found[1].0 + 30 >= found[1].1, "{found:?}");
}

/// A value of 1 costs a value of 1000 nothing that a lane can know of, however seldom its long node comes.
#[test]
fn a_long_node_that_comes_seldom_costs_a_higher_value_nothing() {
    for (period, deadline) in [(24, 200), (100, 200), (400, 200), (1_000, 400)] {
        let tight = task("tight", "value = 1000", (20, 20), &[("cpu", 16)]);
        let long = task("long", "value = 1", (period, deadline), &[("cpu", 24)]);
        let found = on_time(&[tight, long].concat());
        // One job in 17 of a task that lost all is a probe.
        assert!(found[0].0 + 1 + found[1].1 / 16 >= found[0].1, "every {period} ms: {found:?}");
    }
}

/// A floor needs no other rank: it is waited for by what is worth more, too.
#[test]
fn a_floor_is_waited_for_by_a_higher_value() {
    let owed = task("owed", "value = 1\nfloor = [1, 1]", (20, 20), &[("cpu", 16)]);
    let long = task("long", "value = 1000", (400, 200), &[("cpu", 24)]);
    let found = on_time(&[owed, long].concat());
    assert_eq!(found[0].0, found[0].1, "{found:?}");
}

/// What has to run side by side on too few lanes has less to spare than its longest path says.
#[test]
fn parallel_nodes_of_a_higher_value_lose_nothing_to_a_lower_one() {
    let side_by_side = "node = [{ name = 'a', wcet = '8ms' }, { name = 'b', wcet = '8ms' }]\n";
    let diamond = "node = [{ name = 'cam', wcet = '2ms' }, { name = 'a', wcet = '6ms', after = ['cam'] }, \
                   { name = 'b', wcet = '6ms', after = ['cam'] }, { name = 'out', wcet = '2ms', after = ['a', 'b'] }]\n";
    for (shape, period) in [(side_by_side, 20), (side_by_side, 400), (diamond, 20), (diamond, 400)] {
        let low = task("low", "value = 1", (period, 2 * period), &[("cpu", 10)]);
        let high =
            "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '20ms'\n";
        for tasks in [format!("{low}{high}{shape}"), format!("{high}{shape}{low}")] {
            let found = on_time(&tasks);
            let high = found[usize::from(tasks.starts_with(&low))];
            assert_eq!(high.0, high.1, "{tasks}");
        }
    }
}

/// Jobs of a higher value that overlap need several lanes, each to its end.
#[test]
fn overlapping_jobs_of_a_higher_value_lose_next_to_nothing_to_a_lower_one() {
    let high = task("high", "value = 1000\nfloor = [1, 1]", (12, 18), &[("cpu", 8), ("cpu", 8)]);
    let low = task("low", "value = 1", (20, 40), &[("cpu", 16)]);
    for tasks in [[low.as_str(), &high].concat(), [high.as_str(), &low].concat()] {
        let found = on_time_on(2, &tasks);
        let high = found[usize::from(tasks.starts_with(&low))];
        assert!(100 * high.0 >= 99 * high.1, "{found:?}: {tasks}");
    }
}

/// A graph that needs the second lane for a branch is late if a lower one has it, whichever of several that is.
#[test]
fn a_higher_value_whose_branches_need_two_lanes_loses_nothing_to_several_lower_ones() {
    let high = "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '20ms'\n\
                node = [{ name = 'a', wcet = '2400us' }, { name = 'b', wcet = '8ms', after = ['a'] }, \
                { name = 'c', wcet = '8ms', after = ['a'] }, { name = 'd', wcet = '2400us', after = ['b', 'c'] }]\n";
    for ms in [24, 40] {
        let low = |name: &str| task(name, "value = 1", (50, 100), &[("cpu", ms)]);
        for tasks in [[high, &low("l0"), &low("l1")].concat(), [&low("l0"), &low("l1"), high].concat()] {
            let found = on_time_on(2, &tasks);
            let high = found[if tasks.starts_with(high) { 0 } else { 2 }];
            assert_eq!(high.0, high.1, "{found:?}: {tasks}");
        }
    }
}

/// What needs both lanes is late if a lower one has one of them, however many nodes it has.
#[test]
fn a_higher_value_that_needs_all_lanes_gets_them() {
    let nodes = |of: &[(&str, u64, &str)]| {
        let node = |(name, ms, after): &(&str, u64, &str)| {
            format!("[[task.node]]\nname = '{name}'\nwcet = '{ms}ms'\nafter = [{after}]\n")
        };
        of.iter().map(node).collect::<String>()
    };
    let diamonds = nodes(&[
        ("a", 2, ""),
        ("b", 6, "'a'"),
        ("c", 6, "'a'"),
        ("d", 2, "'b', 'c'"),
        ("e", 2, ""),
        ("f", 6, "'e'"),
        ("g", 6, "'e'"),
        ("h", 2, "'f', 'g'"),
    ]);
    let side_by_side = nodes(&["a", "b", "c", "d", "e", "f", "g", "h"].map(|name| (name, 4, "")));
    for (shape, period, wcet) in [(&diamonds, 400, 10), (&diamonds, 20, 10), (&side_by_side, 40, 20)] {
        let low = |name| task(name, "value = 1", (period, 2 * period), &[("cpu", wcet)]);
        let high =
            "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '20ms'\n";
        let tasks = format!("{}{}{high}{shape}", low("one"), low("other"));
        let found = on_time_on(2, &tasks);
        assert_eq!(found[2].0, found[2].1, "{found:?}: {tasks}");
    }
}

/// Nodes are not divided, and what is behind a first node has less time than the deadline: such a job needs more lanes than its work
/// over its deadline.
#[test]
fn a_higher_value_whose_nodes_need_more_lanes_than_its_work_loses_nothing() {
    let node = |name: &str, us: u64, after: &str| {
        format!("[[task.node]]\nname = '{name}'\nwcet = '{us}us'\nafter = [{after}]\n")
    };
    let side_by_side = |us: [u64; 3]| {
        ["a", "b", "c"].iter().zip(us).map(|(name, us)| node(name, us, "")).collect::<String>()
    };
    let fork = |us: [u64; 5]| {
        let behind = ["b", "c", "d", "e"].iter().zip(&us[1..]).map(|(name, us)| node(name, *us, "'a'"));
        node("a", us[0], "") + &behind.collect::<String>()
    };
    let shapes = [
        (3, side_by_side([12_000; 3]), 24),
        (4, fork([8_900, 7_700, 4_800, 7_900, 9_000]), 24),
        (2, side_by_side([8_000, 7_300, 10_200]), 6),
    ];
    for (lanes, shape, wcet) in shapes {
        let low = task("low", "value = 1", (6 * wcet, 5 * wcet), &[("cpu", wcet)]);
        let high =
            "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '20ms'\n";
        for tasks in [format!("{low}{high}{shape}"), format!("{high}{shape}{low}")] {
            let found = on_time_on(lanes, &tasks);
            let high = found[usize::from(tasks.starts_with(&low))];
            assert_eq!(high.0, high.1, "{found:?}: {tasks}");
        }
    }
}

/// What comes between does not take the place of a lane that a higher value needs.
#[test]
fn a_higher_value_on_all_lanes_loses_nothing_where_a_third_task_comes_between() {
    for lanes in [2, 3, 4] {
        let nodes: String =
            (0..lanes).map(|i| format!("[[task.node]]\nname = 'n{i}'\nwcet = '8ms'\n")).collect();
        let high =
            "[[task]]\nname = 'high'\nvalue = 1000\nfloor = [1, 1]\nperiod = '20ms'\ndeadline = '11ms'\n";
        let mid = task("mid", "value = 10", (11, 11), &[("cpu", 1)]);
        let low = task("low", "value = 1", (32, 120), &[("cpu", 59)]);
        for tasks in [[&low, &mid, high, &nodes].concat(), [high, &nodes, &mid, &low].concat()] {
            let found = on_time_on(lanes, &tasks);
            let high = found[if tasks.starts_with(&low) { 2 } else { 0 }];
            assert_eq!(high.0, high.1, "{found:?}: {tasks}");
        }
    }
}

/// A job that fits on all lanes with room to spare may find all but one of them held.
#[test]
fn a_higher_value_loses_nothing_where_a_lower_one_holds_the_lanes_that_it_can_do_without() {
    let side_by_side = |ms: &[u64]| -> String {
        let node = |(nth, ms)| format!("[[task.node]]\nname = 'n{nth}'\nwcet = '{ms}ms'\n");
        ms.iter().enumerate().map(node).collect()
    };
    let task = |name: &str, value: u32, period: u64, deadline: u64, nodes: &str| {
        format!(
            "[[task]]\nname = '{name}'\nvalue = {value}\nperiod = '{period}ms'\ndeadline = '{deadline}ms'\n{nodes}"
        )
    };
    let chain = "[[task.node]]\nname = 'x'\nwcet = '6ms'\n[[task.node]]\nname = 'y'\nwcet = '4ms'\nafter = ['x']\n\
                 [[task.node]]\nname = 'z'\nwcet = '17ms'\nafter = ['y']\n";
    let pairs = [
        (task("low", 1, 20, 40, &side_by_side(&[21, 5, 5])), (21, 18, side_by_side(&[9, 8]))),
        (task("low", 1, 20, 80, chain), (17, 12, side_by_side(&[6, 4]))),
        (task("low", 1, 20, 40, &side_by_side(&[15, 4, 4])), (20, 20, side_by_side(&[10, 9]))),
    ];
    for (low, (period, deadline, nodes)) in pairs {
        let high = task("high", 1_000, period, deadline, &format!("floor = [1, 1]\n{nodes}"));
        for tasks in [format!("{low}{high}"), format!("{high}{low}")] {
            let found = on_time_on(2, &tasks);
            let high = found[usize::from(tasks.starts_with(&low))];
            assert_eq!(high.0, high.1, "{found:?}: {tasks}");
        }
    }
}

/// Each would be in time behind the lower node alone, but not both.
#[test]
fn several_of_a_higher_value_lose_nothing_to_a_lower_one_together() {
    let sets = [
        [("a", "value = 1000", (20, 20), 5), ("b", "value = 100", (20, 20), 11), ("low", "", (30, 30), 9)],
        [("a", "value = 1000", (10, 15), 3), ("b", "value = 100", (8, 8), 2), ("low", "", (12, 12), 6)],
    ];
    for set in sets {
        for floor in ["", "\nfloor = [1, 1]"] {
            let file = |(name, rest, times, wcet): (&str, &str, (u64, u64), u64)| {
                let floor = if rest.is_empty() { "" } else { floor };
                task(name, &format!("{rest}{floor}"), times, &[("cpu", wcet)])
            };
            for turned in [false, true] {
                let mut tasks = set.map(file);
                if turned {
                    tasks.reverse();
                }
                let mut found = on_time(&tasks.concat());
                if turned {
                    found.reverse();
                }
                // But for probes, which no floor of [1, 1] lets pass.
                let percent = if floor.is_empty() { 97 } else { 100 };
                let is_whole = |(on_time, due): (u64, u64)| 100 * on_time >= percent * due;
                assert!(is_whole(found[0]) && is_whole(found[1]), "{found:?}");
            }
        }
    }
}

/// What is late because of the lower node comes after that has ended, behind what waited for it.
#[test]
fn a_higher_value_that_comes_behind_the_lower_node_loses_nothing() {
    let high = task("high", "value = 1000\noffset = '1ms'", (20, 20), &[("cpu", 10)]);
    let next = task("next", "value = 100\noffset = '12ms'", (20, 8), &[("cpu", 6)]);
    let low = task("low", "offset = '40ms'", (100, 100), &[("cpu", 5)]);
    let found = on_time(&[low, high, next].concat());
    assert!(found[1].0 == found[1].1 && found[2].0 == found[2].1, "{found:?}");
}
