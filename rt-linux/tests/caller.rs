//! Runs in a process that is not theirs: whoever called them stops them, and they touch neither signals nor hooks.

mod called;

use called::{Run, Running, setup, wait_for};
use std::panic;
use std::ptr;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, raise, sigaction};
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

/// What the process does about each signal, as the kernel has it.
fn actions() -> Vec<(i32, usize, i32)> {
    let action = |signal| {
        let mut now = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: asks only, and writes to a place of that type.
        let asked = unsafe { libc::sigaction(signal, ptr::null(), now.as_mut_ptr()) };
        // SAFETY: all its bits may be zero, and it was written if the call succeeded.
        let now = unsafe { now.assume_init() };
        (asked == 0).then_some((signal, now.sa_sigaction, now.sa_flags))
    };
    (1..32).filter_map(action).collect()
}

extern "C" fn stop_it(_signal: i32) {
    if let Some((control, _)) = OF_THE_HANDLER.get() {
        control.stop();
    }
}

static OF_THE_HANDLER: OnceLock<Running> = OnceLock::new();

#[test]
fn no_signal_handler_is_touched_and_one_of_the_caller_may_stop_the_run() {
    let action = SigAction::new(SigHandler::Handler(stop_it), SaFlags::SA_RESTART, SigSet::empty());
    // SAFETY: the handler reads what was set before the signal is raised, and calls what is async-signal-safe.
    unsafe { sigaction(Signal::SIGTERM, &action) }.expect("nothing forbids it");
    let before = actions();
    assert!(
        before.len() > 20 && before.iter().any(|(_, handler, _)| *handler == stop_it as *const () as usize)
    );
    let during = Arc::new(Mutex::new(Vec::new()));
    let seen = during.clone();
    let body = move |work: &Work| {
        if work.job == 2 {
            *seen.lock().expect("nobody panicked") = actions();
            raise(Signal::SIGTERM).expect("to this thread");
        }
    };
    let (_, report) = run_on(body, |running| assert!(OF_THE_HANDLER.set(running).is_ok()));
    assert_eq!(report.stopped_by, Some(Stopped::Caller));
    assert_eq!(*during.lock().expect("nobody panicked"), before);
    assert_eq!(actions(), before);
}

#[test]
fn the_panic_hook_of_the_process_is_left_alone_and_the_words_are_in_the_report() {
    static PRINTED: Mutex<Vec<String>> = Mutex::new(Vec::new());
    static RUNNING: OnceLock<Running> = OnceLock::new();
    let others = panic::take_hook();
    panic::set_hook(Box::new(move |info| match info.payload_as_str() {
        Some(said) if said.starts_with("of job") => {
            PRINTED.lock().unwrap_or_else(PoisonError::into_inner).push(said.to_owned());
        }
        _ => others(info),
    }));
    let body = |work: &Work| match work.job {
        0 => panic!("of job 0"),
        1 => panic!("of job {}", work.job),
        _ => RUNNING.get().expect("the run started").0.stop(),
    };
    let (_, report) = run_on(body, |running| assert!(RUNNING.set(running).is_ok()));
    let said: Vec<&str> = report.panics.iter().map(|panic| &*panic.message).collect();
    assert_eq!(said, ["of job 0", "of job 1"]);
    assert_eq!(*PRINTED.lock().unwrap_or_else(PoisonError::into_inner), said);
}
