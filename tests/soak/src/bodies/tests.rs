use super::*;

#[test]
fn a_body_that_runs_twice_for_one_sub_job_is_told() {
    let tried = Arc::new(Tried::default());
    let mut bodies = Bodies { seed: 1, tried: tried.clone(), spins: false, dies: false };
    let jobs = [0, 1, 2].map(|job| Work { job, ..Work::default() });
    jobs.iter().for_each(|work| assert_eq!(bodies.run(work), Ok(())));
    assert_eq!((tried.twice(), tried.ran.load(Ordering::Relaxed)), (None, 3));
    assert_eq!(bodies.run(&jobs[1]), Ok(()));
    assert_eq!(tried.twice(), Some(jobs[1]));
}
