use super::*;
use crate::fixtures::{MS, node, once, stage, workload};
use crate::oracle::{Policy, Reason};
use red_workload::model::{Node, Task, Workload};

fn task(nodes: Vec<Node>) -> Task {
    once("t", 100, nodes)
}

fn one_node() -> Vec<Node> {
    vec![node("n", 10, &[])]
}

/// With so many jobs behind it, of which these are lost, in one way or another.
fn after(workload: &Workload, ended: u64, lost: impl Fn(u64) -> bool) -> Sim<'_> {
    let mut sim = Sim::new(workload, Policy::Redrt, u64::MAX);
    for index in 0..ended {
        let job = sim.new_job(0, index, 0);
        sim.outcome.release(&job);
        match (lost(index), index % 3) {
            (false, _) => sim.outcome.end(&job, 100 * MS),
            (true, 0) => sim.outcome.end(&job, 100 * MS + 1),
            (true, 1) => sim.outcome.shed(&job, 0, Reason::Full),
            (true, _) => sim.outcome.shed(&job, 0, Reason::Hopeless),
        }
    }
    sim
}

#[test]
fn a_bound_is_the_longest_path_or_the_work_over_the_lanes() {
    let bound = |lanes: u32, nodes: Vec<Node>| {
        let workload = workload(lanes, vec![task(nodes)]);
        let sim = Sim::new(&workload, Policy::Redrt, u64::MAX);
        sim.bound(&sim.new_job(0, 0, 0), 3 * MS) - i128::from(3 * MS)
    };
    let wide = || vec![node("a", 10, &[]), node("b", 10, &[]), node("c", 10, &[])];
    let ms = |ms: u64| i128::from(ms * MS);
    assert_eq!([1, 2, 3, 4].map(|lanes| bound(lanes, wide())), [ms(30), ms(15), ms(10), ms(10)]);
    let chain = vec![node("a", 10, &[]), node("b", 10, &["a"]), node("c", 1, &[])];
    assert_eq!(bound(2, chain), ms(20));
    let odd = vec![node("a", 1, &[]), node("b", 1, &[]), node("c", 1, &[])];
    assert_eq!(bound(2, odd), ms(3) / 2);
}

#[test]
fn a_bound_counts_what_is_left() {
    let workload = workload(1, vec![task(vec![stage("see", 10, &[("dec", 4)], &[])])]);
    let mut sim = Sim::new(&workload, Policy::Redrt, u64::MAX);
    let mut left = |now_ms: u64| {
        sim.step(now_ms * MS);
        (sim.bound(&sim.jobs[0], now_ms * MS) - i128::from(now_ms * MS)) / i128::from(MS)
    };
    assert_eq!(left(0), 14);
    assert_eq!(left(3), 11);
    assert_eq!(left(10), 4);
    assert_eq!(left(12), 2);
}

#[test]
fn a_floor_counts_every_lost_job() {
    let floored = |floor| workload(1, vec![Task { floor: Some(floor), ..task(one_node()) }]);
    let needs = |workload: &Workload, ended: u64, lost: &[u64], index: u64| {
        let sim = after(workload, ended, |job| lost.contains(&job));
        sim.floor_needs(&sim.new_job(0, index, 0), &[])
    };
    let one_of_two = floored((1, 2));
    for lost in [3, 4, 5] {
        assert!(needs(&one_of_two, lost + 1, &[lost], lost + 1));
        assert!(!needs(&one_of_two, lost + 1, &[lost - 1], lost + 1));
        // One before a lost job is in a window with it too.
        assert!(needs(&one_of_two, lost + 1, &[lost], lost - 1));
    }
    assert!(needs(&floored((2, 2)), 0, &[], 0));
    assert!(!needs(&floored((0, 2)), 9, &[7, 8], 9));
    assert!(!needs(&workload(1, vec![task(one_node())]), 9, &[7, 8], 9));
}

#[test]
fn floors_remember_so_many_jobs() {
    let floored = |floor| workload(1, vec![Task { floor: Some(floor), ..task(one_node()) }]);
    let needs = |workload: &Workload, ended: u64, lost: u64, index: u64| {
        let sim = after(workload, ended, |job| job >= ended - lost);
        sim.floor_needs(&sim.new_job(0, index, 0), &[])
    };
    // A window of 128 jobs may lose 101 / 2.
    let wide = floored((99, 200));
    assert!(!needs(&wide, 127, 49, 127));
    assert!(needs(&wide, 127, 50, 127));
    // With the window of job 126 behind job 127 one is forgotten.
    assert!(needs(&wide, 128, 0, 126));
    let narrow = floored((0, 2));
    assert!(!needs(&narrow, 201, 0, 74));
    assert!(needs(&narrow, 201, 0, 73));
}

