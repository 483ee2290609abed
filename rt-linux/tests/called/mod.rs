//! Runs that go on, on a thread of their own, until their caller stops them.

use std::sync::{Arc, mpsc};
use std::thread;
use std::time::{Duration, Instant as Clock};

use red_core::{
    Caps, Config, Dag, Event, Instant, JobId, Node, Outcome, ReleaseError, Scheduler, TaskId, Timing, Wcet,
};
use red_rt::control::Control;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::report::RunReport;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};

/// Reaching it means that something was lost, on the slowest machine.
pub(crate) const FAR: Duration = Duration::from_secs(30);

pub(crate) type Small = Caps<2, 8, 16, 2, 1>;
pub(crate) type Running = (Arc<dyn Control<Small>>, TaskId);

/// What the host is told of jobs.
#[derive(Default)]
pub(crate) struct Counted {
    released: usize,
    ended: usize,
}

impl Host<Small> for Counted {
    fn released(&mut self, _task: usize, _release: Instant, taken: Result<JobId, ReleaseError>) {
        self.released += usize::from(taken.is_ok());
    }

    fn ended(&mut self, _outcome: &Outcome) {
        self.ended += 1;
    }

    fn event(&mut self, _event: &Event) {}
}

struct Bodies<B>(B);

impl<B: Fn(&Work) + Send> Handler for Bodies<B> {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        (self.0)(work);
        Ok(())
    }
}

/// A task of one node that is released every two milliseconds, or from outside only.
pub(crate) fn setup(
    lanes: u8,
    by_clock: bool,
    body: impl Fn(&Work) + Send + Sync + Clone + 'static,
) -> (Setup<Small>, TaskId) {
    let mut scheduler = Box::new(Scheduler::<Small>::new(Config::EDF.with_lanes(lanes)));
    let mut dag = Dag::new();
    dag.add_node(Node::new(Wcet::from_millis(5))).expect("room for one node");
    let task = scheduler.add_task(&dag, Timing::new(red_core::Duration::from_secs(30))).expect("room for it");
    let releases = by_clock.then_some(Releases { task, first_ns: 0, period_ns: Some(2_000_000) });
    let setup = Setup {
        scheduler,
        lanes: lanes.into(),
        streams: 0,
        mode: Mode::BestEffort,
        releases: releases.into_iter().collect(),
        duration_ns: 1 << 62,
        drain_ns: 0,
        stop: StopBy::Caller,
        tape: None,
        handlers: Arc::new(move |_| Box::new(Bodies(body.clone()))),
        enclose: Arc::new(|main| main()),
    };
    (setup, task)
}

/// A run that has started.
pub(crate) struct Run {
    pub(crate) control: Arc<dyn Control<Small>>,
    pub(crate) task: TaskId,
    ended: mpsc::Receiver<(Counted, RunReport)>,
}

impl Run {
    pub(crate) fn start(
        (setup, task): (Setup<Small>, TaskId),
        started: impl FnOnce(Running) + Send + 'static,
    ) -> Self {
        let (told, running) = mpsc::channel();
        let (ends, ended) = mpsc::channel();
        thread::spawn(move || {
            let started = |control: Arc<dyn Control<Small>>| {
                started((control.clone(), task));
                told.send(control).expect("somebody waits");
            };
            let ended = run(setup, Counted::default(), started, |_| ()).expect("needs no rights");
            ends.send(ended).expect("somebody waits");
        });
        Self { control: running.recv_timeout(FAR).expect("it starts"), task, ended }
    }

    /// Waits for its end. How many jobs the host was told were released, and ended.
    pub(crate) fn ended(&self) -> ([usize; 2], RunReport) {
        let (host, report) = self.ended.recv_timeout(FAR).expect("it ends");
        ([host.released, host.ended], report)
    }

    pub(crate) fn stop(&self) -> RunReport {
        self.control.stop();
        self.ended().1
    }
}

pub(crate) fn wait_for(what: impl Fn() -> bool) {
    let begin = Clock::now();
    while !what() {
        assert!(begin.elapsed() < FAR, "it does not come");
        thread::sleep(Duration::from_millis(1));
    }
}
