//! What overload is to be like for whoever owns the robot. Nothing here knows by what rule.

mod carried;
mod clock;
mod equals;
mod floors;
mod needs;
mod sets;
mod told;
mod waits;
mod whole;

use red_sim::{Execution, simulate};
use red_tests::differential::options;
use red_tests::oracle;
use red_workload::metrics::JobEnd;
use red_workload::policy::Policy;
use red_workload::{Format, parse};
use sets::{Set, Task, Times, Wish};

const SECOND_NS: u64 = 1_000_000_000;
/// Values of a set: equal ones, and such that are far apart.
const VALUES: &[u32] = &[1, 1, 3, 10, 100, 1_000];
const LOADS: [u64; 5] = [110, 133, 150, 200, 300];

/// Numbers of lanes, each with each kind of execution times.
fn kinds() -> impl Iterator<Item = (u64, Times)> {
    [1, 2, 4].into_iter().flat_map(|lanes| Times::ALL.map(|times| (lanes, times)))
}

/// Sets of some kind, each with a seed: as many for each load.
fn sets(wish: Wish, of_each: u64) -> impl Iterator<Item = (u64, Set)> {
    let seeds = (0..of_each * LOADS.len() as u64).zip(LOADS.into_iter().cycle());
    seeds.map(move |(seed, load_percent)| (seed, Set::draw(seed, Wish { load_percent, ..wish })))
}

/// A group is the tasks from some value up. It is protected if all of it is on time without the others, with deadlines that
/// are shorter by the longest node of these: so long may somebody who holds a lane keep it.
#[test]
fn what_is_worth_more_is_not_late_because_of_what_is_worth_less() {
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (2, 5), lanes, load_percent: 0, times, values: VALUES, floors: false };
        let (mut groups, mut broken) = (0, Vec::new());
        for (seed, set) in sets(wish, 8) {
            let among_others = set.on_time(Policy::Redrt, 4 * SECOND_NS);
            let mut values: Vec<u32> = set.tasks.iter().map(|task| task.value).collect();
            values.sort_unstable();
            values.dedup();
            for least in values.into_iter().skip(1) {
                let others = set.tasks.iter().filter(|task| task.value < least);
                let longest = others.map(Task::longest_node_ns).max().unwrap_or(0);
                let Some(alone) = set.part(|task| task.value >= least, longest) else { continue };
                if alone.on_time(Policy::Edf, 4 * SECOND_NS).iter().any(|(_, on_time, due)| on_time < due) {
                    continue;
                }
                groups += 1;
                let is_whole = |(name, on_time, due): &(String, u64, u64)| {
                    alone.tasks.iter().all(|task| task.name != *name) || 100 * on_time >= 99 * due
                };
                if !among_others.iter().all(is_whole) {
                    broken.push((seed, least, among_others.clone()));
                }
            }
        }
        let whole_percent = 100 * (groups - broken.len()) / groups;
        let must_percent = 95;
        assert!(
            groups >= 20 && whole_percent >= must_percent,
            "{lanes} lanes, {times:?}: {whole_percent} % of {groups} groups are whole; broken (seed, least value, \
             on time of due): {broken:?}"
        );
    }
}

#[test]
fn the_order_of_tasks_in_the_file_changes_nothing() {
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (2, 5), lanes, load_percent: 0, times, values: VALUES, floors: true };
        for (seed, set) in sets(wish, 2) {
            let mut turned = set.clone();
            turned.tasks.reverse();
            assert_eq!(told(&set), told(&turned), "seed {seed}, {lanes} lanes, {times:?}:\n{}", set.file());
        }
    }
}

/// All that is said of each task, in the order of their names.
fn told(set: &Set) -> Vec<String> {
    let report = set.run(Policy::Redrt, SECOND_NS);
    let mut tasks: Vec<String> =
        report.tasks.iter().map(|task| serde_json::to_string(task).expect("it is plain")).collect();
    tasks.sort();
    tasks
}

