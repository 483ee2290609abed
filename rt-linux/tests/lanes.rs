//! Lanes as a host starts them, best effort: nothing that was handed out is lost or run twice.

use std::fs;
use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::thread;
use std::time::{self, Duration};

use red_core::{
    Caps, Config, Dag, Event, Instant, JobId, Node, Outcome, PoolId, ReleaseError, Scheduler, TaskId, Timing,
    Wcet,
};
use red_rt::control::Control;
use red_rt::handler::{Failed, Handler, Work};
use red_rt::report::RunReport;
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};

/// Reaching it means that something was lost, on the slowest machine.
const FAR: Duration = Duration::from_secs(20);
/// Nodes of the task, by turns in the pools of two lanes.
const NODES: usize = 6;

type TwoLanes = Caps<1, NODES, 8, 2, 2>;

/// A run takes the signal handlers of the process, so there is one at a time.
static ONE_RUN: Mutex<()> = Mutex::new(());

/// Jobs and nodes in the order in which they ran.
type Ran = Arc<Mutex<Vec<(u64, usize)>>>;

/// Notes each execution, and then does what is wanted of the body.
struct Noted {
    ran: Ran,
    body: fn(&Work),
}

impl Handler for Noted {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        self.ran.lock().map_err(|_| Failed)?.push((work.job, work.node.index()));
        (self.body)(work);
        Ok(())
    }
}

struct Silent;

impl Host<TwoLanes> for Silent {
    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {}
    fn ended(&mut self, _outcome: &Outcome) {}
    fn event(&mut self, _event: &Event) {}
}

fn run_chain(
    period: Option<Duration>,
    duration: Duration,
    body: fn(&Work),
    started: impl FnOnce(Arc<dyn Control<TwoLanes>>, TaskId),
) -> (RunReport, Ran) {
    let _alone = ONE_RUN.lock().unwrap_or_else(PoisonError::into_inner);
    let mut scheduler = Box::new(Scheduler::<TwoLanes>::new(Config::REDRT));
    scheduler.add_pool(1, None).expect("room for two pools");
    let mut dag = Dag::new();
    let nodes: Vec<_> = (0..NODES)
        .map(|n| dag.add_node(Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(n as u8 % 2))))
        .map(|id| id.expect("room for the nodes"))
        .collect();
    for edge in nodes.windows(2) {
        dag.add_edge(edge[0], edge[1]).expect("a chain");
    }
    let timing = Timing::new(red_core::Duration::from_secs(5));
    let task = scheduler.add_task(&dag, timing).expect("room for one task");
    // Room for all, so that no body allocates.
    let ran: Ran = Arc::new(Mutex::new(Vec::with_capacity(1 << 20)));
    let notes = ran.clone();
    let period_ns = period.map(|period| period.as_nanos() as u64);
    let setup = Setup {
        scheduler,
        lanes: 2,
        streams: 0,
        mode: Mode::BestEffort,
        releases: period_ns.map(|p| Releases { task, first_ns: p, period_ns }).into_iter().collect(),
        duration_ns: duration.as_nanos() as u64,
        drain_ns: FAR.as_nanos() as u64,
        stop: StopBy::Signals,
        tape: None,
        handlers: Arc::new(move |_| -> Box<dyn Handler> { Box::new(Noted { ran: notes.clone(), body }) }),
        enclose: Arc::new(|main: Box<dyn FnOnce() + Send>| {
            let library = thread::Builder::new().name("library".into()).spawn(main);
            library.expect("a thread").join().expect("a lane does not panic");
        }),
    };
    let (_, report) = run(setup, Silent, |control| started(control, task), |_| ()).expect("needs no rights");
    (report, ran)
}

/// Asserts that no node of a job ran twice, nor before the one ahead of it; returns the jobs that ran to the end and
/// how many did not.
fn finished(ran: &Ran) -> (Vec<u64>, usize) {
    let mut next = std::collections::BTreeMap::new();
    for &(job, node) in &*ran.lock().expect("nobody panicked") {
        let expected = next.entry(job).or_insert(0);
        assert_eq!(node, *expected, "job {job}");
        *expected += 1;
    }
    let begun = next.len();
    let ended: Vec<_> = next.into_iter().filter(|(_, ran)| *ran == NODES).map(|(job, _)| job).collect();
    let left = begun - ended.len();
    (ended, left)
}

#[test]
fn every_node_of_a_periodic_chain_runs_once_and_in_order_on_a_thread_of_its_lanes_name() {
    fn body(work: &Work) {
        let name = fs::read_to_string("/proc/thread-self/comm").expect("Linux has it");
        // The first pool has the first lane.
        let (lane, pool) = (work.lane().index(), work.node.index() % 2);
        assert_eq!((name.trim_end(), work.pool.index(), lane), (&*format!("red-lane-{lane}"), pool, pool));
    }
    let (report, ran) =
        run_chain(Some(Duration::from_millis(2)), Duration::from_millis(300), body, |_, _| ());
    let (ended, left) = finished(&ran);
    assert!(ended.len() > 10 && left == 0, "{left} jobs beside {ended:?}");
    assert_eq!((report.hung, report.failed), (0, 0));
}

#[test]
fn no_release_from_outside_is_lost_between_work_and_sleep() {
    let (ended, is_ended) = mpsc::channel();
    static ENDED: Mutex<Option<mpsc::Sender<()>>> = Mutex::new(None);
    *ENDED.lock().expect("nobody panicked") = Some(ended);
    fn body(work: &Work) {
        if work.node.index() + 1 == NODES
            && let Some(ended) = &*ENDED.lock().expect("nobody panicked")
        {
            ended.send(()).expect("somebody waits");
        }
    }
    const DURATION: Duration = Duration::from_secs(1);
    let mut outside = None;
    let (_, ran) = run_chain(None, DURATION, body, |control, task| {
        // The next release comes while the lanes go to sleep after the last one.
        outside = Some(thread::spawn(move || {
            // Well before the end, after which a request is not applied any more.
            let start = time::Instant::now();
            while start.elapsed() < DURATION / 2 {
                if control.release(task, None).is_err() || is_ended.recv_timeout(FAR).is_err() {
                    return false;
                }
            }
            true
        }));
    });
    assert!(outside.expect("the run started").join().expect("it only releases"), "a release was lost");
    let (ended, left) = finished(&ran);
    assert!(ended.len() > 10 && left == 0, "{left} jobs beside {ended:?}");
}

#[test]
fn a_spare_runs_what_is_handed_to_it_and_nothing_of_the_thread_that_hung() {
    fn body(work: &Work) {
        // The bound is ten times the WCET and 100 ms.
        if work.job == 3 && work.node.index() == 3 {
            thread::sleep(Duration::from_millis(400));
        }
    }
    let (report, ran) =
        run_chain(Some(Duration::from_millis(10)), Duration::from_millis(900), body, |_, _| ());
    assert_eq!((report.hung, report.lanes_lost, report.failed), (1, 0, 0));
    let (finished, left) = finished(&ran);
    assert_eq!(left, 1, "only the job that hung is given up");
    let all = ran.lock().expect("nobody panicked").len();
    assert_eq!(
        report.dispatch_ns.len(),
        all as u64,
        "the figures of every thread, also of the one that hung"
    );
    assert!(!finished.contains(&3), "the job was given up");
    assert!(finished.contains(&2));
    assert!(finished.iter().any(|job| *job > 15), "the spare goes on: {finished:?}");
}
