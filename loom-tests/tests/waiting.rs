//! *Claim.* While a lane waits, somebody takes a posted request, whatever the lane that was rung for it does instead,
//! and somebody keeps the time, also when the next instant comes nearer, and where a waiting lane's thread dies.
//!
//! *Threads.* One lane and who posts or moves the clock; then two lanes, one of which is handed a body that does not
//! end before the other lane did what is to do, or dies and is found by who looks after it.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`, and
//! where a busy lane brings an instant nearer.
//! *Sources.* `rt-linux/src/waiting.rs`, `rt-linux/src/seat.rs`, `rt-linux/src/bell.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::thread;
use red_core::UnitId;
use red_loom_tests::Mailbox;
use red_loom_tests::bell::{Bell, Woken};
use red_loom_tests::handler::Work;
use red_loom_tests::kernel;
use red_loom_tests::model::{explore, explore_within};
use red_loom_tests::sleeper::Sleeper;
use red_loom_tests::waiting::{Next, Waiting};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

/// When the clock brings something; it was planned for later before.
const SOON: u64 = 1_000;
const LATER: u64 = 1_000_000;

/// What is to do, and a protocol step that a planted fault leaves out.
#[derive(Clone, Copy)]
struct Scene {
    lanes: usize,
    /// A request from outside; otherwise an instant of the clock, that a lane brings nearer.
    is_request: bool,
    /// The last lane hands the first one a body.
    hands: bool,
    /// It is a third lane that does, and that brings the instant nearer; afterwards it is busy.
    is_begun_by_a_third: bool,
    /// The first lane's thread dies when it is to take a turn.
    dies: bool,
    /// Who finds it dead does nothing.
    without_burial: bool,
    /// Nobody knocks.
    without_knock: bool,
    /// Nobody rings the keeper.
    without_ring: bool,
}

/// The end of a thread that does not leave.
struct Dead;

struct Host {
    scene: Scene,
    waiting: Waiting,
    mailbox: Mailbox<u32, 2>,
    locked: Mutex<Locked>,
    /// What is to do was done.
    done: Bell,
}

/// What is reached under the scheduler's lock.
#[derive(Default)]
struct Locked {
    has_begun: bool,
    is_done: bool,
}

impl Host {
    fn new(scene: Scene) -> Arc<Self> {
        let waiting = Waiting::new(scene.lanes, 0, 0);
        waiting.plan(if scene.is_request { u64::MAX } else { LATER }, 0);
        let locked = Mutex::new(Locked::default());
        Arc::new(Self { scene, waiting, mailbox: Mailbox::new(), locked, done: Bell::new() })
    }

    /// The last lane's first turn hands lane 0 a unit and brings the next instant nearer; the turn that finds the
    /// request or the instant ends the run.
    fn turn(&self, me: usize) -> Next {
        let mut locked = self.locked.lock().unwrap();
        if self.waiting.is_stopping() {
            return Next::Leave;
        }
        let begins = me + 1 == self.scene.lanes && !locked.has_begun && !self.scene.is_begun_by_a_third;
        let is_sooner = begins && self.begin(&mut locked);
        let finds = if self.scene.is_request {
            self.mailbox.pop().is_some()
        } else {
            locked.has_begun && self.waiting.now() >= SOON
        };
        if finds {
            // An instant that was dealt with is not waited for again.
            self.waiting.plan(u64::MAX, 0);
        }
        let ends = finds && !locked.is_done;
        locked.is_done |= finds;
        drop(locked);
        if is_sooner && !self.scene.without_ring {
            self.waiting.ring_keeper(me);
        }
        if ends {
            self.done.ring();
            self.waiting.stop();
            return Next::Leave;
        }
        Next::Idle
    }

    /// What the turn does that is first. Whether the next instant came nearer.
    fn begin(&self, locked: &mut Locked) -> bool {
        locked.has_begun = true;
        if self.scene.hands {
            self.waiting.seats[0].hand(&Work { unit: UnitId::from_bits(1), ..Work::default() });
        }
        !self.scene.is_request && self.waiting.plan(SOON, 0)
    }

