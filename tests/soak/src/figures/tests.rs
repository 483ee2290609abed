use super::*;
use crate::bodies::Bodies;
use crate::episode::built;
use crate::judge::Judge;
use crate::workload::Drawn;
use red_rt::handler::Handler;
use red_rt::report::Surrender;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use std::sync::Arc;
use std::thread;

/// The figures of a run in which nothing happens.
fn quiet() -> RunReport {
    let drawn = Drawn::of(2, 1_000_000, 0, false);
    let (scheduler, plan, tasks) = built(&drawn.workload, drawn.policy);
    let again = built(&drawn.workload, drawn.policy).0;
    let judge = Judge::new(again, &drawn.workload, &plan, &tasks, drawn.policy);
    let bodies = |_| -> Box<dyn Handler> { Box::new(Bodies::of(0, Arc::default(), false, false)) };
    let setup = Setup {
        scheduler,
        lanes: drawn.workload.pools.iter().map(|pool| pool.lanes as usize).sum(),
        streams: 0,
        mode: Mode::BestEffort,
        releases: Vec::new(),
        duration_ns: 1_000_000,
        drain_ns: 0,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(bodies),
        enclose: Arc::new(|main: Box<dyn FnOnce() + Send>| main()),
    };
    let (_, report) = run(setup, judge, |_| {}, |_| {}).expect("needs no rights");
    report
}

#[test]
fn figures_that_contradict_each_other_are_told() {
    // The state of a scheduler is too large for the stack of a test.
    let thread = thread::Builder::new().stack_size(16 << 20).spawn(quiet).expect("there is room");
    let quiet = thread.join().expect("needs no rights");
    let with = |plant: fn(&mut RunReport, &Tried)| {
        let (mut report, tried) = (quiet.clone(), Tried::default());
        plant(&mut report, &tried);
        wrong_figures(&report, &tried)
    };
    assert_eq!(with(|_, _| {}), None);
    type Plant = fn(&mut RunReport, &Tried);
    let planted: [(&str, Plant); 11] = [
        ("a run that gave up", |report, _| report.gave_up = Some(Surrender::NoLane)),
        ("a lane that was lost", |report, _| report.lanes_lost = 1),
        ("an event that was dropped", |report, _| report.events_dropped = 1),
        ("time that went back", |report, _| report.counters.clock_steps_back = 1),
        ("a unit more without a body than there are lanes", |report, _| {
            report.counters.units = lanes(report) + 1;
        }),
        ("two more where a lane was lost", |report, _| {
            report.hung = 1;
            report.counters.units = lanes(report) + 2;
        }),
        ("a body without a unit", |_, tried| tried.ran.store(1, Ordering::Relaxed)),
        ("a failure that nobody told", |_, tried| tried.panicked.store(1, Ordering::Relaxed)),
        ("a failure that was none", |report, _| report.failed = 1),
        ("more failures untold than a thread had", |report, tried| {
            report.hung = 1;
            tried.panicked.store(1, Ordering::Relaxed);
        }),
        ("a thread that died on its own", |report, _| report.threads_died = 1),
    ];
    for (what, plant) in planted {
        assert!(with(plant).is_some(), "not caught: {what}");
    }
    let right: [(&str, Plant); 2] = [
        ("units in the seats", |report, _| report.counters.units = lanes(report)),
        ("one more, discarded with a thread", |report, _| {
            report.hung = 1;
            report.counters.units = lanes(report) + 1;
        }),
    ];
    for (what, plant) in right {
        assert_eq!(with(plant), None, "{what}");
    }
}

fn lanes(report: &RunReport) -> u64 {
    report.busy_ns.len() as u64
}
