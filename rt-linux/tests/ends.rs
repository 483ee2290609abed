//! How a run ends: what is released, run and counted when it is stopped and when its time is over.

mod one_lane;

use one_lane::{Counted, FAR_NS, OneNode, PERIOD_NS, Plan, alone, wait_for};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread;
use std::time::Duration;

use nix::sys::signal::{Signal, raise};
use red_core::{TaskId, Wcet};
use red_rt::control::Control;
use red_rt::handler::Work;
use red_rt::report::{RunReport, Stopped};
use red_rt::stop::StopSignals;

/// Jobs in a run, one each millisecond.
const JOBS: usize = 15;

#[test]
fn a_lane_that_is_never_idle_stops_after_the_body_that_runs() {
    const STOPS: u64 = 3;
    static RUNNING: OnceLock<(Arc<dyn Control<OneNode>>, TaskId)> = OnceLock::new();
    let _alone = alone();
    let ran = Arc::new(AtomicUsize::new(0));
    let is_stopped = Arc::new(AtomicBool::new(false));
    let (bodies, stopped) = (ran.clone(), is_stopped.clone());
    let plan = Plan {
        wcet: Wcet::from_millis(10_000),
        duration_ns: FAR_NS,
        drain_ns: FAR_NS,
        begin: || (),
        body: move |work: &Work| {
            bodies.fetch_add(1, Ordering::Relaxed);
            if work.job == STOPS {
                raise(Signal::SIGTERM).expect("to this thread");
                wait_for(&stopped);
                let (control, task) = RUNNING.get().expect("the run started");
                while control.release(*task, None).is_ok() {
                    thread::sleep(Duration::from_millis(20));
                }
            }
            // Longer than the period, so that there is always another job.
            thread::sleep(Duration::from_millis(5));
        },
    };
    let signals = StopSignals::install().expect("nothing forbids it");
    let started = |control, task| assert!(RUNNING.set((control, task)).is_ok());
    // The control thread asks the lanes to stop right after this.
    let progress = |_| is_stopped.store(signals.requested().is_some(), Ordering::Relaxed);
    let (host, report) = plan.run(started, progress);
    let expected = STOPS as usize + 1;
    assert_eq!(report.stopped_by, Some(Stopped::Signal("SIGTERM")));
    assert_eq!((ran.load(Ordering::Relaxed), host.ended), (expected, expected), "no unit is begun");
    assert_eq!(report.dispatch_ns.len(), expected as u64, "the lane's figures are there");
    assert!(report.busy_ns[0] > 0 && report.overhead_ns_per_unit > 0);
}

#[test]
fn a_signal_before_the_run_leaves_nothing_to_run() {
    let _alone = alone();
    let signals = StopSignals::install().expect("nothing forbids it");
    raise(Signal::SIGINT).expect("to this thread");
    assert!(signals.requested().is_some());
    let is_over = Arc::new(AtomicBool::new(false));
    let over = is_over.clone();
    let plan = Plan {
        wcet: Wcet::from_millis(1),
        duration_ns: FAR_NS,
        drain_ns: FAR_NS,
        begin: || (),
        body: move |_: &Work| over.store(true, Ordering::Relaxed),
    };
    let (host, report) = plan.run(|_, _| (), |_| ());
    assert_eq!((host.released, report.stopped_by), (0, Some(Stopped::Signal("SIGINT"))));
    assert!(!is_over.load(Ordering::Relaxed), "no body ran");
    assert!(signals.requested().is_some(), "the holder outside knows it too");
}

#[test]
fn a_run_that_takes_signals_is_stopped_by_its_caller_too() {
    let _alone = alone();
    let control = Arc::new(OnceLock::<Arc<dyn Control<OneNode>>>::new());
    let running = control.clone();
    let plan = Plan {
        wcet: Wcet::from_millis(1),
        duration_ns: FAR_NS,
        drain_ns: FAR_NS,
        begin: || (),
        body: move |_: &Work| running.get().expect("the run started").stop(),
    };
    let (host, report) = plan.run(|running, _| assert!(control.set(running).is_ok()), |_| ());
    assert_eq!((host.ended, report.stopped_by), (1, Some(Stopped::Caller)));
}

