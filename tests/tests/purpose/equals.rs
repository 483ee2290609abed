//! Tasks of one value share: none has nothing while others have much, whatever the order in the file and whatever was believed of it.

use super::sets::{Set, Task, Wish};
use super::{SECOND_NS, kinds, sets};
use red_sim::{Execution, Options, simulate};
use red_tests::differential::options;
use red_tests::oracle;
use red_workload::policy::Policy;
use red_workload::{Format, parse};

/// A task of one node.
fn task(name: &str, period_us: u32, deadline_us: u32, wcet_us: u32, rest: &str) -> String {
    format!(
        "[[task]]\nname = '{name}'\nperiod = '{period_us}us'\ndeadline = '{deadline_us}us'\n{rest}\n\
         node = [{{ name = 'n', wcet = '{wcet_us}us' }}]\n"
    )
}

/// Jobs on time in a minute by task, where nodes take these thousandths of their WCETs.
fn on_time(lanes: u32, tasks: &[&str], permille: u32) -> Vec<(String, u64)> {
    let text = format!("[[pool]]\nname = 'cpu'\nlanes = {lanes}\n{}", tasks.concat());
    let workload = parse(text.as_bytes(), Format::Toml, "equals.toml").unwrap_or_else(|e| panic!("{e}"));
    let part_ppm = permille * 1_000;
    let execution = Execution::Uniform { low_ppm: part_ppm, high_ppm: part_ppm };
    let options = Options { execution, ..options(oracle::Policy::Redrt, 60 * SECOND_NS) };
    let report = simulate(&workload, &options).expect("it fits");
    report.tasks.iter().map(|task| (task.name.clone(), task.on_time)).collect()
}

/// The least of the equals, of which each name begins with `e`, beside the greatest.
fn extremes(on_time: &[(String, u64)]) -> (u64, u64) {
    let equals = || on_time.iter().filter(|(name, _)| name.starts_with('e')).map(|(_, on_time)| *on_time);
    (equals().min().unwrap_or(0), equals().max().unwrap_or(0))
}

/// Two cameras of one kind, where a WCET a little too long leaves room for neither and the lane has time for one.
#[test]
fn two_of_a_kind_share_what_a_long_wcet_denied_them() {
    let high = task("high", 12_000, 12_000, 7_000, "value = 50");
    let equal = |name: &str| task(name, 12_000, 12_000, 5_500, "value = 2");
    let (one, other, third) = (equal("e1"), equal("e2"), equal("e3"));
    for tasks in [&[&*high, &one, &other][..], &[&one, &other, &high], &[&one, &high, &other, &third]] {
        let all = on_time(1, tasks, 950);
        let (least, greatest) = extremes(&all);
        assert!(least * 2 >= greatest && greatest > 1_000, "{all:?}");
    }
}

/// Five of a kind, whose keys are equal, in the gaps that a floor leaves.
#[test]
fn five_of_a_kind_share_the_gaps_of_a_floor() {
    let floor = "[[task]]\nname = 'floor'\nperiod = '10ms'\ndeadline = '10ms'\nfloor = [1, 1]\n\
                 node = [{ name = 'a', wcet = '4641us' }, { name = 'b', wcet = '7934us' }]\n";
    let equals: Vec<String> =
        (0..5).map(|nth| task(&format!("e{nth}"), 20_000, 40_000, 5_885, "value = 5")).collect();
    let tasks: Vec<&str> = std::iter::once(floor).chain(equals.iter().map(String::as_str)).collect();
    let all = on_time(2, &tasks, 1_000);
    let (least, greatest) = extremes(&all);
    assert!(all[0].1 == 6_000, "the floor: {all:?}");
    assert!(least * 2 >= greatest && greatest > 900, "{all:?}");
}

