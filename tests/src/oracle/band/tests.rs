use super::*;
use crate::fixtures::{MS, at, every, lines, node, once, workload};
use crate::oracle::{Policy, Reason, simulate};
use red_workload::model::{Task, Workload};

/// A task of one node, released once.
fn single(name: &str, value: u32, at_ms: u64, cost_ms: u64, deadline_ms: u64) -> Task {
    Task { value, ..at(once(name, deadline_ms, vec![node("n", cost_ms, &[])]), at_ms) }
}

/// 10 ms every 20 ms, to be done within 30: job j has the key 20 * j + 20.
fn low(value: u32) -> Task {
    Task { value, ..every(once("low", 30, vec![node("n", 10, &[])]), 20) }
}

/// Job 0 of low would run from 25 to 35. It is late in the looks at 0 and 20, and hopeless at 25.
fn first(deadline_ms: u64) -> Task {
    single("first", 9, 0, 25, deadline_ms)
}

/// What starts in 20 ms from `from_ms` on.
fn starts(tasks: Vec<Task>, policy: Policy, from_ms: u64) -> Vec<String> {
    let mut outcome = simulate(&workload(1, tasks), policy, 200 * MS);
    outcome.rows.retain(|row| (from_ms..from_ms + 20).contains(&(row.start_ns / MS)));
    lines(&outcome)
}

#[test]
fn a_lower_job_waits_under_pressure_although_its_key_is_first() {
    // At 40 the keys are 60 and 65. Nobody is late by them, but somebody was at 20, until 140 there is pressure, and
    // low has lost a job.
    let tasks = |cost_of_first_ms: u64| {
        let first = single("first", 9, 0, cost_of_first_ms, 30);
        vec![first, low(1), single("second", 2, 40, 15, 40)]
    };
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        assert_eq!(starts(tasks(25), policy, 40), ["second/0/n 0 40..55", "low/2/n 0 55..65"]);
        assert_eq!(starts(tasks(15), policy, 40), ["low/2/n 0 40..50", "second/0/n 0 50..65"]);
    }
    // The others know no pressure. By their deadlines, job 0 of low runs late, and job 2 is before second.
    assert_eq!(starts(tasks(25), Policy::Edf, 40), ["low/2/n 0 45..55", "second/0/n 0 55..70"]);
}

#[test]
fn lanes_wait_for_nothing_that_is_below_the_head() {
    // At 40 the head is second, of the highest band and with the key 65. The next urgent one has the key 47.
    let urgent = |value: u32| Task { value, ..every(once("urgent", 4, vec![node("n", 2, &[])]), 45) };
    let of = |value: u32, policy: Policy| {
        starts(vec![first(30), low(1), single("second", 2, 40, 15, 40), urgent(value)], policy, 40)[0].clone()
    };
    for value in [1, 2] {
        assert_eq!(of(value, Policy::Redrt), "second/0/n 0 40..55");
    }
    assert_eq!(of(1, Policy::RedrtLookahead), "second/0/n 0 40..55");
    assert_eq!(of(2, Policy::RedrtLookahead), "urgent/1/n 0 45..47");
}

#[test]
fn a_value_has_to_be_above_the_level() {
    let later_key = |value: u32| single("second", value, 40, 15, 40);
    let first_key = |value: u32| single("second", value, 40, 10, 29);
    let of = |low_value: u32, second: Task| {
        starts(vec![first(30), low(low_value), second], Policy::Redrt, 40)[0].clone()
    };
    assert_eq!(of(1, later_key(2)), "second/0/n 0 40..55");
    // Two of one band go by their keys, 60 and 65 or 59.
    assert_eq!(of(2, later_key(2)), "low/2/n 0 40..50");
    assert_eq!(of(2, first_key(2)), "second/0/n 0 40..50");
    // Up to the level they are ordered by value.
    assert_eq!(of(3, first_key(2)), "low/2/n 0 40..50");
    // A floor that cannot spare it makes a job one of the highest.
    let floored = |task: Task| Task { floor: Some((1, 1)), ..task };
    assert_eq!(of(3, floored(later_key(2))), "second/0/n 0 40..55");
    assert_eq!(of(3, later_key(2)), "low/2/n 0 40..50");
}

#[test]
fn the_level_is_of_tasks_with_a_job_in_flight() {
    // At 40 the keys are 60 and 65. Only where a job of low, which has lost one, is there too they get bands.
    let of = |low: Task| {
        let tasks = vec![first(30), low, single("third", 1, 40, 10, 30), single("second", 2, 40, 15, 40)];
        starts(tasks, Policy::Redrt, 40)[0].clone()
    };
    assert_eq!(of(single("low", 1, 0, 10, 30)), "third/0/n 0 40..50");
    assert_eq!(of(low(1)), "second/0/n 0 40..55");
}