    /// A lane from its first turn to its last.
    fn lane(&self, me: usize) {
        let mut sleeper = Sleeper::yielding();
        let mut next = self.turn(me);
        loop {
            next = match next {
                Next::Run(..) => {
                    // The body.
                    assert_eq!(self.done.wait(None, 0), Woken::Rung);
                    self.turn(me)
                }
                Next::Idle => self.waiting.wait(me, &mut sleeper, || {
                    if self.scene.dies && me == 0 {
                        resume_unwind(Box::new(Dead));
                    }
                    self.turn(me)
                }),
                Next::Stream => unreachable!("no lane has a stream"),
                Next::Leave => break,
            };
        }
    }
}

/// Runs the scene: every thread ends, or the checker finds that nobody goes on.
fn play(scene: Scene) {
    let host = Host::new(scene);
    let lanes: Vec<_> = (0..scene.lanes)
        .map(|me| {
            let host = host.clone();
            thread::spawn(move || match catch_unwind(AssertUnwindSafe(|| host.lane(me))) {
                Err(panic) if !panic.is::<Dead>() => resume_unwind(panic),
                ended => ended.is_err(),
            })
        })
        .collect();
    if scene.is_request {
        host.mailbox.claim().expect("nobody else posts").push(1).expect("there is room");
        if !scene.without_knock {
            host.waiting.knock();
        }
    } else {
        if scene.is_begun_by_a_third {
            let mut locked = host.locked.lock().unwrap();
            let is_sooner = host.begin(&mut locked);
            drop(locked);
            if is_sooner {
                host.waiting.ring_keeper(scene.lanes);
            }
        }
        kernel::advance(SOON + LATER / 2);
    }
    for (me, lane) in lanes.into_iter().enumerate() {
        let is_dead = lane.join().unwrap();
        if is_dead && !scene.without_burial {
            host.waiting.bury(me);
            host.waiting.knock();
        }
    }
    assert!(host.locked.lock().unwrap().is_done);
}

const REQUEST: Scene = Scene {
    lanes: 1,
    is_request: true,
    hands: false,
    is_begun_by_a_third: false,
    dies: false,
    without_burial: false,
    without_knock: false,
    without_ring: false,
};
const INSTANT: Scene = Scene { is_request: false, ..REQUEST };

#[test]
fn an_idle_lane_takes_a_request() {
    explore(2, || play(REQUEST));
}

#[test]
fn an_idle_lane_keeps_the_time() {
    explore(2, || play(INSTANT));
}

#[test]
fn one_of_two_idle_lanes_takes_a_request() {
    explore(3, || play(Scene { lanes: 2, ..REQUEST }));
}

#[test]
fn a_request_is_taken_by_the_lane_that_stays_idle() {
    explore(3, || play(Scene { lanes: 2, hands: true, ..REQUEST }));
}

#[test]
fn an_instant_that_came_nearer_is_kept() {
    explore(3, || play(Scene { lanes: 2, ..INSTANT }));
}

#[test]
fn the_time_is_kept_by_the_lane_that_stays_idle() {
    explore(3, || play(Scene { lanes: 2, hands: true, ..INSTANT }));
}

#[test]
fn an_instant_that_a_busy_lane_brought_nearer_is_kept_by_the_next_keeper() {
    // The time between the last two steps of the third lane is a preemption more.
    explore_within(3, Some(3), || {
        play(Scene { lanes: 2, hands: true, is_begun_by_a_third: true, ..INSTANT });
    });
}

#[test]
fn a_request_that_a_dead_lane_did_not_take_is_taken() {
    explore(3, || play(Scene { lanes: 2, dies: true, ..REQUEST }));
}

#[test]
fn the_time_that_a_dead_lane_kept_is_kept() {
    explore(3, || play(Scene { lanes: 2, dies: true, ..INSTANT }));
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_request_of_a_dead_lane_that_nobody_finds_is_caught() {
    explore(3, || play(Scene { lanes: 2, dies: true, without_burial: true, ..REQUEST }));
}

#[test]
#[should_panic(expected = "deadlock")]
fn the_time_of_a_dead_lane_that_nobody_finds_is_caught() {
    explore(3, || play(Scene { lanes: 2, dies: true, without_burial: true, ..INSTANT }));
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_request_without_a_knock_is_caught() {
    explore(2, || play(Scene { without_knock: true, ..REQUEST }));
}

#[test]
#[should_panic(expected = "deadlock")]
fn an_instant_of_which_the_keeper_is_not_told_is_caught() {
    explore(3, || play(Scene { lanes: 2, without_ring: true, ..INSTANT }));
}
