use super::*;
use red_rt::report::Surrender;

/// The figures of a run in which nothing happens.
fn quiet() -> RunReport {
    let drawn = Drawn::of(2, 1_000_000, 0, false);
    let (scheduler, plan, tasks) = built(&drawn.workload, drawn.policy);
    let again = built(&drawn.workload, drawn.policy).0;
    let judge = Judge::new(again, &drawn.workload, &plan, &tasks, drawn.policy);
    let bodies = |_| -> Box<dyn Handler> {
        Box::new(Bodies { seed: 0, tried: Arc::default(), spins: false, dies: false })
    };
    let setup = Setup {
        scheduler,
        lanes: drawn.workload.pools.iter().map(|pool| pool.lanes as usize).sum(),
        mode: Mode::BestEffort,
        releases: Vec::new(),
        duration_ns: 1_000_000,
        drain_ns: 0,
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
    let planted: [(&str, Plant); 8] = [
        ("a run that gave up", |report, _| report.gave_up = Some(Surrender::NoLane)),
        ("a lane that was lost", |report, _| report.lanes_lost = 1),
        ("an event that was dropped", |report, _| report.events_dropped = 1),
        ("time that went back", |report, _| report.counters.clock_steps_back = 1),
        ("a unit without a body", |report, _| report.counters.units = 1),
        ("a body without a unit", |_, tried| tried.ran.store(1, Ordering::Relaxed)),
        ("a failure that nobody told", |_, tried| tried.panicked.store(1, Ordering::Relaxed)),
        ("a thread that died on its own", |report, _| report.threads_died = 1),
    ];
    for (what, plant) in planted {
        assert!(with(plant).is_some(), "not caught: {what}");
    }
}

#[test]
fn releases_of_the_clock_are_those_before_the_end() {
    let task = TaskId::from_bits(0);
    let count = |first_ns, period_ns| {
        made_by_clock(&[Releases { task, first_ns, period_ns }], Duration::from_nanos(10))
    };
    assert_eq!([count(0, Some(5)), count(1, Some(5)), count(9, Some(1)), count(10, Some(1))], [2, 2, 1, 0]);
    assert_eq!([count(9, None), count(10, None)], [1, 0]);
}
