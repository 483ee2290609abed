//! *Claim.* An errand is run once and whole and comes back to its asker, or is never run and comes back; in either case
//! nothing of it runs after that. Its asker is woken whatever happens at the same time: lanes that go to sleep, leave or
//! have another turn, the end of the run, an errand before it.
//!
//! *Threads.* The asker and a lane, which is never idle or waits; then who ends the run, and two lanes.
//! *Bound.* None for an errand and a lane that is never idle; three preemptions for two errands; two for three threads,
//! three with `--deep`.
//! *Sources.* `rt-linux/src/errands.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::Mutex;
use loom::thread;
use red_loom_tests::errands::{Errands, Undone};
use red_loom_tests::model::{explore, explore_within};
use red_loom_tests::sleeper::Sleeper;
use red_loom_tests::waiting::{Next, Waiting};
use std::sync::Arc;

/// The number of every lane's thread.
const THREAD: u32 = 9;
/// Preemptions of two threads that sleep or come twice.
const BOUND: usize = 3;

struct Host {
    planted: Option<Planted>,
    waiting: Waiting,
    errands: Errands<usize>,
    /// How often each errand has run: the checker says when it does beside what the asker reads.
    results: [UnsafeCell<u32>; 2],
    /// The scheduler's lock.
    locked: Mutex<()>,
}

/// A fault of the host.
#[derive(Clone, Copy, PartialEq)]
enum Planted {
    /// A lane that does not ring.
    Silence,
    /// A lane that answers before it runs the errand.
    Haste,
    /// An end of the run that is told to lanes alone.
    Neglect,
    /// An asker that takes every thread for ended.
    Flight,
}

// SAFETY: results are the checker's cells: it says when one is reached by two at once.
unsafe impl Sync for Host {}
// SAFETY: they go with the host.
unsafe impl Send for Host {}

impl Host {
    fn new(lanes: usize, planted: Option<Planted>) -> Arc<Self> {
        let (waiting, errands) = (Waiting::new(lanes, 0, 0), Errands::default());
        let results = [UnsafeCell::new(0), UnsafeCell::new(0)];
        Arc::new(Self { planted, waiting, errands, results, locked: Mutex::new(()) })
    }

    fn turn(&self) -> Next {
        let locked = self.locked.lock().unwrap();
        if self.waiting.is_stopping() {
            return Next::Leave;
        }
        let errand = self.errands.take(THREAD);
        if let Some(errand) = errand {
            let run = || {
                // SAFETY: the checker says when somebody else is here.
                self.results[errand].with_mut(|result| unsafe { *result += 1 });
            };
            if self.planted == Some(Planted::Haste) {
                self.errands.answer(errand);
                run();
            } else {
                run();
                self.errands.answer(errand);
            }
        }
        drop(locked);
        if errand.is_some() && self.planted != Some(Planted::Silence) {
            self.errands.ring();
        }
        Next::Idle
    }

    /// From its first turn on.
    fn lane(&self, me: usize) {
        let mut sleeper = Sleeper::yielding();
        let mut next = self.turn();
        while let Next::Idle = next {
            next = self.waiting.wait(me, &mut sleeper, || self.turn());
        }
    }

    fn end(&self) {
        self.waiting.stop();
        if self.planted != Some(Planted::Neglect) {
            self.errands.close();
        }
    }

    /// Whether the errand was run, as its asker is told and sees.
    fn ask(&self, errand: usize) -> bool {
        let has_ended = |thread| {
            assert_eq!(thread, THREAD, "another one's");
            self.planted == Some(Planted::Flight)
        };
        let (back, times) = match self.errands.ask(errand, || self.waiting.knock(), has_ended) {
            Ok(back) => (back, 1),
            Err(Undone::Over(back)) => (back, 0),
            Err(Undone::Lost) if self.planted.is_some() => (errand, 0),
            Err(Undone::Lost) => panic!("an errand was lost"),
        };
        assert_eq!(back, errand, "another one's");
        // SAFETY: the checker says when somebody else is here.
        self.results[errand].with(|result| assert_eq!(unsafe { *result }, times, "run so many times"));
        times == 1
    }
}

/// So many lanes that run as long as the run goes on.
fn lanes(host: &Arc<Host>, lanes: usize) -> Vec<thread::JoinHandle<()>> {
    let lane = |me| {
        let host = host.clone();
        thread::spawn(move || host.lane(me))
    };
    (0..lanes).map(lane).collect()
}

/// Errands, while a lane that is never idle has two turns and then ends the run.
fn goes_to_a_busy_lane(errands: usize, planted: Option<Planted>) {
    let host = Host::new(1, planted);
    let lane = {
        let host = host.clone();
        thread::spawn(move || {
            host.turn();
            host.turn();
            host.end();
        })
    };
    let done: Vec<bool> = (0..errands).map(|errand| host.ask(errand)).collect();
    lane.join().unwrap();
    assert!(done.is_sorted_by(|first, second| first >= second), "run after the end");
}

/// Errands, while lanes wait for work; the run ends after them.
fn goes_to_lanes_that_wait(number: usize, errands: usize, planted: Option<Planted>) {
    let host = Host::new(number, planted);
    let lanes = lanes(&host, number);
    assert!((0..errands).all(|errand| host.ask(errand)), "the run goes on");
    host.end();
    lanes.into_iter().for_each(|lane| lane.join().unwrap());
}

/// An errand, while another thread ends the run.
fn meets_the_end(planted: Option<Planted>) {
    let host = Host::new(1, planted);
    let lanes = lanes(&host, 1);
    let asks = {
        let host = host.clone();
        thread::spawn(move || host.ask(0))
    };
    host.end();
    asks.join().unwrap();
    lanes.into_iter().for_each(|lane| lane.join().unwrap());
    assert!(!host.ask(1), "run after the end");
}

#[test]
fn a_lane_that_is_never_idle_runs_it_or_the_asker_takes_it_back() {
    explore(2, || goes_to_a_busy_lane(1, None));
}

#[test]
fn the_next_errand_goes_the_same_way() {
    explore_within(2, Some(BOUND), || goes_to_a_busy_lane(2, None));
}

#[test]
fn a_lane_that_waits_comes_for_it() {
    explore_within(2, Some(BOUND), || goes_to_lanes_that_wait(1, 2, None));
}

#[test]
fn one_of_two_lanes_that_wait_comes_for_it() {
    explore(3, || goes_to_lanes_that_wait(2, 1, None));
}

#[test]
fn the_end_of_the_run_leaves_no_asker_waiting() {
    explore(3, || meets_the_end(None));
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_lane_that_does_not_ring_is_caught() {
    explore(2, || goes_to_lanes_that_wait(1, 1, Some(Planted::Silence)));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_lane_that_answers_before_it_has_run_it_is_caught() {
    explore(2, || goes_to_a_busy_lane(1, Some(Planted::Haste)));
}

#[test]
#[should_panic(expected = "deadlock")]
fn an_end_that_askers_are_not_told_of_is_caught() {
    explore(3, || meets_the_end(Some(Planted::Neglect)));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn an_asker_that_leaves_while_its_errand_runs_is_caught() {
    explore(2, || goes_to_a_busy_lane(1, Some(Planted::Flight)));
}
