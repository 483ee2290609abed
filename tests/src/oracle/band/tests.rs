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

/// Job j of low would run from 21 * j + 21 on, for j up to 3. It is late in the looks at 20 * j and 20 * j + 20, and then hopeless.
fn firsts(cost_ms: u64, deadline_ms: u64) -> Vec<Task> {
    let first = |nth: u64| single(&format!("first-{nth}"), 9, 21 * nth, cost_ms, deadline_ms);
    (0..4).map(first).collect()
}

fn after_firsts(more: Vec<Task>) -> Vec<Task> {
    [firsts(21, 30), more].concat()
}

/// What starts in 20 ms from `from_ms` on.
fn starts(tasks: Vec<Task>, policy: Policy, from_ms: u64) -> Vec<String> {
    let mut outcome = simulate(&workload(1, tasks), policy, 300 * MS);
    outcome.rows.retain(|row| (from_ms..from_ms + 20).contains(&(row.start_ns / MS)));
    lines(&outcome)
}

#[test]
fn a_lower_job_waits_under_pressure_although_its_key_is_first() {
    // At 100 the keys are 120 and 125. Nobody is late by them, but somebody was at 80, until 200 there is pressure, and
    // low has lost four jobs.
    let tasks = |firsts: Vec<Task>| [firsts, vec![low(1), single("second", 2, 100, 15, 40)]].concat();
    for policy in [Policy::Redrt, Policy::RedrtLookahead] {
        let lines = |cost_of_first_ms| starts(tasks(firsts(cost_of_first_ms, 30)), policy, 100);
        assert_eq!(lines(21), ["second/0/n 0 100..115", "low/5/n 0 115..125"]);
        assert_eq!(lines(5), ["low/5/n 0 100..110", "second/0/n 0 110..125"]);
        // Where only three were lost there are no bands.
        let three = tasks(firsts(21, 30).into_iter().take(3).collect());
        assert_eq!(starts(three, policy, 100), ["low/5/n 0 100..110", "second/0/n 0 110..125"]);
    }
    // The others know no pressure. By their deadlines jobs of low run late, and job 5 is before second.
    assert_eq!(starts(tasks(firsts(21, 30)), Policy::Edf, 124), ["low/4/n 0 124..134", "low/5/n 0 134..144"]);
}

#[test]
fn lanes_wait_for_nothing_that_is_below_the_head() {
    // At 100 the head is second, of the highest band and with the key 125. The next urgent one has the key 107.
    let urgent = |value: u32| Task { value, ..at(every(once("urgent", 4, vec![node("n", 2, &[])]), 45), 60) };
    let of = |value: u32, policy: Policy| {
        let tasks = after_firsts(vec![low(1), single("second", 2, 100, 15, 40), urgent(value)]);
        starts(tasks, policy, 100)[0].clone()
    };
    for value in [1, 2] {
        assert_eq!(of(value, Policy::Redrt), "second/0/n 0 100..115");
    }
    assert_eq!(of(1, Policy::RedrtLookahead), "second/0/n 0 100..115");
    assert_eq!(of(2, Policy::RedrtLookahead), "urgent/1/n 0 105..107");
}

#[test]
fn a_value_has_to_be_above_the_level() {
    let later_key = |value: u32| single("second", value, 100, 15, 40);
    let first_key = |value: u32| single("second", value, 100, 10, 29);
    let of = |low_value: u32, second: Task| {
        starts(after_firsts(vec![low(low_value), second]), Policy::Redrt, 100)[0].clone()
    };
    assert_eq!(of(1, later_key(2)), "second/0/n 0 100..115");
    // Two of one band go by their keys, 120 and 125 or 119.
    assert_eq!(of(2, later_key(2)), "low/5/n 0 100..110");
    assert_eq!(of(2, first_key(2)), "second/0/n 0 100..110");
    // Up to the level they are ordered by value.
    assert_eq!(of(3, first_key(2)), "low/5/n 0 100..110");
    // A floor that cannot spare it makes a job one of the highest.
    let floored = |task: Task| Task { floor: Some((1, 1)), ..task };
    assert_eq!(of(3, floored(later_key(2))), "second/0/n 0 100..115");
    assert_eq!(of(3, later_key(2)), "low/5/n 0 100..110");
}

#[test]
fn the_level_is_of_tasks_with_a_job_in_flight() {
    // From 84 to 94 job 4 of low runs, and job 5 comes at 100. Only where a job of low, which has lost four, is there too bands differ.
    let of = |at_ms: u64| {
        let tasks = vec![low(1), single("third", 1, at_ms, 10, 30), single("second", 2, at_ms, 15, 40)];
        starts(after_firsts(tasks), Policy::Redrt, at_ms)[0].clone()
    };
    assert_eq!(of(95), "third/0/n 0 95..105");
    assert_eq!(of(100), "second/0/n 0 100..115");
}

#[test]
fn pressure_ends() {
    // The look at 80 is the last that finds somebody late: until 80 + 4 * 30 or 80 + 4 * 31, that instant excluded.
    let of = |cost_ms: u64| {
        let tasks = vec![low(1), single("third", 2, 200, 15, 40)];
        starts([firsts(cost_ms, cost_ms + 9), tasks].concat(), Policy::Redrt, 200)[0].clone()
    };
    assert_eq!(of(21), "low/10/n 0 200..210");
    assert_eq!(of(22), "third/0/n 0 200..215");
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
    // By bands low/5 would run from 121 to 131 and be late. By keys it ends at 110, and second at 131.
    let workload = workload(1, after_firsts(vec![low(1), single("second", 2, 100, 21, 45)]));
    let pressure = |until_ms: u64| stepped(&workload, until_ms).pressure_until[0] / i128::from(MS);
    assert_eq!([0, 20, 100].map(pressure), [120, 140, 200]);
    // From 120 on it is late by keys, too.
    assert_eq!(pressure(120), 300);
    let sim = stepped(&workload, 100);
    assert_eq!(sim.jobs.iter().map(|job| job.task).collect::<Vec<_>>(), [4, 5]);
    let late: Vec<bool> = sim.forward(&[0, 1], 100 * MS).iter().map(|fate| sim.is_late(fate)).collect();
    assert_eq!(late, [true, false]);
}

#[test]
fn bands_are_of_the_last_look() {
    let workload = workload(1, after_firsts(vec![low(1), single("second", 2, 100, 15, 40)]));
    let bands = |until_ms: u64| {
        let sim = stepped(&workload, until_ms);
        sim.jobs.iter().map(|job| (job.task, job.band.0)).collect::<Vec<_>>()
    };
    // Nobody has lost anything yet, but one is late and stays.
    assert_eq!(bands(0), [(0, Band::Highest), (4, Band::Last)]);
    assert_eq!(bands(100), [(4, Band::Ranked(true, false, 1, 0)), (5, Band::Highest)]);
    // Nothing is left of the pressure at 200.
    assert_eq!(bands(200), [(4, Band::Lowest)]);
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
    let owed = |sim: &Sim<'_>| sim.jobs.iter().map(|job| sim.is_owed(job, &[])).collect::<Vec<_>>();
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
