use super::*;
use red_workload::build::Role;
use red_workload::model::{Body, Part};

fn node(name: &str) -> Numbered {
    let part = Part {
        wcet_ns: 50,
        bcet_ns: 0,
        body: Body::None,
        pool: 0,
        memory_bytes: 0,
        atomic: false,
        contention_ns: 0,
    };
    Numbered { name: name.to_owned(), role: Role::Plain(part) }
}

fn past() -> Past {
    let mut past = Past::new(1);
    for job in 0..4 {
        past.released(0, job * 10);
        past.executed(0, job, &node("a"), 7 + job);
    }
    past
}

#[test]
fn every_second_job_keeps_its_own_times() {
    let past = past();
    let world = Changed { past: &past, otherwise: Otherwise { halved: Some(0), ..Otherwise::default() } };
    assert_eq!([0, 1, 2].map(|job| world.release(0, job)), [Some(0), Some(20), None]);
    assert_eq!(world.time(0, 1, &node("a")), (9, true));
}

#[test]
fn halves_of_a_node_are_the_node() {
    let past = past();
    let split = Some((0, "a.1".to_owned(), "a".to_owned()));
    let world = Changed { past: &past, otherwise: Otherwise { split, ..Otherwise::default() } };
    assert_eq!([world.time(0, 0, &node("a.1")), world.time(0, 0, &node("a"))], [(4, true), (3, true)]);
}

#[test]
fn a_capped_node_takes_no_longer_and_a_task_that_is_not_there_releases_nothing() {
    let past = past();
    let otherwise =
        Otherwise { capped: Some((0, "a".to_owned(), 8)), without: Some(0), ..Otherwise::default() };
    let world = Changed { past: &past, otherwise };
    assert_eq!([0, 3].map(|job| world.time(0, job, &node("a")).0), [7, 8]);
    assert_eq!(world.release(0, 0), None);
}
