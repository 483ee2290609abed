//! Runs that nobody but their caller stops: from outside, from a body, as they start.

mod called;

use called::{Run, Running, setup, wait_for};
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use red_rt::control::Refused;
use red_rt::handler::Work;
use red_rt::report::{RunReport, Stopped};

/// A run of one lane, to its end.
fn run_on(
    body: impl Fn(&Work) + Send + Sync + Clone + 'static,
    started: impl FnOnce(Running) + Send + 'static,
) -> ([usize; 2], RunReport) {
    Run::start(setup(1, true, body), started).ended()
}

#[test]
fn a_run_is_stopped_from_outside_and_another_one_goes_on() {
    let ran = Arc::new([const { AtomicU64::new(0) }; 2]);
    let [first, last] = [0, 1].map(|number| {
        let ran = ran.clone();
        Run::start(
            setup(1, true, move |_: &Work| {
                ran[number].fetch_add(1, Ordering::Relaxed);
                thread::sleep(Duration::from_millis(1));
            }),
            |_| (),
        )
    });
    wait_for(|| ran[0].load(Ordering::Relaxed) > 0);
    first.control.stop();
    first.control.stop();
    assert_eq!(first.control.release(first.task, None), Err(Refused::Over));
    let ([released, ended], report) = first.ended();
    assert_eq!((report.stopped_by, report.gave_up), (Some(Stopped::Caller), None));
    assert_eq!((report.threads_died, report.lanes_lost, report.hung), (0, 0, 0));
    assert_eq!(report.dispatch_ns.len() as usize, ended, "each unit that began was waited for");
    assert!(released >= ended && ended > 0 && report.busy_ns[0] > 0, "the lane's figures are there");

    let before = ran[1].load(Ordering::Relaxed);
    wait_for(|| ran[1].load(Ordering::Relaxed) > before + 1);
    assert_eq!(last.control.release(last.task, None), Ok(()));
    assert_eq!(last.stop().stopped_by, Some(Stopped::Caller));
    first.control.stop();
    assert_eq!(first.control.release(first.task, None), Err(Refused::Over));
}

#[test]
fn a_run_that_is_stopped_in_a_body_begins_no_other_one() {
    const STOPS: u64 = 3;
    static RUNNING: OnceLock<Running> = OnceLock::new();
    let ran = Arc::new(AtomicUsize::new(0));
    let bodies = ran.clone();
    let body = move |work: &Work| {
        bodies.fetch_add(1, Ordering::Relaxed);
        // So that there is always another job.
        thread::sleep(Duration::from_millis(5));
        if work.job == STOPS {
            let (control, task) = RUNNING.get().expect("the run started");
            assert_eq!(control.release(*task, None), Ok(()));
            control.stop();
            control.stop();
            assert_eq!(control.release(*task, None), Err(Refused::Over));
        }
    };
    let ([_, ended], report) = run_on(body, |running| assert!(RUNNING.set(running).is_ok()));
    let expected = STOPS as usize + 1;
    assert_eq!((report.stopped_by, report.failed), (Some(Stopped::Caller), 0), "{:?}", report.panics);
    assert_eq!((ran.load(Ordering::Relaxed), ended), (expected, expected), "no unit is begun");
    assert_eq!(report.threads_died, 0, "the lane was asked to leave");
}

#[test]
fn a_run_that_is_stopped_as_it_starts_releases_nothing() {
    let ([released, _], report) = run_on(|_| panic!("it ran"), |(control, _)| control.stop());
    assert_eq!((released, report.failed), (0, 0));
    assert_eq!(report.stopped_by, Some(Stopped::Caller));
}
