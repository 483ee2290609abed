//! *Claim.* After a stop every lane leaves, whether it sleeps, runs a body, is about to sleep or was just handed a unit,
//! also where a request comes at the last moment, and where the stop is asked for twice. A request that was accepted is
//! in the mailbox when the run has ended.
//!
//! *Threads.* One lane and who stops it; then two lanes; a producer and who ends the run.
//! *Bound.* None for two, but four preemptions where a request comes; few for three.
//! *Sources.* `rt-linux/src/waiting.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::thread;
use red_core::UnitId;
use red_loom_tests::Mailbox;
use red_loom_tests::atomics::AtomicBool;
use red_loom_tests::handler::Work;
use red_loom_tests::model::{explore, explore_within};
use red_loom_tests::sleeper::Sleeper;
use red_loom_tests::waiting::{Next, Waiting};
use std::sync::Arc;

struct Host {
    waiting: Waiting,
    mailbox: Mailbox<u32, 2>,
    /// Of the planted fault: a stop that is told to one lane.
    is_over: AtomicBool,
    locked: Mutex<Locked>,
}

/// What is reached under the scheduler's lock.
#[derive(Default)]
struct Locked {
    /// Units that were handed out, and those that were begun.
    units: u64,
    begun: u64,
}

impl Locked {
    /// The next unit.
    fn work(&mut self) -> Work {
        self.units += 1;
        Work { unit: UnitId::from_bits(self.units), ..Work::default() }
    }
}

impl Host {
    /// The last lane's first turn hands lane 0 a unit, and whoever takes the request runs one itself.
    fn turn(&self, hands: bool) -> Next {
        let mut locked = self.locked.lock().unwrap();
        if self.waiting.is_stopping() || self.is_over.load(loom::sync::atomic::Ordering::Acquire) {
            return Next::Leave;
        }
        if hands {
            self.waiting.seats[0].hand(&locked.work());
        }
        match self.mailbox.pop() {
            Some(_) => Next::Run(locked.work(), 0),
            None => Next::Idle,
        }
    }

    fn lane(&self, me: usize, hands: bool) {
        let mut sleeper = Sleeper::yielding();
        let mut next = self.turn(hands);
        loop {
            next = match next {
                Next::Run(..) => {
                    self.locked.lock().unwrap().begun += 1;
                    self.turn(false)
                }
                Next::Idle => self.waiting.wait(me, &mut sleeper, || self.turn(false)),
                Next::Stream => unreachable!("no lane has a stream"),
                Next::Leave => break,
            };
        }
    }
}

/// What happens beside a stop.
#[derive(Clone, Copy, Default)]
struct Scene {
    lanes: usize,
    /// The last lane hands lane 0 a unit.
    hands: bool,
    /// A request comes at the last moment.
    is_asked: bool,
    /// The stop is asked for twice.
    is_twice: bool,
    is_told_to_one: bool,
}

fn ends(scene: Scene) {
    let Scene { lanes, hands, is_asked, is_twice, is_told_to_one } = scene;
    let host = Arc::new(Host {
        waiting: Waiting::new(lanes, 0, 0),
        mailbox: Mailbox::new(),
        is_over: AtomicBool::new(false),
        locked: Mutex::default(),
    });
    let threads: Vec<_> = (0..lanes)
        .map(|me| {
            let host = host.clone();
            thread::spawn(move || host.lane(me, hands && me + 1 == lanes))
        })
        .collect();
    if is_asked {
        host.mailbox.claim().expect("nobody else posts").push(1).expect("there is room");
        host.waiting.knock();
    }
    if is_told_to_one {
        host.is_over.store(true, loom::sync::atomic::Ordering::Release);
        host.waiting.knock();
    } else {
        host.waiting.stop();
        if is_twice {
            host.waiting.stop();
        }
    }
    threads.into_iter().for_each(|lane| lane.join().unwrap());
    let locked = host.locked.lock().unwrap();
    assert!(locked.begun <= locked.units, "a unit was begun twice");
}

const ONE: Scene = Scene { lanes: 1, hands: false, is_asked: false, is_twice: false, is_told_to_one: false };
const TWO: Scene = Scene { lanes: 2, ..ONE };

#[test]
fn a_lane_leaves_in_every_state() {
    explore(2, || ends(Scene { hands: true, ..ONE }));
}

#[test]
fn a_lane_leaves_though_a_request_came() {
    explore_within(2, Some(4), || ends(Scene { is_asked: true, ..ONE }));
}

#[test]
fn a_lane_that_is_told_twice_leaves() {
    explore(2, || ends(Scene { is_twice: true, ..ONE }));
}

#[test]
fn two_lanes_leave_in_every_state() {
    explore(3, || ends(Scene { hands: true, ..TWO }));
}

#[test]
fn two_lanes_leave_though_a_request_came() {
    explore(3, || ends(Scene { is_asked: true, ..TWO }));
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_stop_that_is_told_to_one_lane_is_caught() {
    explore(3, || ends(Scene { is_told_to_one: true, ..TWO }));
}

/// A producer asks whether the run goes on, with its place in the mailbox in hand or before. Who ends the run waits for
/// the place and then looks into the mailbox for the last time; here as long as it takes, where the code gives up on a
/// thread that was killed with the place.
fn accepts_what_is_taken(has_place: bool) {
    let host = Arc::new((Waiting::new(1, 0, 0), Mailbox::<u32, 2>::new()));
    let producer = {
        let host = host.clone();
        thread::spawn(move || {
            let (waiting, mailbox) = &*host;
            let early = waiting.is_stopping();
            let Some(post) = mailbox.claim() else { return false };
            let is_over = if has_place { waiting.is_stopping() } else { early };
            !is_over && post.push(1).is_ok()
        })
    };
    let (waiting, mailbox) = &*host;
    waiting.stop();
    while mailbox.claim().is_none() {
        thread::yield_now();
    }
    let taken = mailbox.pop().is_some();
    assert_eq!(producer.join().unwrap(), taken, "accepted and lost");
}

#[test]
fn a_request_that_was_accepted_is_taken_at_the_end() {
    explore(2, || accepts_what_is_taken(true));
}

#[test]
#[should_panic(expected = "accepted and lost")]
fn a_producer_that_asks_without_its_place_is_caught() {
    explore(2, || accepts_what_is_taken(false));
}