/// Where one of them never fits, it does not keep another one from what it could have.
#[test]
fn one_that_never_fits_leaves_others_their_turn() {
    let chain = |name: &str, ms: &str| {
        format!(
            "[[task]]\nname = '{name}'\nperiod = '25ms'\ndeadline = '25ms'\nvalue = 5\n\
             node = [{{ name = 'a', wcet = '{ms}' }}, {{ name = 'b', wcet = '{ms}', after = ['a'] }}]\n"
        )
    };
    let floor = "[[task]]\nname = 'floor'\nperiod = '10ms'\ndeadline = '10ms'\nfloor = [1, 1]\n\
                 node = [{ name = 'a', wcet = '6017us' }, { name = 'b', wcet = '7158us' }]\n";
    let (one, small, large) =
        (task("e0", 25_000, 25_000, 6_270, "value = 5"), chain("small", "3969us"), chain("large", "5814us"));
    let all = on_time(2, &[floor, &one, &small, &large], 1_000);
    assert!(extremes(&all).0 >= 20, "{all:?}");
}

#[test]
fn none_of_equals_gets_nothing() {
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (2, 5), lanes, load_percent: 0, times, values: &[7], floors: false };
        for (seed, set) in sets(wish, 4) {
            let longest = set.tasks.iter().map(Task::longest_node_ns).max().unwrap_or(0);
            let horizon = 40 * set.tasks.iter().map(|task| task.period_ns).max().unwrap_or(0);
            let all = set.on_time(Policy::Redrt, horizon);
            for (name, on_time, due) in &all {
                let alone = set.part(|task| task.name == *name, longest);
                let fits = |alone: Set| alone.on_time(Policy::Edf, horizon)[0].1 == *due;
                assert!(
                    *on_time > 0 || !alone.is_some_and(fits),
                    "seed {seed}, {lanes} lanes, {times:?}: {name} has none of {due}: {all:?}"
                );
            }
        }
    }
}

/// Nor where all periods are of one grid.
#[test]
fn none_of_equals_on_a_grid_gets_nothing() {
    // Period, deadline and nodes in ms; each after the one before it, or all side by side.
    let tasks = [
        (40, 80, [2, 2].as_slice(), false),
        (40, 80, &[1, 5], false),
        (20, 20, &[5, 10], true),
        (20, 40, &[10, 1, 2], true),
        (10, 10, &[2, 5], true),
    ];
    let mut text = String::from("[[pool]]\nname = 'cpu'\nlanes = 1\n");
    for (nth, (period, deadline, nodes, is_chain)) in tasks.iter().enumerate() {
        text += &format!("[[task]]\nname = 't{nth}'\nperiod = '{period}ms'\ndeadline = '{deadline}ms'\n");
        for (at, ms) in nodes.iter().enumerate() {
            let after = if *is_chain && at > 0 { format!("after = ['n{}']", at - 1) } else { String::new() };
            text += &format!("[[task.node]]\nname = 'n{at}'\nwcet = '{ms}ms'\n{after}\n");
        }
    }
    let workload = parse(text.as_bytes(), Format::Toml, "grid.toml").unwrap_or_else(|e| panic!("{e}"));
    let report = simulate(&workload, &options(oracle::Policy::Redrt, 20 * SECOND_NS)).expect("it fits");
    let on_time: Vec<u64> = report.tasks.iter().map(|task| task.on_time).collect();
    assert!(on_time.iter().all(|on_time| *on_time >= 20), "{on_time:?}");
}

/// Nor where a floor comes first, whatever the order in the file.
#[test]
fn none_of_equals_gets_nothing_beside_a_floor() {
    let floor = task("floor", 10_000, 10_000, 6_000, "floor = [1, 2]");
    let slow = task("slow", 20_000, 20_000, 6_000, "value = 2");
    let fast = task("fast", 10_000, 20_000, 6_000, "value = 2");
    let short = task("short", 10_000, 10_000, 3_000, "value = 2");
    for tasks in
        [[&slow, &floor, &fast, &short], [&floor, &fast, &slow, &short], [&short, &fast, &slow, &floor]]
    {
        let all = on_time(1, &tasks.map(String::as_str), 1_000);
        assert!(all.iter().all(|(_, on_time)| *on_time >= 60), "{all:?}");
    }
}
