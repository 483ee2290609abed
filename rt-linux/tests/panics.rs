//! Panics of bodies are told in the report. Alone in its process, because the panic hook is the process's, and the
//! first run wraps the hook that it finds.

use std::panic;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use red_core::{
    Caps, Config, Dag, Event, Instant, JobId, Node, NodeId, Outcome, ReleaseError, Scheduler, Timing, Wcet,
};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::panics::BodyPanic;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};

type OneNode = Caps<1, 1, 8, 1, 1>;

/// What the hook was called for.
static PRINTED: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Silent;

impl Host<OneNode> for Silent {
    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {}
    fn ended(&mut self, _outcome: &Outcome) {}
    fn event(&mut self, _event: &Event) {}
}

struct Panics;

impl Handler for Panics {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        if work.job == 2 {
            // A thread of the body is not the body.
            assert!(thread::spawn(|| panic!("elsewhere")).join().is_err());
        }
        assert_ne!(work.job, 1, "the body's own");
        Ok(())
    }
}

#[test]
fn a_panic_is_told_in_the_report_and_not_by_the_hook() {
    panic::set_hook(Box::new(|info| {
        let said = info.payload_as_str().unwrap_or_default().to_owned();
        PRINTED.lock().unwrap_or_else(PoisonError::into_inner).push(said);
    }));
    let mut scheduler = Box::new(Scheduler::<OneNode>::new(Config::EDF));
    let mut dag = Dag::new();
    dag.add_node(Node::new(Wcet::from_millis(1_000))).expect("room for one node");
    let timing = Timing::new(red_core::Duration::from_secs(30));
    let task = scheduler.add_task(&dag, timing).expect("room for one task");
    let setup = Setup {
        scheduler,
        lanes: 1,
        streams: 0,
        mode: Mode::BestEffort,
        releases: vec![Releases { task, first_ns: 0, period_ns: Some(1_000_000) }],
        duration_ns: 4_000_000,
        drain_ns: 60_000_000_000,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(|_| Box::new(Panics)),
        enclose: Arc::new(|main| main()),
    };
    let (Silent, report) = run(setup, Silent, |_control| (), |_now| ()).expect("needs no rights");
    let after = thread::spawn(|| panic!("after the run")).join();
    let printed = PRINTED.lock().unwrap_or_else(PoisonError::into_inner).clone();

    assert!(after.is_err());
    assert_eq!(printed, ["elsewhere", "after the run"]);
    assert_eq!((report.hung, report.failed, report.lanes_lost), (0, 1, 0));
    let [BodyPanic { task: 0, node, job: 1, message }] = &report.panics[..] else {
        panic!("one panic of job 1: {:?}", report.panics)
    };
    assert_eq!(*node, NodeId::new(0));
    assert!(message.contains("the body's own") && message.contains(file!()), "{message}");
}
