//! Lanes under stress, best effort, for who watches from outside: a clock that releases, two threads that release
//! besides and two that have errands run, edits all the while, some runs that are stopped in the middle, and again. Every other run is recorded, by the
//! thread that writes logs.
//!
//! `RED_STRESS_ROUNDS=400` runs more often than the default.

use std::env;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;

use nix::sys::signal::{Signal, raise};
use red_core::{
    Bytes, Caps, CommitError, Config, Dag, Duration, Event, Frame, Instant, JobId, Node, NodeId, Outcome,
    PoolId, ReleaseError, Scheduler, TaskId, Timing, Wcet,
};
use red_record::{Header, Recorder, Writer};
use red_rt::control::{AskError, Control, Errand};
use red_rt::handler::{Failed, Handler, Work};
use red_rt::runtime::{Mode, Setup, run};
use red_rt::stop::StopBy;
use red_rt::timeline::{Host, Releases};

const LANES: usize = 2;
const ROUNDS: u64 = 10;
const DURATION_NS: u64 = 50_000_000;
const DRAIN_NS: u64 = 20_000_000_000;
/// Between two edits.
const EDIT_NS: u64 = 3_000_000;

type Small = Caps<2, 8, 8, LANES, 2, 1, 256>;

/// Executions that run now, by lane, and all that ended.
#[derive(Default)]
struct Seen {
    busy: [AtomicBool; LANES],
    ran: AtomicU64,
}

struct Body {
    seen: Arc<Seen>,
    lane: usize,
}

impl Handler for Body {
    fn run(&mut self, work: &Work) -> Result<(), Failed> {
        // Acquire and Release: each sees that the execution before it on this lane ended, whoever ran it.
        let busy = &self.seen.busy[self.lane];
        assert!(!busy.swap(true, Ordering::Acquire), "two bodies on one lane");
        self.seen.ran.fetch_add(1, Ordering::Relaxed);
        busy.store(false, Ordering::Release);
        // Now and then a job fails.
        if work.job % 16 == 5 && work.node.index() == 1 { Err(Failed) } else { Ok(()) }
    }
}

/// Adds a node and takes it away again, as long as the run goes on.
struct Editor {
    task: TaskId,
    added: Option<NodeId>,
    next_ns: u64,
    edits: u64,
    ended: u64,
}

impl Editor {
    fn change(&mut self, scheduler: &mut Scheduler<Small>, now: Instant) -> Result<(), CommitError> {
        let mut dag = scheduler.edit(self.task).ok_or(CommitError::UnknownTask)?;
        let added = match self.added {
            Some(node) => {
                dag.remove_node(node);
                None
            }
            None => dag.add_node(Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(1))).ok(),
        };
        let _bound = scheduler.commit(&dag, now)?;
        self.added = added;
        self.edits += 1;
        Ok(())
    }
}

impl Host<Small> for Editor {
    fn next_at(&self) -> Option<u64> {
        Some(self.next_ns)
    }

    fn due(&mut self, scheduler: &mut Recorder<'_, Small>, now: Instant) {
        if now.as_nanos() >= self.next_ns {
            self.next_ns = now.as_nanos() + EDIT_NS;
            // Where the version before the last still has jobs, the next time.
            let _busy = scheduler.edit(0, now, |scheduler| self.change(scheduler, now));
        }
    }

    fn released(&mut self, _task: usize, _release: Instant, _taken: Result<JobId, ReleaseError>) {}

    fn ended(&mut self, _outcome: &Outcome) {
        self.ended += 1;
    }

    fn event(&mut self, _event: &Event) {}
}

/// An encoder with two decoders in one pool, and a node in another before and after them.
fn graph() -> Dag<Small> {
    let mut dag = Dag::new();
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let mut add = |node: Node| dag.add_node(node).expect("few nodes");
    let camera = add(Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(1)));
    let encoder = add(Node::shared_encoder(Wcet::from_millis(2), frame).memory(Bytes(2)));
    let decoders = [0; 2].map(|_| add(Node::decoder(Wcet::from_millis(1)).memory(Bytes(1))));
    let control = add(Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(1)));
    dag.add_edge(camera, encoder).expect("no cycle");
    for decoder in decoders {
        dag.add_edge(encoder, decoder).expect("no cycle");
        dag.add_edge(decoder, control).expect("no cycle");
    }
    dag
}

fn header() -> Header {
    Header {
        program: "stress".to_owned(),
        capacities: Header::capacities_of::<Small>(),
        policy: "redrt".to_owned(),
        duration_ns: DURATION_NS,
        realtime: false,
        file: "none".to_owned(),
        format: "toml".to_owned(),
        workload: String::new(),
        config: None,
    }
}

