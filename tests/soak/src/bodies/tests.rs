use super::*;

#[test]
fn a_body_that_runs_twice_for_one_sub_job_is_told() {
    let tried = Arc::new(Tried::default());
    let mut bodies = Bodies::of(1, tried.clone(), false, false);
    let jobs = [0, 1, 2].map(|job| Work { job, ..Work::default() });
    jobs.iter().for_each(|work| assert_eq!(bodies.run(work), Ok(())));
    assert_eq!((tried.twice(), tried.ran.load(Ordering::Relaxed)), (None, 3));
    assert_eq!(bodies.run(&jobs[1]), Ok(()));
    assert_eq!(tried.twice(), Some(jobs[1]));
}

#[test]
fn few_bodies_of_a_workload_hang_and_few_threads_die() {
    let tried = Tried::default();
    let of = |may: fn(&Tried) -> bool| (0..100).filter(|_| may(&tried)).count();
    assert_eq!([of(Tried::may_hang), of(Tried::may_die)], [3, 3]);
}

#[test]
fn of_threads_that_were_lost_most_may_be_untold() {
    let tried = Arc::new(Tried::default());
    for count in [1, 4, 2] {
        let bodies = Bodies::of(1, tried.clone(), false, false);
        (0..count).for_each(|_| bodies.goes_wrong(&tried.failed));
    }
    assert_eq!([0, 1, 2, 3, 9].map(|lost| tried.untold(lost)), [0, 4, 6, 7, 7]);
}
