//! A run of a library leaves the process of its host as it is. Alone in its process, because signal handlers and the panic
//! hook belong to all of it: another run could have changed them before, and hide that this one does.

mod called;

use called::{Run, Running, setup, wait_for};
use std::mem::MaybeUninit;
use std::panic;
use std::ptr;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nix::sys::signal::{SaFlags, SigAction, SigHandler, SigSet, Signal, raise, sigaction};
use red_rt::control::Refused;
use red_rt::handler::Work;
use red_rt::report::Stopped;

/// What the process does about each signal, as the kernel has it.
fn actions() -> Vec<(i32, usize, i32)> {
    let action = |signal| {
        let mut now = MaybeUninit::<libc::sigaction>::zeroed();
        // SAFETY: asks only, and writes to a place of that type.
        let asked = unsafe { libc::sigaction(signal, ptr::null(), now.as_mut_ptr()) };
        // SAFETY: all its bits may be zero, and it was written if the call succeeded.
        let now = unsafe { now.assume_init() };
        (asked == 0).then_some((signal, now.sa_sigaction, now.sa_flags))
    };
    (1..32).filter_map(action).collect()
}

static RUNNING: OnceLock<Running> = OnceLock::new();
/// What the hook was called for.
static PRINTED: Mutex<Vec<String>> = Mutex::new(Vec::new());

extern "C" fn stop_it(_signal: i32) {
    if let Some((control, _)) = RUNNING.get() {
        control.stop();
    }
}

#[test]
fn signals_and_panics_go_where_they_went_before_and_a_handler_may_stop_the_run() {
    let action = SigAction::new(SigHandler::Handler(stop_it), SaFlags::SA_RESTART, SigSet::empty());
    // SAFETY: the handler reads what was set before the signal is raised, and calls what is async-signal-safe.
    unsafe { sigaction(Signal::SIGTERM, &action) }.expect("nothing forbids it");
    let others = panic::take_hook();
    panic::set_hook(Box::new(move |info| match info.payload_as_str() {
        Some(said) if said.starts_with("of job") => {
            PRINTED.lock().unwrap_or_else(PoisonError::into_inner).push(said.to_owned());
        }
        _ => others(info),
    }));
    let before = actions();
    let is_ours = |(_, handler, _): &(i32, usize, i32)| *handler == stop_it as *const () as usize;
    assert!(before.len() > 20 && before.iter().any(is_ours), "{before:?}");

    let during = Arc::new(Mutex::new(None));
    let seen = during.clone();
    let body = move |work: &Work| match work.job {
        0 => panic!("of job 0"),
        1 => panic!("of job {}", work.job),
        _ => *seen.lock().expect("nobody panicked") = Some(actions()),
    };
    let run = Run::start(setup(1, false, body), |running| assert!(RUNNING.set(running).is_ok()));
    for _ in 0..3 {
        run.control.release(run.task, None).expect("the run goes on");
    }
    wait_for(|| during.lock().expect("nobody panicked").is_some());
    raise(Signal::SIGTERM).expect("to this thread");
    assert_eq!(run.control.release(run.task, None), Err(Refused::Over));
    let report = run.stop();
    let said: Vec<&str> = report.panics.iter().map(|panic| &*panic.message).collect();
    assert_eq!((report.stopped_by, &said[..]), (Some(Stopped::Caller), &["of job 0", "of job 1"][..]));
    assert_eq!(*PRINTED.lock().unwrap_or_else(PoisonError::into_inner), said);
    assert_eq!(during.lock().expect("nobody panicked").as_ref(), Some(&before));
    assert_eq!(actions(), before);
}
