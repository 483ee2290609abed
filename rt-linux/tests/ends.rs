//! How a run ends: what is released, run and counted when it is stopped and when its time is over.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread;
use std::time::Duration;

use nix::sys::signal::{Signal, raise};
use red_core::{Caps, Config, Dag, Event, Instant, Node, Outcome, Scheduler, TaskId, Timing, Wcet};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::report::RunReport;
use red_rt::runtime::{Control, Mode, Setup, run};
use red_rt::stop::StopSignals;
use red_rt::timeline::{Host, Releases};

type OneNode = Caps<1, 1, 64, 1, 1>;

/// Jobs in a run, one each millisecond.
const JOBS: usize = 15;
const PERIOD_NS: u64 = 1_000_000;
/// Never reached.
const FAR_NS: u64 = 60_000_000_000;
const LOOK: Duration = Duration::from_millis(1);

/// Signals are the process's, so there is one run at a time.
static ONE_RUN: Mutex<()> = Mutex::new(());

#[derive(Default)]
struct Counted {
    released: usize,
    ended: usize,
}

impl Host<OneNode> for Counted {
    fn released(&mut self, _task: usize, _release: Instant, _taken: bool) {
        self.released += 1;
    }

    fn ended(&mut self, _outcome: &Outcome) {
        self.ended += 1;
    }

    fn event(&mut self, _event: &Event) {}
}

/// What the lane does before its first turn, and for each job.
struct Does<B, W> {
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

/// One lane, one task of one node.
struct Plan<B, W> {
    wcet: Wcet,
    duration_ns: u64,
    drain_ns: u64,
    begin: B,
    body: W,
}

impl<B: Fn() + Send + Sync + Clone + 'static, W: Fn(&Work) + Send + Sync + Clone + 'static> Plan<B, W> {
    fn run(
        self,
        started: impl FnOnce(Arc<dyn Control>, TaskId),
        progress: impl FnMut(u64),
    ) -> (Counted, RunReport) {
        let mut scheduler = Box::new(Scheduler::<OneNode>::new(Config::EDF));
        let mut dag = Dag::new();
        dag.add_node(Node::new(self.wcet)).expect("room for one node");
        let timing = Timing::new(red_core::Duration::from_secs(30));
        let task = scheduler.add_task(&dag, timing).expect("room for one task");
        let (begin, body) = (self.begin, self.body);
        let setup = Setup {
            scheduler,
            lanes: 1,
            mode: Mode::BestEffort,
            releases: vec![Releases { task, first_ns: 0, period_ns: Some(PERIOD_NS) }],
            duration_ns: self.duration_ns,
            drain_ns: self.drain_ns,
            tape: None,
            handlers: Arc::new(move |_| Box::new(Does { begin: begin.clone(), body: body.clone() })),
            enclose: Arc::new(|main| main()),
        };
        run(setup, Counted::default(), |control| started(control, task), progress).expect("needs no rights")
    }
}

fn alone() -> impl Drop {
    ONE_RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Waits for another thread.
fn wait_for(is_there: &AtomicBool) {
    while !is_there.load(Ordering::Relaxed) {
        thread::sleep(LOOK);
    }
}

#[test]
fn a_lane_that_is_never_idle_stops_after_the_body_that_runs() {
    const STOPS: u64 = 3;
    static RUNNING: OnceLock<(Arc<dyn Control>, TaskId)> = OnceLock::new();
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
                while control.release(0, *task) {
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
    assert_eq!(report.stopped_by, Some("SIGTERM"));
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
    assert_eq!((host.released, report.stopped_by), (0, Some("SIGINT")));
    assert!(!is_over.load(Ordering::Relaxed), "no body ran");
    assert!(signals.requested().is_some(), "the holder outside knows it too");
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
