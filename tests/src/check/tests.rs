use super::*;
use crate::fixtures::{MS, at, every, node, once, sensed, stage, workload};
use crate::oracle::{Reason, simulate};
use crate::rng::{Rng, Shape, random_workload};

const HORIZON: u64 = 200 * MS;

/// Two tasks that share a frame through the cache, on one lane, beside a chain.
fn shared() -> Workload {
    let see = || vec![stage("see", 10, &[("dec", 4)], &[])];
    let chain = vec![node("a", 1, &[]), node("b", 1, &["a"])];
    let tasks =
        vec![every(once("p", 90, see()), 100), at(every(once("q", 90, see()), 100), 5), once("r", 80, chain)];
    sensed(workload(1, tasks), 50)
}

/// What the judge says of the schedule of `shared` after `change`.
fn after(policy: Policy, change: impl FnOnce(&mut Vec<Row>, &mut Vec<ShedRow>)) -> Result<(), String> {
    let workload = shared();
    let outcome = simulate(&workload, policy, HORIZON);
    let (mut rows, mut sheds) = (outcome.rows, outcome.sheds);
    change(&mut rows, &mut sheds);
    rows.sort();
    sheds.sort();
    validate(&workload, policy, HORIZON, &rows, &sheds)
}

fn complaint(policy: Policy, change: impl FnOnce(&mut Vec<Row>, &mut Vec<ShedRow>)) -> String {
    after(policy, change).expect_err("the schedule is broken")
}

fn row<'a>(rows: &'a mut [Row], task: &str, name: &str) -> &'a mut Row {
    rows.iter_mut().find(|row| row.task == task && row.job == 0 && row.node == name).expect("such a row")
}

#[test]
fn an_honest_schedule_passes() {
    for policy in Policy::ALL {
        assert_eq!(after(policy, |_, _| ()), Ok(()));
    }
}

#[test]
fn a_wrong_time_is_seen() {
    let message = complaint(Policy::Redrt, |rows, _| row(rows, "p", "see.encoder").finish_ns += 1);
    assert!(message.contains("not 10000000"), "{message}");
}

#[test]
fn a_start_before_its_predecessor_ended_is_seen() {
    let message = complaint(Policy::RedFg, |rows, _| {
        let row = row(rows, "r", "b");
        (row.start_ns, row.finish_ns) = (0, MS);
    });
    assert!(message.contains("overlap") || message.contains("is ready at"), "{message}");
}

#[test]
fn a_lane_that_idles_is_seen() {
    let message = complaint(Policy::RedFg, |rows, _| {
        for row in rows {
            (row.start_ns, row.finish_ns) = (row.start_ns + MS, row.finish_ns + MS);
        }
    });
    assert!(message.contains("idles"), "{message}");
}

#[test]
fn a_missing_row_is_seen() {
    let message = complaint(Policy::Edf, |rows, _| rows.retain(|row| row.node != "b"));
    assert!(message.contains("idles") || message.contains("key is smaller"), "{message}");
}

#[test]
fn a_row_of_nothing_is_seen() {
    let message = complaint(Policy::Edf, |rows, _| row(rows, "r", "b").node = "c".to_owned());
    assert!(message.contains("no such node"), "{message}");
    let message = complaint(Policy::Edf, |rows, _| row(rows, "r", "b").job = 7);
    assert!(message.contains("not released"), "{message}");
    let message = complaint(Policy::Edf, |rows, _| row(rows, "r", "b").lane = Some(1));
    assert!(message.contains("no such lane"), "{message}");
}

#[test]
fn a_hit_without_a_result_is_seen() {
    let message = complaint(Policy::Redrt, |rows, _| {
        let row = row(rows, "q", "see.encoder");
        (row.start_ns, row.finish_ns) = (6 * MS, 6 * MS);
    });
    assert!(message.contains("hits at"), "{message}");
    let message = complaint(Policy::Redrt, |rows, _| row(rows, "r", "a").lane = None);
    assert!(message.contains("no lane"), "{message}");
}

#[test]
fn a_run_that_a_hit_could_replace_is_seen() {
    let mut workload = shared();
    workload.tasks.pop();
    let outcome = simulate(&workload, Policy::RedFg, HORIZON);
    let message = validate(&workload, Policy::Redrt, HORIZON, &outcome.rows, &outcome.sheds);
    let message = message.expect_err("under REDRT it would hit");
    assert!(message.contains("has its result"), "{message}");
}

