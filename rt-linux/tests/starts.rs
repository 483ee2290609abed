//! How a run starts: what does not fit together is refused, and a lane that does not come up is lost, not waited for.

mod one_lane;

use one_lane::{Counted, FAR_NS, Plan, alone, wait_for};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use red_core::{Config, Wcet};
use red_rt::handler::Work;
use red_rt::report::Surrender;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::setup::SetupError;

fn idle() -> Setup<one_lane::OneNode> {
    let (wcet, duration_ns, drain_ns) = (Wcet::from_millis(1), 0, 0);
    Plan { wcet, duration_ns, drain_ns, begin: || (), body: |_: &Work| () }.setup().0
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let _alone = alone();
    let refused = |setup| {
        let never = |_| panic!("it started");
        run(setup, Counted::default(), |_| (), never).err().expect("refused")
    };
    let error = refused(Setup { lanes: 2, ..idle() });
    assert_eq!(error, SetupError::OtherLanes { lanes: 2, of_scheduler: 1 });
    assert!(error.to_string().ends_with("fix: give both the same"), "{error}");

    let mut setup = idle();
    setup.scheduler.configure(Config { preempt: true, ..Config::EDF });
    assert_eq!(refused(setup), SetupError::Preempts);

    for cpus in [vec![], vec![0, 1]] {
        let mode = Mode::RealTime { priority: 40, cpus: cpus.clone() };
        let error = refused(Setup { mode, ..idle() });
        assert_eq!(error, SetupError::NotACpuEach { lanes: 1, cpus });
    }
    let cpus = vec![0, 0];
    let mut setup = Setup { lanes: 2, mode: Mode::RealTime { priority: 40, cpus: cpus.clone() }, ..idle() };
    setup.scheduler.add_pool(1, None).expect("room for two pools");
    assert_eq!(refused(setup), SetupError::NotACpuEach { lanes: 2, cpus });
    run(idle(), Counted::default(), |_| (), |_| ()).expect("what fits together runs");
}

#[test]
fn a_lane_that_hangs_when_the_run_starts_gets_another_thread() {
    let _alone = alone();
    let (begun, is_over) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let (begins, over) = (begun.clone(), is_over.clone());
    let has_run = Arc::new(AtomicBool::new(false));
    let runs = has_run.clone();
    let plan = Plan {
        wcet: Wcet::from_millis(1),
        duration_ns: 1_500_000_000,
        drain_ns: FAR_NS,
        begin: move || {
            if begins.fetch_add(1, Ordering::Relaxed) == 0 {
                wait_for(&over);
            }
        },
        body: move |_: &Work| runs.store(true, Ordering::Relaxed),
    };
    let (host, report) = plan.run(|_, _| (), |_| ());
    is_over.store(true, Ordering::Relaxed);
    assert_eq!((report.hung, report.lanes_lost, report.threads_died), (1, 0, 0));
    assert!(has_run.load(Ordering::Relaxed) && host.ended > 0, "the spare runs bodies");
    assert_eq!(begun.load(Ordering::Relaxed), 2);
}

#[test]
fn a_spare_that_does_not_come_up_leaves_its_lane_without_a_thread() {
    let _alone = alone();
    let is_over = Arc::new(AtomicBool::new(false));
    let (over, made) = (is_over.clone(), AtomicUsize::new(0));
    let body = move |_: &Work| wait_for(&over);
    let plan = Plan { wcet: Wcet::from_millis(1), duration_ns: FAR_NS, drain_ns: FAR_NS, begin: || (), body };
    let (setup, _) = plan.setup();
    let first = setup.handlers.clone();
    let handlers = move |lane| {
        assert_eq!(made.fetch_add(1, Ordering::Relaxed), 0, "of the spare");
        first(lane)
    };
    let setup = Setup { handlers: Arc::new(handlers), ..setup };
    let (_, report) = run(setup, Counted::default(), |_| (), |_| ()).expect("needs no rights");
    is_over.store(true, Ordering::Relaxed);
    assert_eq!((report.hung, report.lanes_lost, report.gave_up), (1, 1, Some(Surrender::NoLane)));
}