#[test]
fn a_probe_ranks_higher_where_its_task_only_loses() {
    let late = workload(1, vec![Task { value: 7, ..task(vec![node("n", 101, &[])]) }]);
    let punctual = workload(1, vec![Task { value: 7, ..task(one_node()) }]);
    let rank = |workload: &Workload, ended: u64, lost: fn(u64) -> bool, index: u64| {
        let sim = after(workload, ended, lost);
        sim.rank(&sim.new_job(0, index, 0), &[], 0)
    };
    // A job is a probe if its index and what it has to spare, in nanoseconds, add up to a multiple of 17: 9 and -1,000,000, or 6 and
    // 90,000,000. What is lost for certain is none.
    assert_eq!(rank(&late, 0, |_| true, 9), (false, false, 7, 0));
    assert_eq!(rank(&late, 17, |_| true, 26), (false, false, 7, 0));
    assert_eq!(rank(&late, 0, |_| true, 1), (false, false, 7, 0));
    assert_eq!(rank(&punctual, 0, |_| true, 1), (true, false, 7, 0));
    assert_eq!(rank(&punctual, 17, |_| true, 23), (true, false, 7, 17));
    assert_eq!(rank(&punctual, 17, |job| job != 0, 23), (true, false, 7, 0));
    assert_eq!(rank(&punctual, 18, |job| job != 0, 40), (true, false, 7, 17));
    assert_eq!(rank(&punctual, 17, |_| true, 18), (true, false, 7, 0));
    // What is before the first job is not lost.
    assert_eq!(rank(&punctual, 16, |_| true, 17), (true, false, 7, 0));
}

#[test]
fn among_equals_the_one_with_most_work_and_fewest_losses_goes() {
    let workload = workload(1, vec![task(one_node())]);
    let weight = |ended: u64, lost: fn(u64) -> bool| {
        let sim = after(&workload, ended, lost);
        let Reverse(weight) = sim.standing(&sim.new_job(0, ended, 0), &[], 0).2;
        weight / u128::from(10 * MS)
    };
    assert_eq!(weight(0, |_| true), 32);
    assert_eq!(weight(40, |job| job % 4 == 0), 28);
    assert_eq!(weight(40, |job| job < 24), 32);
    assert_eq!(weight(40, |_| true), 16);

    let sim = after(&workload, 0, |_| false);
    let standing = |index: u64, release: u64, started: bool| {
        let job = Job { started, ..sim.new_job(0, index, release) };
        sim.standing(&job, &[], release)
    };
    assert!(standing(5, 0, false) < standing(4, 0, true));
    assert!(standing(4, 1, false) < standing(4, 0, false));
    assert!(standing(5, 0, false) < standing(4, 0, false));
}

#[test]
fn who_left_counts_as_ended_and_lost() {
    let floored = workload(1, vec![Task { floor: Some((1, 2)), ..task(one_node()) }]);
    let sim = after(&floored, 4, |_| false);
    let needs = |gone: &[Name]| [4, 6, 7].map(|index| sim.floor_needs(&sim.new_job(0, index, 0), gone));
    assert_eq!((needs(&[]), needs(&[(0, 5)])), ([false; 3], [true, true, false]));

    let free = workload(1, vec![task(one_node())]);
    let last = |ended: u64, gone: &[Name]| {
        let sim = after(&free, ended, |job| job != 0);
        let job = sim.new_job(0, 40, 0);
        let Reverse(weight) = sim.standing(&job, gone, 0).2;
        (sim.rank(&job, gone, 0).3, weight / u128::from(10 * MS))
    };
    // Job 0 was in time. It is none of the last 16 any more once job 16 left, and 17 are lost once job 17 left.
    assert_eq!((last(16, &[]), last(16, &[(0, 16)])), ((0, 17), (0, 16)));
    assert_eq!((last(17, &[]), last(17, &[(0, 17)])), ((0, 16), (17, 16)));
}