/// With room for a job and two thirds in its deadline. Where nobody knows before how long a job takes, no rule can choose
/// those that fit.
#[test]
fn one_task_alone_gets_what_the_lanes_can_carry() {
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (1, 1), lanes, load_percent: 0, times, values: &[1], floors: false };
        let mut shares = Vec::new();
        for (seed, mut set) in sets(wish, 6) {
            let task = &mut set.tasks[0];
            task.jitter = false;
            let alone = task.path_ns().max(task.work_ns().div_ceil(lanes));
            task.deadline_ns = alone * 165 / 100 + task.longest_node_ns();
            let (mean, time) = (task.work_ns() * times.mean_percent() / 100, 200 * task.period_ns);
            let (_, on_time, due) = set.on_time(Policy::Redrt, time)[0].clone();
            let can = due.min(time * lanes / mean);
            shares.push((100 * on_time / can, seed));
        }
        let mean = shares.iter().map(|share| share.0).sum::<u64>() / shares.len() as u64;
        let must = if times == Times::Wcet { 97 } else { 95 };
        assert!(mean >= must, "{lanes} lanes, {times:?}: {mean} % in the mean of (share, seed) {shares:?}");
    }
}

/// Nor do tasks that are alike and come together, beside what is worth more and leaves no room: their probes take turns.
#[test]
fn probes_that_come_together_take_turns() {
    let task = |name: &str, value: u32, period_ms: u64, deadline_ms: u64, wcet_ms: u64| {
        format!(
            "[[task]]\nname = '{name}'\nvalue = {value}\nperiod = '{period_ms}ms'\ndeadline = '{deadline_ms}ms'\n\
             [[task.node]]\nname = 'n'\nwcet = '{wcet_ms}ms'\n"
        )
    };
    let low: String = (0..4).map(|nth| task(&format!("low{nth}"), 1, 24, 48, 24)).collect();
    let text = format!("[[pool]]\nname = 'cpu'\nlanes = 1\n{}{low}", task("high", 1000, 20, 20, 16));
    let workload = parse(text.as_bytes(), Format::Toml, "probes.toml").unwrap_or_else(|e| panic!("{e}"));
    let report = simulate(&workload, &options(oracle::Policy::Redrt, 60 * SECOND_NS)).expect("it fits");
    let on_time: Vec<u64> = report.tasks.iter().map(|task| task.on_time).collect();
    // Once it is known how long they take, no lane is left to them.
    assert!(on_time[0] >= 2_950, "{on_time:?}");
    assert!(on_time[1..].iter().all(|own| *own >= 8), "{on_time:?}");
}

/// Tasks that are alike share a full table, wherever they are in the file.
#[test]
fn equals_share_a_full_table() {
    for tasks in 2..=4 {
        let imu = |nth: usize| {
            format!(
                "[[task]]\nname = 'imu{nth}'\nperiod = '1ms'\ndeadline = '200ms'\n[[task.node]]\nname = 'n'\nwcet = '2ms'\n"
            )
        };
        let text: String = (0..tasks).map(imu).collect();
        let text = format!("[[pool]]\nname = 'cpu'\nlanes = 1\n{text}");
        let workload = parse(text.as_bytes(), Format::Toml, "imu.toml").unwrap_or_else(|e| panic!("{e}"));
        let options = options(oracle::Policy::Redrt, 4 * SECOND_NS);
        let report = simulate(&workload, &options).expect("the tasks fit");
        let on_time: Vec<u64> = report.tasks.iter().map(|task| task.on_time).collect();
        let share = on_time.iter().sum::<u64>() / tasks as u64;
        assert!(on_time.iter().sum::<u64>() >= 1_900, "{on_time:?}");
        assert!(on_time.iter().all(|own| 10 * own.abs_diff(share) <= share), "{on_time:?}");
    }
}

/// A task with one job in flight does not pay for the places that its equal fills, wherever it is in the file.
#[test]
fn who_fills_the_table_gives_way_in_it() {
    let task = |name: &str, period_ms: u64, deadline_ms: u64, wcet: &str, floor: &str| {
        format!(
            "[[task]]\nname = '{name}'\nperiod = '{period_ms}ms'\ndeadline = '{deadline_ms}ms'\n{floor}\n\
             [[task.node]]\nname = 'n'\nwcet = '{wcet}'\n"
        )
    };
    let imu = task("imu", 1, 200, "1500us", "");
    let camera = task("camera", 20, 20, "3ms", "");
    let control = task("control", 20, 20, "3ms", "floor = [1, 1]");
    for tasks in [[&imu, &camera, &control], [&control, &camera, &imu], [&camera, &control, &imu]] {
        let text = format!("[[pool]]\nname = 'cpu'\nlanes = 1\n{}", tasks.map(String::as_str).concat());
        let workload = parse(text.as_bytes(), Format::Toml, "full.toml").unwrap_or_else(|e| panic!("{e}"));
        let report =
            simulate(&workload, &options(oracle::Policy::Redrt, 4 * SECOND_NS)).expect("the tasks fit");
        let of =
            |name: &str| report.tasks.iter().find(|task| task.name == name).map_or(0, |task| task.on_time);
        assert!(of("camera") >= 196 && of("control") == 200 && of("imu") >= 1_800, "{:?}", report.tasks);
    }
}

