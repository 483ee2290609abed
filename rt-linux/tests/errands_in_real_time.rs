//! Errands of an ordinary thread on a lane in real time. Needs the rights of `with_rights`, and fails without.

mod called;

use called::{Run, setup, wait_for};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use red_core::Instant;
use red_record::Recorder;
use red_rt::allocations::CountingAllocator;
use red_rt::control::Errand;
use red_rt::handler::Work;
use red_rt::placement::usable_cpus;
use red_rt::runtime::{Mode, Setup};
use red_rt::setup::SetupError;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

#[test]
fn a_lane_in_real_time_runs_errands_between_its_bodies() {
    const ERRANDS: u64 = 300;
    let [bodies, errands] = [0; 2].map(|_| Arc::new(AtomicU64::new(0)));
    let (ran, asked) = (bodies.clone(), errands.clone());
    let (setup, task) = setup(1, true, move |_: &Work| {
        ran.fetch_add(1, Ordering::Relaxed);
    });
    let cpu = *usable_cpus().expect("an affinity mask").last().expect("at least one CPU");
    let mode = Mode::RealTime { priority: 40, cpus: vec![cpu] };
    let run = Run::start((Setup { mode: mode.clone(), ..setup }, task), |_| ());
    // Another run does not get its CPU.
    let other = Setup { mode, ..called::setup(1, true, |_: &Work| ()).0 };
    let refused = red_rt::runtime::run(other, called::Counted::default(), |_| (), |_| ()).err();
    assert_eq!(refused, Some(SetupError::CpusHeld { cpus: vec![cpu] }));
    let mut errand: Errand<_> = Box::new(move |scheduler: &mut Recorder<'_, _>, now: Instant| {
        assert!(scheduler.lanes() == 1 && now > Instant::ZERO);
        asked.fetch_add(1, Ordering::Relaxed);
    });
    for _ in 0..ERRANDS {
        run.control.release(run.task, None).expect("a lane has come to the one before");
        errand = run.control.ask(errand).map_err(|e| e.to_string()).expect("the run goes on");
    }
    wait_for(|| bodies.load(Ordering::Relaxed) > 10);
    let report = run.stop();
    assert_eq!((errands.load(Ordering::Relaxed), report.allocations), (ERRANDS, 0));
    assert!(report.realtime && report.hung == 0, "{report:?}");
}
