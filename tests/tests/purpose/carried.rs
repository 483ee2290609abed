//! What fits needs no rule for overload, whoever waits behind whom.

use super::sets::{Set, Task, Times, Wish, nodes};
use super::{SECOND_NS, VALUES, kinds};
use red_sim::{Execution, Options, World, simulate, simulate_in};
use red_tests::oracle;
use red_tests::rng::Rng;
use red_workload::build::Numbered;
use red_workload::metrics::JobEnd;
use red_workload::policy::Policy;
use red_workload::{Format, parse};

const HORIZON_NS: u64 = 4 * SECOND_NS;

/// Jobs late under a policy, and jobs due.
fn late(set: &Set, policy: Policy) -> (u64, u64) {
    let all = set.on_time(policy, HORIZON_NS);
    all.iter().fold((0, 0), |(late, all), (_, on_time, due)| (late + due - on_time, all + due))
}

/// Sets of some kind in which EDF has every job on time; REDRT then loses no more than one in so many.
fn carried(what: &str, sets: impl Iterator<Item = Set>, one_in: u64) {
    let (mut whole, mut lost, mut all, mut worst) = (0, 0, 0, (0, String::new()));
    for set in sets.filter(|set| late(set, Policy::Edf).0 == 0) {
        let (late, due) = late(&set, Policy::Redrt);
        (whole, lost, all) = (whole + 1, lost + late, all + due);
        worst = worst.max((late, set.file()));
    }
    assert!(
        whole >= 20 && lost <= all / one_in,
        "{what}: {lost} of {all} jobs in {whole} sets are late; the most, {}, in\n{}",
        worst.0,
        worst.1
    );
}

#[test]
fn what_edf_carries_is_carried() {
    for (lanes, times) in kinds() {
        let wish = Wish { tasks: (1, 4), lanes, load_percent: 0, times, values: VALUES, floors: false };
        let sets = (0..40).map(|seed| Set::draw(seed, Wish { load_percent: 70 + 5 * (seed % 6), ..wish }));
        carried(&format!("{lanes} lanes, {times:?}"), sets, 250);
    }
}

/// Of two jobs alike the one with the longer way to go is the newer one, and that is not the one that is due.
#[test]
fn tasks_of_one_graph_are_carried() {
    for (lanes, times) in kinds() {
        let sets = (0..80).map(|seed| {
            let rng = &mut Rng::new(seed);
            let (count, nodes) = (rng.within(1, 3), nodes(rng));
            let task = Task {
                name: String::new(),
                value: 1,
                floor: None,
                period_ns: 0,
                deadline_ns: 0,
                nodes,
                jitter: false,
                seed,
                until_ns: u64::MAX,
            };
            let mean = task.work_ns() * times.mean_percent() / 100;
            let period_ns = 100 * count * mean / (lanes * rng.within(75, 95));
            let alone = task.path_ns().max(task.work_ns().div_ceil(lanes));
            let deadline_ns = alone * rng.within(105, 160) / 100;
            let of = |nth: u64| Task {
                name: format!("t{nth}"),
                seed: 7 * seed + nth,
                period_ns,
                deadline_ns,
                ..task.clone()
            };
            Set { lanes, times, tasks: (0..count).map(of).collect() }
        });
        carried(&format!("one graph, {lanes} lanes, {times:?}"), sets, 250);
    }
}