#[test]
fn pressure_ends() {
    // The look at 20 is the last that finds somebody late: until 20 + 4 * 30 or 20 + 4 * 31, that instant excluded.
    let of = |deadline_ms: u64| {
        let tasks = vec![first(deadline_ms), low(1), single("third", 2, 140, 15, 40)];
        starts(tasks, Policy::Redrt, 140)[0].clone()
    };
    assert_eq!(of(30), "low/7/n 0 140..150");
    assert_eq!(of(31), "third/0/n 0 140..155");
}

fn stepped(workload: &Workload, until_ms: u64) -> Sim<'_> {
    let mut sim = Sim::new(workload, Policy::Redrt, u64::MAX);
    while let Some(next) = sim.next_instant().filter(|&next| next <= until_ms * MS) {
        sim.step(next);
    }
    sim
}

#[test]
fn pressure_is_of_a_schedule_with_all_in_one_band() {
    // By bands low/2 would run from 61 to 71 and be late. By keys it ends at 50, and second at 71.
    let workload = workload(1, vec![first(30), low(1), single("second", 2, 40, 21, 45)]);
    let pressure = |until_ms: u64| stepped(&workload, until_ms).pressure_until[0] / i128::from(MS);
    assert_eq!([0, 20, 40].map(pressure), [120, 140, 140]);
    // From 60 on it is late by keys, too.
    assert_eq!(pressure(60), 240);
    let sim = stepped(&workload, 40);
    assert_eq!(sim.jobs.iter().map(|job| job.task).collect::<Vec<_>>(), [1, 2]);
    let late: Vec<bool> = sim.forward(&[0, 1], 40 * MS).iter().map(|fate| sim.is_late(fate)).collect();
    assert_eq!(late, [true, false]);
}

#[test]
fn bands_are_of_the_last_look() {
    let workload = workload(1, vec![first(30), low(1), single("second", 2, 40, 15, 40)]);
    let bands = |until_ms: u64| {
        let sim = stepped(&workload, until_ms);
        sim.jobs.iter().map(|job| (job.task, job.band.0)).collect::<Vec<_>>()
    };
    // Nobody has lost anything yet, but one is late and stays.
    assert_eq!(bands(0), [(0, Band::Highest), (1, Band::Last)]);
    assert_eq!(bands(40), [(1, Band::Ranked(true, false, 1, 0)), (2, Band::Highest)]);
    // Nothing is left of the pressure at 140.
    assert_eq!(bands(140), [(1, Band::Lowest)]);
}

#[test]
fn what_has_started_is_owed_with_another_of_its_task() {
    let floored = Task {
        floor: Some((1, 2)),
        ..every(once("floored", 90, vec![node("a", 15, &[]), node("b", 15, &["a"])]), 10)
    };
    let workload = workload(1, vec![floored]);
    let mut sim = stepped(&workload, 20);
    assert!(sim.jobs[0].started);
    let owed = |sim: &Sim<'_>| sim.jobs.iter().map(|job| sim.is_owed(job)).collect::<Vec<_>>();
    assert_eq!(owed(&sim), [false, false, false]);
    // Of jobs 1 and 2 one has to stay.
    sim.give_up(0, 2, 20 * MS, Reason::Overload);
    assert!(!sim.floor_needs(&sim.jobs[0], &[]));
    assert_eq!(owed(&sim), [true, true]);
}

#[test]
fn jobs_of_one_task_are_of_one_band() {
    let workload = workload(1, vec![every(once("only", 30, vec![node("n", 20, &[])]), 10)]);
    let sim = stepped(&workload, 50);
    assert!(sim.pressure_until[0] > 50 * i128::from(MS) && sim.jobs.len() > 1);
    assert!(sim.jobs.iter().all(|job| job.band.0 == Band::Highest));
}

#[test]
fn a_long_node_waits_for_the_next_job_of_a_higher_rank() {
    let every_20 = |name: &str, value: u32, cost_ms: u64, deadline_ms: u64| Task {
        value,
        ..every(once(name, deadline_ms, vec![node("n", cost_ms, &[])]), 20)
    };
    let of = |value: u32, floor: Option<(u32, u32)>, policy: Policy| {
        let tight = Task { floor, ..every_20("tight", value, 16, 20) };
        lines(&simulate(&workload(1, vec![tight, every_20("long", 1, 24, 200)]), policy, 100 * MS))
    };
    let whole = [
        "tight/0/n 0 0..16",
        "tight/1/n 0 20..36",
        "tight/2/n 0 40..56",
        "tight/3/n 0 60..76",
        "tight/4/n 0 80..96",
    ];
    assert_eq!(of(2, None, Policy::Redrt), whole);
    // Not for its equal.
    let equal = ["tight/0/n 0 0..16", "long/0/n 0 16..40", "tight/2/n 0 40..56", "long/1/n 0 56..80"];
    assert_eq!(of(1, None, Policy::Redrt)[..4], equal);
    // For what a floor cannot spare whatever the values.
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        assert_eq!(of(1, Some((1, 1)), policy), whole);
    }
}
