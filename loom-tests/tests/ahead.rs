//! *Claim.* Lemma 1 where units are dispatched ahead: on the device no sub-job starts before its predecessors ended, none
//! starts twice, none is forgotten, whichever lane hears of which end first; and the scheduler is left with nothing.
//!
//! *Threads.* Two lanes, each with a stream, one of which asks for the job.
//! *Bound.* Four preemptions with a fork, three with a diamond.
//! *Sources.* `sync/src/shared.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::atomic::{AtomicU32, Ordering};
use loom::thread;
use red_core::{
    Action, CompleteError, Config, Duration, Instant, LaneId, PoolId, Scheduler, TaskId, Timing, UnitId,
};
use red_loom_tests::bell::{Bell, Woken};
use red_loom_tests::ideal::Ideal;
use red_loom_tests::lanes::{Edges, LANES, Small, dag};
use red_loom_tests::model::explore_within;
use red_loom_tests::shared::{Request, SharedScheduler};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

const FORK: Edges = &[(0, 1), (0, 2)];
const DIAMOND: Edges = &[(0, 1), (0, 2), (1, 3), (2, 3)];

/// A unit as its stream has it.
#[derive(Clone, Debug)]
struct Given {
    unit: UnitId,
    /// Nodes on other streams that it starts after.
    after: Vec<usize>,
}

/// What lies under the scheduler's lock; none that the checker has to know.
#[derive(Debug, Default)]
struct Notes {
    inbox: [VecDeque<Given>; LANES],
    ended: usize,
    turns: u64,
}

struct Host {
    shared: SharedScheduler<Small, Ideal<Scheduler<Small>>, 1, 2>,
    task: TaskId,
    graph: Edges,
    notes: Mutex<Notes>,
    /// The device: what each node wrote, and its event.
    results: [UnsafeCell<u8>; 5],
    events: [AtomicU32; 5],
    bells: [Bell; LANES],
    /// Whether streams wait for what they are told to.
    waits: bool,
}

// SAFETY: results are the checker's cells: it says when one is reached by two at once.
unsafe impl Sync for Host {}
// SAFETY: they go with the host.
unsafe impl Send for Host {}

/// Units that were given ahead, over all executions: a model in which there is none says nothing.
static AHEAD: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);

impl Host {
    fn new(graph: Edges, waits: bool) -> Self {
        let mut scheduler = Scheduler::new(Config::REDRT.with_lanes(LANES as u8));
        assert!(scheduler.dispatch_ahead(PoolId::new(0)));
        let timing = Timing::new(Duration::from_secs(1));
        let task = scheduler.add_task(&dag(graph), timing).expect("room for one task");
        Self {
            shared: SharedScheduler::new(scheduler),
            task,
            graph,
            notes: Mutex::default(),
            results: std::array::from_fn(|_| UnsafeCell::new(0)),
            events: std::array::from_fn(|_| AtomicU32::new(0)),
            bells: Default::default(),
            waits,
        }
    }

    fn request(&self) {
        let post = self.shared.producer(0).expect("nobody else posts");
        post.push(Request { task: self.task, at: Instant::ZERO, capture: None }).expect("there is room");
    }

    fn lane(&self, me: usize) {
        let (mut queue, mut done) = (VecDeque::new(), None);
        loop {
            let is_over = self.turn(me, done.take(), &mut queue);
            match queue.front() {
                Some(oldest) if self.has_come(oldest) => {
                    self.run(oldest.unit.node().index());
                    done = queue.pop_front().map(|given: Given| given.unit);
                    self.bells[1 - me].ring();
                }
                None if is_over => return,
                _ => assert_eq!(self.bells[me].wait(None, 0), Woken::Rung),
            }
        }
    }

    /// Whether the stream has come to this unit: what it waits for has ended.
    fn has_come(&self, given: &Given) -> bool {
        // Acquire: what a kernel wrote is seen by one that waited for its event.
        !self.waits || given.after.iter().all(|node| self.events[*node].load(Ordering::Acquire) == 1)
    }

    /// The device runs a node: it reads what its predecessors wrote, and writes its own, once.
    fn run(&self, node: usize) {
        for (from, _) in self.graph.iter().filter(|(_, to)| usize::from(*to) == node) {
            // SAFETY: by Lemma 1 the predecessor has ended; the checker says if not.
            self.results[usize::from(*from)]
                .with(|value| assert_eq!(unsafe { *value }, 1, "started before a predecessor ended"));
        }
        // SAFETY: nobody else runs this node; the checker says if so.
        let before = self.results[node].with_mut(|value| unsafe { value.replace(1) });
        assert_eq!(before, 0, "started twice");
        self.events[node].store(1, Ordering::Release);
    }

    /// Reports, and takes what lies there. Whether the run is over.
    fn turn(&self, me: usize, done: Option<UnitId>, queue: &mut VecDeque<Given>) -> bool {
        let (is_over, has_news) = self.shared.with(|scheduler, requests| {
            let mut notes = self.notes.lock().unwrap();
            notes.turns += 1;
            let now = Instant::from_nanos(notes.turns);
            if let Some(unit) = done {
                // What ran after it on the other stream may have said so before.
                let answer = scheduler.complete(unit, now);
                assert!(matches!(answer, Ok(()) | Err(CompleteError::Stale)), "{answer:?}");
            }
            while let Some(request) = requests.next() {
                scheduler.release_at(request.task, request.at, request.capture, now).expect("there is room");
            }
            while let Some(action) = scheduler.poll_on(LaneId::new(me as u8), now) {
                match action {
                    Action::Dispatch(given) | Action::Ahead(given) => {
                        let after = scheduler.waits_for(given.unit).map(|unit| unit.node().index()).collect();
                        notes.inbox[given.lane.index()].push_back(Given { unit: given.unit, after });
                        let ahead = u32::from(matches!(action, Action::Ahead(_)));
                        AHEAD.fetch_add(ahead, std::sync::atomic::Ordering::Relaxed);
                    }
                    Action::Ended(outcome) => {
                        assert_eq!(outcome.shed, None);
                        notes.ended += 1;
                    }
                    _ => {}
                }
            }
            queue.append(&mut notes.inbox[me]);
            (notes.ended == 1, notes.ended == 1 || !notes.inbox[1 - me].is_empty())
        });
        if has_news {
            self.bells[1 - me].ring();
        }
        is_over
    }

    fn check(&self) {
        self.shared.with(|scheduler, _| {
            assert_eq!(
                (scheduler.jobs_in_flight(), scheduler.running_units(), scheduler.ready_sub_jobs()),
                (0, 0, 0)
            );
            let lanes = (0..LANES).map(|lane| LaneId::new(lane as u8));
            assert!(lanes.into_iter().all(|lane| scheduler.retire_lane(lane)), "nothing waits on a lane");
        });
    }
}

fn two_lanes(graph: Edges, waits: bool) {
    let host = Arc::new(Host::new(graph, waits));
    let other = {
        let host = host.clone();
        thread::spawn(move || host.lane(1))
    };
    host.request();
    host.lane(0);
    other.join().unwrap();
    host.check();
}

#[test]
fn two_streams_run_a_fork() {
    explore_within(2, Some(4), || two_lanes(FORK, true));
    assert!(AHEAD.load(std::sync::atomic::Ordering::Relaxed) > 0, "nothing was dispatched ahead");
}

#[test]
fn two_streams_run_a_diamond() {
    explore_within(2, Some(3), || two_lanes(DIAMOND, true));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_stream_that_does_not_wait_is_caught() {
    explore_within(2, Some(3), || two_lanes(FORK, false));
}