/// The most valuable task, which fits alone but has no time to wait for somebody's long node, is on time beside three times as much.
#[test]
fn a_tight_task_of_value_does_not_wait_for_long_nodes() {
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        for (lanes, times) in kinds() {
            let (mut shares, mut least) = (Vec::new(), (100, String::new()));
            for (seed, load_percent) in (0..32).zip([110, 133, 150, 200].into_iter().cycle()) {
                let wish =
                    Wish { tasks: (2, 4), lanes, load_percent, times, values: &[1, 1, 3], floors: false };
                let mut set = Set::draw(seed, wish);
                set.tasks[0].value = 1_000;
                let alone = set.part(|task| task.value == 1_000, 0).expect("it has a deadline");
                if late(&alone, Policy::Edf).0 > 0 {
                    continue;
                }
                let (_, on_time, due) = set.on_time(policy, HORIZON_NS)[0].clone();
                shares.push(1_000 * on_time / due);
                least = least.min((100 * on_time / due, set.file()));
            }
            let mean = shares.iter().sum::<u64>() / shares.len() as u64;
            // Who needs several lanes at once finds one taken now and then.
            let must = if lanes == 1 { 95 } else { 80 };
            assert!(
                shares.len() >= 20 && mean >= 990 && least.0 >= must,
                "{policy:?}, {lanes} lanes, {times:?}: {mean} thousandths in the mean of {} sets, the least {} % in\n{}",
                shares.len(),
                least.0,
                least.1
            );
        }
    }
}

/// Tasks of another pool are on time as they were, however much is asked of this one.
#[test]
fn overload_of_one_pool_leaves_another_alone() {
    let mut fit = 0;
    for seed in 0..80 {
        let wish = Wish {
            tasks: (2, 4),
            lanes: 2,
            load_percent: 95,
            times: Times::Wcet,
            values: VALUES,
            floors: true,
        };
        let (own, other) =
            (Set::draw(seed, wish), Set::draw(seed + 1_000, Wish { load_percent: 200, ..wish }));
        let elsewhere = other
            .file()
            .replace("name = \"t", "name = \"other")
            .replace("name = \"cpu\"", "name = \"gpu\"")
            .replace("[[task.node]]\n", "[[task.node]]\npool = \"gpu\"\n");
        let ends = |file: &str| {
            let workload =
                parse(file.as_bytes(), Format::Toml, "apart.toml").unwrap_or_else(|e| panic!("{e}\n{file}"));
            let report =
                simulate(&workload, &red_tests::differential::options(oracle::Policy::Redrt, SECOND_NS))
                    .expect("it fits");
            let jobs = report.jobs.into_iter().take(own.tasks.len());
            jobs.map(|task| task.iter().map(|job| (job.at_ns, job.shed)).collect()).collect::<Vec<Vec<_>>>()
        };
        let alone = ends(&own.file());
        if alone.iter().flatten().any(|(_, shed)| shed.is_some()) {
            continue;
        }
        fit += 1;
        let both = format!("{}{elsewhere}", own.file());
        assert_eq!(alone, ends(&both), "seed {seed}:\n{both}");
    }
    assert!(fit >= 40, "{fit} sets fit");
}

/// Periodic tasks some of whose jobs, one after another, take other times than all others.
struct Slow {
    period_ms: u64,
    /// The first of them, and how many.
    from: u64,
    jobs: u64,
    /// Of each task: of these jobs and of any other one.
    times_ms: &'static [(u64, u64)],
}

impl World for Slow {
    fn release(&self, _task: usize, job: usize) -> Option<u64> {
        Some(1_000_000 * self.period_ms * job as u64)
    }

    fn time(&self, task: usize, job: u64, _node: &Numbered) -> (u64, bool) {
        let (slow, other) = self.times_ms[task];
        let is_slow = (self.from..self.from + self.jobs).contains(&job);
        (1_000_000 * if is_slow { slow } else { other }, true)
    }
}

impl Slow {
    /// Of each task the jobs that are not on time, by number. Tasks have one node: name, value, WCET and deadline in ms.
    fn late(&self, tasks: &[(&str, u32, u64, u64)]) -> Vec<Vec<usize>> {
        let tasks: Vec<_> =
            tasks.iter().map(|(name, value, wcet, deadline)| (*name, "", *value, *wcet, *deadline)).collect();
        self.late_of(&tasks)
    }

