//! A body in Rust that panics: its own job fails, on a lane that goes on.

use red_core::{
    Caps, Config, Dag, Duration, Empty, Event, Instant, Node, Outcome, Scheduler, ShedReason, Timing, Wcet,
};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::timeline::{Host, Releases};
use std::sync::Arc;

type Small = Caps<1, 4, 8>;

struct Panics;

impl Handler for Panics {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        assert_ne!(work.job, 1, "this test wants this panic");
        Ok(())
    }
}

#[derive(Default)]
struct Log(Vec<(u64, Option<ShedReason>)>);

impl Host<Small> for Log {
    fn released(&mut self, _task: usize, _release: Instant, taken: bool) {
        assert!(taken);
    }

    fn ended(&mut self, outcome: &Outcome) {
        self.0.push((outcome.index, outcome.shed));
    }

    fn event(&mut self, _event: &Event) {}
}

#[test]
fn a_panic_fails_its_own_job_and_the_lane_goes_on() {
    let mut dag = Dag::<Small>::new();
    // So that a busy machine makes nothing of this hang.
    dag.add_node(Node::new(Wcet::from_millis(10_000))).expect("there is room");
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(Config::EDF.with_lanes(1));
    let task =
        scheduler.add_task(&dag, Timing::new(Duration::from_millis(20_000))).expect("a task of one node");
    let setup = Setup {
        scheduler,
        lanes: 1,
        mode: Mode::BestEffort,
        releases: vec![Releases { task, first_ns: 0, period_ns: Some(10_000_000) }],
        duration_ns: 45_000_000,
        drain_ns: 20_000_000_000,
        tape: None,
        handlers: Arc::new(|_lane| Box::new(Panics)),
        enclose: Arc::new(|main| main()),
    };
    let (log, report) =
        run(setup, Log::default(), |_control| {}, |_now| {}).expect("best effort needs no right");
    let jobs = [0, 1, 2, 3, 4].map(|job| (job, (job == 1).then_some(ShedReason::Fault)));
    assert_eq!(log.0, jobs);
    assert_eq!((report.failed, report.hung, report.lanes_lost), (1, 0, 0));
    let [panic] = &report.panics[..] else { panic!("one panic: {:?}", report.panics) };
    assert!(panic.job == 1 && panic.message.contains("this test wants this panic"), "{panic:?}");
}
