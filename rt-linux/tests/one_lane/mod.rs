//! Runs of one lane with one task of one node.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
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

/// Room for another pool of one lane, which a test may add.
pub(crate) type OneNode = Caps<1, 1, 64, 2, 2>;

/// Between two releases.
pub(crate) const PERIOD_NS: u64 = 1_000_000;
/// Never reached.
pub(crate) const FAR_NS: u64 = 60_000_000_000;
const LOOK: Duration = Duration::from_millis(1);

/// Signals are the process's, so there is one run at a time.
static ONE_RUN: Mutex<()> = Mutex::new(());

pub(crate) fn alone() -> impl Drop {
    ONE_RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for another thread, which comes in time if at all.
pub(crate) fn wait_for(is_there: &AtomicBool) {
    let begin = Clock::now();
    while !is_there.load(Ordering::Relaxed) {
        assert!(begin.elapsed() < Duration::from_nanos(FAR_NS), "nobody comes");
        thread::sleep(LOOK);
    }
}

/// What the host is told of jobs.
#[derive(Default)]
pub(crate) struct Counted {
    pub(crate) released: usize,
    pub(crate) ended: usize,
}

impl Host<OneNode> for Counted {
    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {
        self.released += 1;
    }

    fn ended(&mut self, _outcome: &Outcome) {
        self.ended += 1;
    }

    fn event(&mut self, _event: &Event) {}
}

/// What the lane does before its first turn, and for each job.
pub(crate) struct Does<B, W> {
    begin: B,
    body: W,
}

impl<B: Fn() + Send, W: Fn(&Work) + Send> Handler for Does<B, W> {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        (self.body)(work);
        Ok(())
    }

    fn begin(&mut self, _origin_ns: u64) {
        (self.begin)();
    }
}

/// A run, with a release every millisecond.
pub(crate) struct Plan<B, W> {
    pub(crate) wcet: Wcet,
    pub(crate) duration_ns: u64,
    pub(crate) drain_ns: u64,
    pub(crate) begin: B,
    pub(crate) body: W,
}

impl<B, W> Plan<B, W>
where
    B: Fn() + Send + Sync + Clone + 'static,
    W: Fn(&Work) + Send + Sync + Clone + 'static,
{
    pub(crate) fn run(
        self,
        started: impl FnOnce(Arc<dyn Control<OneNode>>, TaskId),
        progress: impl FnMut(u64),
    ) -> (Counted, RunReport) {
        let (setup, task) = self.setup();
        run(setup, Counted::default(), |control| started(control, task), progress).expect("needs no rights")
    }

    pub(crate) fn setup(self) -> (Setup<OneNode>, TaskId) {
        let mut scheduler = Box::new(Scheduler::<OneNode>::new(Config::EDF));
        let mut dag = Dag::new();
        dag.add_node(Node::new(self.wcet)).expect("room for one node");
        let timing = Timing::new(red_core::Duration::from_secs(30));
        let task = scheduler.add_task(&dag, timing).expect("room for one task");
        let (begin, body) = (self.begin, self.body);
        let setup = Setup {
            scheduler,
            lanes: 1,
            streams: 0,
            mode: Mode::BestEffort,
            releases: vec![Releases { task, first_ns: 0, period_ns: Some(PERIOD_NS) }],
            duration_ns: self.duration_ns,
            drain_ns: self.drain_ns,
            stop: StopBy::Signals,
            tape: None,
            handlers: Arc::new(move |_| Box::new(Does { begin: begin.clone(), body: body.clone() })),
            enclose: Arc::new(|main| main()),
        };
        (setup, task)
    }
}