    /// The same of tasks that may have a floor, after their names.
    fn late_of(&self, tasks: &[(&str, &str, u32, u64, u64)]) -> Vec<Vec<usize>> {
        let mut file = "[[pool]]\nname = 'cpu'\nlanes = 1\n".to_owned();
        for (name, floor, value, wcet_ms, deadline_ms) in tasks {
            file += &format!(
                "[[task]]\nname = '{name}'\nvalue = {value}\n{floor}\nperiod = '{}ms'\ndeadline = '{deadline_ms}ms'\n\
                 [[task.node]]\nname = 'n'\nwcet = '{wcet_ms}ms'\n",
                self.period_ms
            );
        }
        let workload = parse(file.as_bytes(), Format::Toml, "slow.toml").expect("a workload");
        let options = Options {
            policy: Policy::Redrt,
            horizon_ns: 12 * SECOND_NS,
            seed: 1,
            execution: Execution::Wcet,
            preempt: false,
            schedule: false,
        };
        let report = simulate_in(self, &workload, options.policy.config(), &options).expect("it fits");
        let late = |jobs: &Vec<JobEnd>| {
            let is_late =
                |job: &JobEnd| job.shed.is_some() || job.at_ns.is_none_or(|at| at > job.deadline_ns);
            (0..jobs.len()).filter(|number| is_late(&jobs[*number])).collect()
        };
        report.jobs.iter().map(late).collect()
    }
}

/// Neither its WCET nor its first run would be in time; all others are.
#[test]
fn a_first_run_that_is_too_slow_costs_one_job() {
    let world = Slow { period_ms: 10, from: 0, jobs: 1, times_ms: &[(11, 3)] };
    assert_eq!(world.late(&[("camera", 1, 12, 10)]), [[0]]);
}

/// It waits for `brake` while it is believed to be slow. Now and then it gets a lane all the same, as `brake` has no floor.
#[test]
fn a_slow_first_run_beside_a_tight_task_passes() {
    let world = Slow { period_ms: 20, from: 0, jobs: 1, times_ms: &[(16, 16), (24, 3)] };
    let late = world.late(&[("brake", 1_000, 16, 20), ("map", 1, 24, 40)]);
    assert!(late[0].len() <= 10, "{late:?}");
    // The last two seconds; a job may be in flight at the end.
    assert!(late[1].iter().filter(|number| **number >= 500).count() <= 2, "{late:?}");
}

/// A task whose nodes take three times what it has: it takes the lane for a probe now and then, and others have the rest, whatever
/// its value and its WCET.
#[test]
fn a_task_that_always_outlasts_its_deadline_costs_others_only_its_probes() {
    let world = Slow { period_ms: 20, from: 0, jobs: 0, times_ms: &[(0, 30), (0, 10)] };
    for (value, wcet_ms) in [(1_000, 5), (1, 5), (1_000, 30), (1, 30)] {
        let late = world.late(&[("map", value, wcet_ms, 20), ("camera", 1, 10, 20)]);
        let late: Vec<usize> = late.iter().map(Vec::len).collect();
        // All of its own, and two for each probe.
        assert!(
            late[0] >= 600 && late[1] <= 75,
            "value {value}, WCET {wcet_ms} ms: late {late:?} of 600 each"
        );
    }
}

/// What was too slow for a while, and is not any more, is on time again, beside others and alone.
#[test]
fn a_task_that_was_too_slow_for_a_while_is_whole_again() {
    for first in [1, 4, 8, 12, 20, 40, 100] {
        let world = Slow { period_ms: 20, from: 0, jobs: first, times_ms: &[(30, 5), (10, 10)] };
        for (value, wcet_ms) in [(1_000, 5), (1, 5), (1_000, 30), (1, 30)] {
            let map = ("map", value, wcet_ms, 20);
            for tasks in [&[map, ("camera", 1, 10, 20)], &[map][..]] {
                let late = world.late(tasks);
                // The last two seconds of twelve.
                let is_whole = late.iter().flatten().all(|number| *number < 500);
                assert!(is_whole, "{first} slow, value {value}, WCET {wcet_ms} ms: late {late:?}");
            }
        }
    }
}