/// One graph whose deadline leaves little is not late again and again by a bit: who would be, leaves the lanes to the next one.
#[test]
fn one_graph_with_a_tight_deadline_gets_what_the_lanes_can_carry() {
    // Lanes; costs of nodes side by side, period and deadline in us; times in permille of the WCET.
    let graphs = [
        (1, [1_885, 12_933].as_slice(), 13_470, 22_227, (900, 1_000)),
        (2, &[20_000, 20_000], 12_000, 30_000, (974, 978)),
        (3, &[20_000, 20_000, 20_000], 12_000, 30_000, (974, 978)),
        (1, &[10_000], 9_000, 16_000, (900, 1000)),
    ];
    for (lanes, nodes, period, deadline, (low, high)) in graphs {
        let node = |(nth, us): (usize, &u64)| format!("[[task.node]]\nname = 'n{nth}'\nwcet = '{us}us'\n");
        let nodes_text: String = nodes.iter().enumerate().map(node).collect();
        let text = format!(
            "[[pool]]\nname = 'cpu'\nlanes = {lanes}\n[[task]]\nname = 't'\nperiod = '{period}us'\n\
             deadline = '{deadline}us'\n{nodes_text}"
        );
        let workload = parse(text.as_bytes(), Format::Toml, "tight.toml").unwrap_or_else(|e| panic!("{e}"));
        let mut options = options(oracle::Policy::Redrt, 20 * SECOND_NS);
        options.execution = Execution::Uniform { low_ppm: low * 1_000, high_ppm: high * 1_000 };
        let report = simulate(&workload, &options).expect("it fits");
        let work_ns = nodes.iter().sum::<u64>() * u64::from(low + high) / 2;
        let can = (20 * SECOND_NS * lanes / work_ns).min(20 * SECOND_NS / (period * 1000));
        let on_time = report.tasks[0].on_time;
        assert!(100 * on_time >= 93 * can, "{on_time} of {can}: {text}");
    }
}

/// A chain on two lanes that are asked for a tenth too much: who is given up is one that would be late in any case, and not
/// one after another that only had the most left to do.
#[test]
fn a_chain_on_two_lanes_gets_what_these_can_carry() {
    let node = |(nth, ms): (usize, &u64)| {
        let after = nth.checked_sub(1).map(|before| format!("'n{before}'")).unwrap_or_default();
        format!("[[task.node]]\nname = 'n{nth}'\nwcet = '{ms}ms'\nafter = [{after}]\n")
    };
    let nodes: String = [2, 9, 3, 4, 5, 14, 3].iter().enumerate().map(node).collect();
    let text = format!(
        "[[pool]]\nname = 'cpu'\nlanes = 2\n[[task]]\nname = 't'\nperiod = '18181818ns'\ndeadline = '66ms'\n{nodes}"
    );
    let workload = parse(text.as_bytes(), Format::Toml, "chain.toml").unwrap_or_else(|e| panic!("{e}"));
    let report = simulate(&workload, &options(oracle::Policy::Redrt, 8 * SECOND_NS)).expect("it fits");
    let (on_time, can) = (report.tasks[0].on_time, 8_000 * 2 / 40);
    assert!(100 * on_time >= 98 * can, "{on_time} of {can}");
}