/// A run whose lane gets no CPU until `gets_cpu` says so of the time.
fn starved(drain_ns: u64, gets_cpu: impl Fn(u64) -> bool) -> (Counted, RunReport) {
    let _alone = alone();
    let has_cpu = Arc::new(AtomicBool::new(false));
    let lane = has_cpu.clone();
    let plan = Plan {
        wcet: Wcet::from_millis(1),
        duration_ns: JOBS as u64 * PERIOD_NS,
        drain_ns,
        begin: move || wait_for(&lane),
        body: |_: &Work| (),
    };
    let ended = plan.run(|_, _| (), |now| has_cpu.store(gets_cpu(now), Ordering::Relaxed));
    has_cpu.store(true, Ordering::Relaxed);
    ended
}

#[test]
fn releases_of_a_starved_lane_are_made_before_the_run_counts_as_drained() {
    let (host, report) = starved(FAR_NS, |now| now >= JOBS as u64 * PERIOD_NS);
    assert_eq!((host.released, host.ended), (JOBS, JOBS));
    assert_eq!((report.dispatch_ns.len(), report.stopped_by), (JOBS as u64, None));
}

#[test]
fn releases_that_no_lane_came_to_are_counted() {
    // The run does not wait for ever for a lane that is not heard of.
    let (host, report) = starved(0, |_| false);
    assert_eq!((host.released, host.ended), (JOBS, 0));
    assert_eq!(report.dispatch_ns.len(), 0);
}

#[test]
fn what_was_asked_for_in_time_is_released_also_where_no_lane_came_to_it() {
    const ENDS_NS: u64 = 1_000_000_000;
    static RUNNING: OnceLock<(Arc<dyn Control<OneNode>>, TaskId)> = OnceLock::new();
    let _alone = alone();
    let (asked, is_over) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let (takes, over) = (asked.clone(), is_over.clone());
    let plan = Plan {
        // Its bound comes after the end.
        wcet: Wcet::from_millis(1_000),
        duration_ns: ENDS_NS,
        drain_ns: 0,
        begin: || (),
        body: move |_: &Work| {
            let (control, task) = RUNNING.get().expect("the run started");
            takes.fetch_add(usize::from(control.release(*task, None).is_ok()), Ordering::Relaxed);
            // The only lane is busy until the time is over.
            wait_for(&over);
        },
    };
    let started = |control, task| assert!(RUNNING.set((control, task)).is_ok());
    let (host, report) = plan.run(started, |now| is_over.store(now >= ENDS_NS, Ordering::Relaxed));
    let released = (ENDS_NS / PERIOD_NS) as usize;
    assert_eq!((asked.load(Ordering::Relaxed), host.released), (1, released + 1));
    assert_eq!((report.counters.clock_steps_back, report.events_dropped), (0, 0));
}

#[test]
fn a_panic_of_who_waits_for_a_run_leaves_no_lane_behind() {
    struct Tells(Arc<AtomicBool>);
    impl Drop for Tells {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let _alone = alone();
    let is_gone = Arc::new(AtomicBool::new(false));
    let last = Arc::new(Tells(is_gone.clone()));
    let plan = Plan {
        wcet: Wcet::from_millis(1),
        duration_ns: FAR_NS,
        drain_ns: FAR_NS,
        begin: || (),
        body: move |_: &Work| drop(last.clone()),
    };
    let panics = AssertUnwindSafe(|| plan.run(|_, _| (), |_| panic!("of the host")));
    assert!(catch_unwind(panics).is_err());
    // The handlers, with all that the bodies hold.
    wait_for(&is_gone);
}