/// One slow run, the first one, costs no more than the jobs that it delays, beside who goes first and must lose nothing.
#[test]
fn a_slow_first_run_costs_only_what_it_delays() {
    let world = Slow { period_ms: 20, from: 0, jobs: 1, times_ms: &[(30, 3), (8, 8)] };
    let late = world.late(&[("net", 1, 4, 20), ("other", 1_000, 8, 20)]);
    assert!(late.iter().all(|late| late.len() <= 2), "{late:?}");
}

/// Nor is a slow run later on the end of a task, whoever goes first: one costs what it delays. After two in a row it takes longer, with a
/// floor of every job of whoever goes first the longest; that one loses next to nothing.
#[test]
fn one_slow_run_is_not_the_end_of_a_task() {
    let every = "floor = [1, 1]";
    for (floor, jobs, whole_after) in [("", 1, 106), (every, 1, 106), ("", 2, 150), (every, 2, 420)] {
        let world = Slow { period_ms: 20, from: 100, jobs, times_ms: &[(16, 16), (24, 3)] };
        let late = world.late_of(&[("brake", floor, 1_000, 16, 20), ("map", "", 1, 4, 40)]);
        assert!(late[0].len() as u64 <= 3 * jobs, "{floor}: {late:?}");
        assert!(late[1].iter().all(|number| *number < whole_after), "{floor}, {jobs} slow: {late:?}");
    }
}

/// A task that is alone on its lane, and has most of it, loses what a slow run delays, however slow that is.
#[test]
fn a_slow_run_of_a_task_alone_costs_what_it_delays() {
    const TIMES_MS: [&[(u64, u64)]; 3] = [&[(11, 8)], &[(14, 8)], &[(25, 8)]];
    for (times_ms, jobs) in TIMES_MS.into_iter().flat_map(|times_ms| [(times_ms, 1), (times_ms, 3)]) {
        let world = Slow { period_ms: 10, from: 50, jobs, times_ms };
        let late = world.late(&[("net", 1, 9, 10)]);
        assert!(late[0].len() as u64 <= jobs * (times_ms[0].0 / 10 + 3), "{jobs}, {times_ms:?}: {late:?}");
    }
}

/// Nor does one make a task lose jobs to what is worth less.
#[test]
fn a_slow_run_beside_lower_values_costs_what_it_delays() {
    let low: [(&str, u32, u64, u64); 4] = ["a", "b", "c", "d"].map(|name| (name, 1, 6, 60));
    for jobs in [1, 3] {
        let world =
            Slow { period_ms: 20, from: 50, jobs, times_ms: &[(11, 3), (6, 6), (6, 6), (6, 6), (6, 6)] };
        let late = world.late(&[&[("net", 1_000, 4, 10)][..], &low].concat());
        assert!(late[0].len() as u64 <= 3 * jobs, "{jobs}: {late:?}");
    }
}

/// Nor a WCET that is half of what nodes take: lanes are kept for as long as these take.
#[test]
fn a_wcet_that_is_too_short_costs_a_higher_value_little() {
    let world = Slow { period_ms: 20, from: 0, jobs: 0, times_ms: &[(0, 12), (0, 19)] };
    for floor in ["", "floor = [1, 1]"] {
        let late = world.late_of(&[("control", floor, 1_000, 6, 20), ("map", "", 10, 20, 40)]);
        assert!(late[0].len() <= 12, "{floor}: {late:?}");
    }
}

/// A task that always takes more than it is declared to take has the lane of one that must lose no job once in a long while.
#[test]
fn who_must_lose_no_job_loses_few_to_a_wcet_that_is_too_short() {
    let world = Slow { period_ms: 20, from: 0, jobs: 0, times_ms: &[(0, 16), (0, 24)] };
    let late = world.late_of(&[("brake", "floor = [1, 1]", 1_000, 16, 20), ("map", "", 1, 4, 40)]);
    // What a node takes is not known before one has run to its end.
    let later = late[0].iter().filter(|number| **number >= 20).count();
    assert!(late[0].len() <= 16 && later <= 5, "{late:?}");
}
