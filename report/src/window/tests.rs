use super::*;
use crate::model::{Job, Miss, Task};

fn run() -> Run {
    Run { tasks: vec![Task { deadline_ns: 100, ..Task::default() }], end_ns: 10_000, ..Run::default() }
}

#[test]
fn the_worst_miss_is_shown_with_room_around_it() {
    let mut run = run();
    let job = |release_ns| Job {
        release_ns,
        recorded_ns: release_ns,
        deadline_ns: release_ns + 100,
        ..Job::default()
    };
    run.jobs = vec![vec![job(1_000), job(5_000)]];
    let miss = |job, until_ns| Miss { task: 0, job, until_ns, parts: Vec::new(), saved_by: None };
    run.misses = vec![miss(0, 1_110), miss(1, 5_700)];
    let (from, until) = window(&run);
    assert!(from < 5_000 && until > 5_700 && until - from == 933, "{from} {until}");
}

#[test]
fn without_a_miss_the_first_edit_is_shown_and_else_the_beginning() {
    let mut run = run();
    assert_eq!(window(&run), (0, 500));
    run.edits = vec![(3_000, "+detect".to_owned()), (6_000, "-detect".to_owned())];
    assert_eq!(window(&run), (2_750, 3_250));
}

#[test]
fn a_short_run_is_shown_whole() {
    let run = Run { end_ns: 50, ..run() };
    assert_eq!(window(&run), (0, 50));
}