#[test]
fn an_illegal_shed_is_seen() {
    let shed = |reason: Reason, at_ns: u64| {
        move |rows: &mut Vec<Row>, sheds: &mut Vec<ShedRow>| {
            rows.retain(|row| row.task != "r");
            sheds.push(ShedRow { at_ns, task: "r".to_owned(), job: 0, reason });
        }
    };
    assert!(complaint(Policy::Redrt, shed(Reason::Hopeless, 0)).contains("could end"));
    assert!(complaint(Policy::Redrt, shed(Reason::Urgency, 0)).contains("not a reason"));
    assert!(complaint(Policy::Edf, shed(Reason::Full, 0)).contains("refused"));
    assert!(complaint(Policy::Redrt, shed(Reason::Full, 0)).contains("1 were refused"));
    assert!(complaint(Policy::Redrt, shed(Reason::Full, MS)).contains("nobody is released"));
    assert!(complaint(Policy::Redrt, shed(Reason::Overload, MS)).contains("no job came"));
    let message = complaint(Policy::Red, shed(Reason::Urgency, MS));
    assert!(message.contains("not at a tick"), "{message}");
}

#[test]
fn a_shed_for_nobody_is_seen() {
    let alone = workload(1, vec![once("t", 10, vec![node("n", 20, &[])])]);
    let shed = ShedRow { at_ns: 0, task: "t".to_owned(), job: 0, reason: Reason::Overload };
    let message = validate(&alone, Policy::Redrt, HORIZON, &[], &[shed]).expect_err("nobody else is there");
    assert!(message.contains("for nobody"), "{message}");
    // The next one comes when this one would have ended long since.
    let again = workload(1, vec![every(once("t", 30, vec![node("n", 20, &[])]), 300)]);
    let shed = ShedRow { at_ns: 0, task: "t".to_owned(), job: 0, reason: Reason::Overload };
    let message =
        validate(&again, Policy::Redrt, HORIZON, &[], &[shed]).expect_err("the next one is in time");
    assert!(message.contains("for nobody"), "{message}");
    // It would end at 20 ms, when the one of 10 ms has no time left.
    let tight = workload(1, vec![every(once("t", 20, vec![node("n", 20, &[])]), 10)]);
    let shed = ShedRow { at_ns: 0, task: "t".to_owned(), job: 0, reason: Reason::Overload };
    let message = validate(&tight, Policy::Redrt, 5 * MS, &[], &[shed]);
    assert!(message.as_ref().err().is_none_or(|message| !message.contains("for nobody")), "{message:?}");
}

#[test]
fn a_shed_after_its_start_in_one_instant_is_seen() {
    let message = complaint(Policy::Redrt, |rows, sheds| {
        rows.retain(|row| row.task != "r" || row.node == "a");
        let at_ns = row(rows, "r", "a").start_ns;
        sheds.push(ShedRow { at_ns, task: "r".to_owned(), job: 0, reason: Reason::Overload });
    });
    assert!(message.contains("starts at that instant"), "{message}");
}

#[test]
fn a_broken_floor_is_seen() {
    let mut floored = workload(1, vec![every(once("t", 1000, vec![node("n", 1, &[])]), 5)]);
    floored.tasks[0].floor = Some((1, 2));
    let shed = |job: u64| ShedRow { at_ns: job * 5 * MS, task: "t".to_owned(), job, reason: Reason::Urgency };
    let judge = |sheds: &[ShedRow]| validate(&floored, Policy::Red, 5 * sheds.len() as u64 * MS, &[], sheds);
    assert_eq!(judge(&[shed(0)]), Ok(()));
    let message = judge(&[shed(0), shed(1)]).expect_err("two in a row");
    assert!(message.contains("floor is broken"), "{message}");
}

/// Swapping or moving rows of random schedules is noticed nearly always; what is not may be a valid schedule.
#[test]
fn random_damage_is_seen() {
    let shape = Shape { memory: false, sync: false, ..Shape::default() };
    let (mut damaged, mut seen) = (0, 0);
    for seed in 0..300 {
        let workload = random_workload(seed, &shape);
        let rng = &mut Rng::new(seed);
        for policy in Policy::ALL {
            let outcome = simulate(&workload, policy, HORIZON / 2);
            let mut rows = outcome.rows;
            if rows.is_empty() {
                continue;
            }
            let at = rng.index(rows.len());
            match rng.index(3) {
                0 => drop(rows.remove(at)),
                1 => rows[at].start_ns += 1,
                _ => {
                    let later = rng.within(1, 1_000_000);
                    (rows[at].start_ns, rows[at].finish_ns) =
                        (rows[at].start_ns + later, rows[at].finish_ns + later);
                }
            }
            rows.sort();
            damaged += 1;
            seen += i32::from(validate(&workload, policy, HORIZON / 2, &rows, &outcome.sheds).is_err());
        }
    }
    assert!(seen * 100 >= damaged * 97, "{seen} of {damaged}");
}