/// A job that will be late anyway takes no lane before others that would be in time: what it began would keep the next one late.
#[test]
fn who_is_late_anyway_takes_no_lane_before_others() {
    let chain = [("5465us", ""), ("6991us", "'n0'"), ("14719us", "'n1'")];
    let forks = [("11177us", ""), ("2374us", "'n0'"), ("8478us", "'n0'"), ("13760us", "'n1', 'n2'")];
    let joins = [
        ("24420us", ""),
        ("10676us", "'n0'"),
        ("21354us", "'n0', 'n1'"),
        ("21990us", "'n1', 'n2'"),
        ("26840us", "'n0'"),
    ];
    let graphs = [
        (chain.as_slice(), 11_222, 40_763, 27_175),
        (&forks, 15_592, 57_263, 35_789),
        (&joins, 48_619, 131_601, 105_280),
    ];
    for (nodes, period, deadline, work_us) in graphs {
        let node = |(nth, (wcet, after)): (usize, &(&str, &str))| {
            format!("[[task.node]]\nname = 'n{nth}'\nwcet = '{wcet}'\nafter = [{after}]\n")
        };
        let nodes_text: String = nodes.iter().enumerate().map(node).collect();
        let text = format!(
            "[[pool]]\nname = 'cpu'\nlanes = 1\n[[task]]\nname = 't'\nperiod = '{period}us'\n\
             deadline = '{deadline}us'\n{nodes_text}"
        );
        let workload = parse(text.as_bytes(), Format::Toml, "late.toml").unwrap_or_else(|e| panic!("{e}"));
        let report = simulate(&workload, &options(oracle::Policy::Redrt, 20 * SECOND_NS)).expect("it fits");
        let (can, on_time) = (20_000_000 / work_us, report.tasks[0].on_time);
        assert!(100 * on_time >= 95 * can, "{on_time} of {can}: {text}");
    }
}

/// A task that has an hour keep it in mind.
#[test]
fn a_task_with_time_does_not_make_a_burst_last() {
    let task = |name: &str, rest: &str| format!("[[task]]\nname = '{name}'\n{rest}\n");
    let node = |name: &str, ms: u64, after: &str| {
        format!("[[task.node]]\nname = '{name}'\nwcet = '{ms}ms'\nafter = [{after}]\n")
    };
    let upload: String = (0..100)
        .map(|nth: usize| {
            let after = nth.checked_sub(1).map(|before| format!("'n{before}'")).unwrap_or_default();
            node(&format!("n{nth}"), 1, &after)
        })
        .collect();
    // `low` is in time by deadline, and every other time late if what is worth more goes first.
    let text = [
        "[[pool]]\nname = 'cpu'\nlanes = 1\n".to_owned(),
        task("high", "period = '20ms'\ndeadline = '20ms'\nvalue = 10"),
        node("n", 6, ""),
        task("low", "period = '10ms'\ndeadline = '8ms'"),
        node("n", 4, ""),
        task("burst", "once = true\ndeadline = '20ms'\nvalue = 10"),
        node("n", 9, ""),
        task("upload", "once = true\ndeadline = '3600s'\nvalue = 1000"),
        upload,
    ]
    .concat();
    let workload = parse(text.as_bytes(), Format::Toml, "upload.toml").unwrap_or_else(|e| panic!("{e}"));
    let options = options(oracle::Policy::Redrt, 4 * SECOND_NS);
    let sheds = simulate(&workload, &options).expect("the tasks fit").sheds.unwrap_or_default();
    let last_ns = sheds.iter().map(|shed| shed.at_ns).max();
    assert!(last_ns.is_some_and(|last_ns| last_ns < SECOND_NS), "felt, and over: {sheds:?}");
}

/// A burst that is over leaves nothing behind: who fits is on time again, a second and a half later.
#[test]
fn what_fits_is_whole_again_after_a_burst() {
    let mut seen = 0;
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (2, 4), lanes, load_percent: 0, times, values: VALUES, floors: false };
        for seed in 0..30 {
            let mut set = Set::draw(seed, Wish { load_percent: 75, ..wish });
            if set.on_time(Policy::Redrt, 4 * SECOND_NS).iter().any(|(_, on_time, due)| on_time < due) {
                continue;
            }
            seen += 1;
            let usual = set.tasks.len();
            let burst =
                Set::draw(seed + 100, Wish { load_percent: 200, tasks: (1, 1), values: &[500], ..wish });
            set.tasks.extend(burst.tasks.into_iter().map(|task| Task {
                name: "burst".to_owned(),
                until_ns: SECOND_NS,
                ..task
            }));
            let report = set.run(Policy::Redrt, 4 * SECOND_NS);
            let later = |job: &&JobEnd| (5 * SECOND_NS..7 * SECOND_NS).contains(&(2 * job.release_ns));
            let is_late =
                |job: &&JobEnd| job.shed.is_some() || job.at_ns.is_none_or(|at| at > job.deadline_ns);
            let late = report.jobs[..usual].iter().flatten().filter(later).filter(is_late).count();
            assert_eq!(late, 0, "seed {seed}, {lanes} lanes, {times:?}: {report:?}");
        }
    }
    assert!(seen >= 50, "{seen} sets fit");
}