/// One run; how many bodies ran, jobs ended, edits were made, inputs were recorded and errands were run.
fn round(stops: bool, is_recorded: bool) -> [u64; 5] {
    let mut scheduler = Box::new(Scheduler::<Small>::new(Config::REDRT.with_memory(Bytes(16))));
    scheduler.add_pool(1, None).expect("room for two pools");
    let timing = Timing::new(Duration::from_secs(5));
    let [by_clock, from_outside] = [0; 2].map(|_| scheduler.add_task(&graph(), timing).expect("room"));
    let seen = Arc::new(Seen::default());
    let bodies = seen.clone();
    let (writer, tape) = is_recorded
        .then(|| Writer::start(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("stress.redlog"), &header()))
        .transpose()
        .expect("the folder for tests takes files")
        .unzip();
    let setup = Setup {
        scheduler,
        lanes: LANES,
        streams: 0,
        mode: Mode::BestEffort,
        releases: vec![Releases { task: by_clock, first_ns: 0, period_ns: Some(2_000_000) }],
        duration_ns: DURATION_NS,
        drain_ns: DRAIN_NS,
        stop: StopBy::Signals,
        tape,
        handlers: Arc::new(move |lane| -> Box<dyn Handler> { Box::new(Body { seen: bodies.clone(), lane }) }),
        enclose: Arc::new(|main: Box<dyn FnOnce() + Send>| main()),
    };
    let editor = Editor { task: by_clock, added: None, next_ns: EDIT_NS, edits: 0, ended: 0 };
    let done = Arc::new(AtomicBool::new(false));
    let mut outside = Vec::new();
    let producers = |control: Arc<dyn Control<Small>>| {
        let asker = || {
            let control = control.clone();
            thread::spawn(move || {
                let looks = Arc::new(AtomicU64::new(0));
                let seen = looks.clone();
                let mut errand: Errand<Small> = Box::new(move |scheduler, _| {
                    let before = seen.load(Ordering::Relaxed);
                    seen.store(before + u64::from(scheduler.lanes() == LANES), Ordering::Relaxed);
                });
                let mut asked = 0;
                loop {
                    match control.ask(errand) {
                        Ok(back) => errand = back,
                        Err(error) => {
                            assert_eq!(error, AskError::Over);
                            return asked;
                        }
                    }
                    asked += 1;
                    assert_eq!(looks.load(Ordering::Relaxed), asked, "an errand was lost, or ran twice");
                }
            })
        };
        for _ in 0..2 {
            let (control, done) = (control.clone(), done.clone());
            outside.push(thread::spawn(move || {
                while !done.load(Ordering::Relaxed) {
                    // A box that is full says so.
                    let _full = control.release(from_outside, None);
                    thread::yield_now();
                }
                0
            }));
            outside.push(asker());
        }
    };
    let stop = |_| {
        if stops {
            raise(Signal::SIGTERM).expect("to this thread");
        }
    };
    let (host, report) = run(setup, editor, producers, stop).expect("needs no rights");
    done.store(true, Ordering::Relaxed);
    let errands: u64 = outside.into_iter().map(|thread| thread.join().expect("it only asks")).sum();
    assert_eq!((report.hung, report.lanes_lost, report.events_dropped), (0, 0, 0), "{:?}", report.panics);
    assert!(report.panics.is_empty(), "{:?}", report.panics);
    let (log, failed) = writer.map(Writer::finish).unwrap_or_default();
    assert!(failed.is_none() && log.dropped == 0, "{log:?}, {failed:?}");
    [seen.ran.load(Ordering::Relaxed), host.ended, host.edits, log.entries, errands]
}

#[test]
fn releases_edits_failures_and_stops_leave_lanes_whole() {
    let rounds = env::var("RED_STRESS_ROUNDS").ok();
    let rounds =
        rounds.map_or(ROUNDS, |asked| asked.parse().expect("RED_STRESS_ROUNDS is a number of rounds"));
    let mut all = [0; 5];
    for number in 0..rounds {
        let seen = round(number % 3 == 2, number % 2 == 0);
        all.iter_mut().zip(seen).for_each(|(sum, more)| *sum += more);
    }
    let [ran, ended, edits, inputs, errands] = all;
    println!(
        "{rounds} rounds: {ran} bodies, {ended} jobs ended, {edits} edits, {inputs} inputs recorded, {errands} errands"
    );
    assert!(!all.contains(&0));
}
