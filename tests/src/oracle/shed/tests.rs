use crate::fixtures::{MS, every, lines, node, once, shed_lines, workload};
use crate::oracle::{Policy, simulate};
use red_workload::model::{Node, Task, Work, Workload};

fn flat(count: usize, cost_ms: u64) -> Vec<Node> {
    (0..count).map(|index| node(&format!("n{index}"), cost_ms, &[])).collect()
}

fn sheds(workload: &Workload, policy: Policy, horizon_ms: u64) -> Vec<String> {
    shed_lines(&simulate(workload, policy, horizon_ms * MS))
}

#[test]
fn a_job_that_cannot_end_in_time_is_aborted_at_the_next_event() {
    let tasks = vec![once("a", 12, vec![node("n", 10, &[])]), once("b", 12, vec![node("n", 10, &[])])];
    let outcome = simulate(&workload(1, tasks), Policy::Redrt, 100 * MS);
    assert_eq!(shed_lines(&outcome), ["b/0 5 hopeless"]);
    assert_eq!(lines(&outcome), ["a/0/n 0 0..10"]);
    assert_eq!((outcome.tasks[0].on_time, outcome.tasks[1].missed), (1, 1));
}

#[test]
fn a_job_that_may_just_end_in_time_runs() {
    let tasks = vec![once("a", 10, vec![node("n", 10, &[])]), once("b", 20, vec![node("n", 10, &[])])];
    assert!(sheds(&workload(1, tasks), Policy::Redrt, 100).is_empty());
}

#[test]
fn the_least_urgent_job_goes_until_the_queue_is_short() {
    let tasks = vec![once("a", 100, flat(6, 50)), once("b", 1000, flat(6, 50))];
    let outcome = simulate(&workload(1, tasks), Policy::Red, 400 * MS);
    // Queues of 12, 11, 11 at 0, 5, 10. Dropping b leaves 5, and later ticks see U = 1: a goes at the third.
    assert_eq!(shed_lines(&outcome), ["b/0 10 urgency", "a/0 25 urgency"]);
    // What runs is not stopped.
    assert_eq!(lines(&outcome), ["a/0/n0 0 0..50"]);
}

#[test]
fn the_others_never_shed_but_what_finds_no_room() {
    let tasks = vec![every(once("a", 10, vec![node("n", 1000, &[])]), 1)];
    for policy in [Policy::Edf, Policy::RedFg, Policy::RedIda] {
        let outcome = simulate(&workload(1, tasks.clone()), policy, 66 * MS);
        assert_eq!(shed_lines(&outcome), ["a/64 64 full", "a/65 65 full"]);
        assert_eq!((outcome.tasks[0].released, outcome.tasks[0].missed), (66, 58));
    }
}

#[test]
fn a_floor_keeps_jobs_of_any_window() {
    let floor = |floor| Task { floor, ..every(once("a", 1000, flat(9, 100)), 20) };
    let at_most_one_of_two = sheds(&workload(1, vec![floor(Some((1, 2)))]), Policy::Red, 60);
    let none = sheds(&workload(1, vec![floor(Some((2, 2)))]), Policy::Red, 60);
    let all = sheds(&workload(1, vec![floor(None)]), Policy::Red, 60);
    assert!(none.is_empty());
    // Without a floor each third tick under load drops whatever is there.
    assert_eq!(all[..2], ["a/0 10 urgency", "a/1 25 urgency"]);
    // With it the neighbours of a dropped job stay.
    assert_eq!(at_most_one_of_two, ["a/0 10 urgency", "a/2 40 urgency"]);
}

/// `busy` runs over 0..40, `x` takes 40, or 60 at its worst, and is due at `due_ms`; `w` queues ten nodes.
fn overloaded(value: u32, due_ms: u64) -> Workload {
    let mut atomic = node("n", 40, &[]);
    if let Work::Plain(part) = &mut atomic.work {
        (part.atomic, part.contention_ns) = (true, 20 * MS);
    }
    let x = Task { value, ..once("x", due_ms, vec![atomic]) };
    workload(1, vec![once("busy", 41, flat(1, 40)), x, once("w", 500, flat(10, 1))])
}

#[test]
fn overload_drops_the_least_valuable_until_no_job_is_lost() {
    // x starts at 40, so that it is never lost, even at its worst: 40 + 60.
    assert!(sheds(&overloaded(1, 100), Policy::Redrt, 300).is_empty());
    // Lost from 36 on, though 40 + 40 fits: ticks 40, 45, 50. x runs by then, so w goes, and x stays lost.
    assert_eq!(sheds(&overloaded(1, 95), Policy::Redrt, 300), ["w/0 50 overload"]);
    // Lost from 25 on: ticks 25, 30, 35. x goes first for its value, and nobody is lost any more.
    assert_eq!(sheds(&overloaded(0, 84), Policy::Redrt, 300), ["x/0 35 overload"]);
    // Equal values: the larger remaining work, 60 against 10, goes first.
    assert_eq!(sheds(&overloaded(1, 84), Policy::Redrt, 300), ["x/0 35 overload"]);
    // A higher value makes w go first, but x stays lost and follows.
    assert_eq!(sheds(&overloaded(9, 84), Policy::Redrt, 300), ["w/0 35 overload", "x/0 35 overload"]);
}

#[test]
fn a_long_queue_without_a_lost_job_sheds_nothing_under_redrt() {
    assert!(sheds(&workload(1, vec![once("wide", 1000, flat(40, 20))]), Policy::Redrt, 900).is_empty());
}
