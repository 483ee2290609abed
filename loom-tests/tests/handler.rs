//! *Claim.* A handler only goes the ways of its diagram, one of several drivers makes each step, and who sees a state
//! sees what was written before it.
//!
//! *Threads.* A driver and a watcher, or two drivers; then all three.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `sync/src/handler.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::atomic::{AtomicU8, Ordering};
use loom::thread;
use red_loom_tests::handler_cell::HandlerState::{self, Done, Idle, Io, OutOfMemory, Ready, Running};
use red_loom_tests::handler_cell::{HandlerCell, TransitionError};
use red_loom_tests::model::explore;
use std::sync::Arc;

/// What the claims are about.
trait Handler: Send + Sync + 'static {
    fn new() -> Self;
    fn go(&self, from: HandlerState, to: HandlerState) -> Result<(), TransitionError>;
    fn state(&self) -> HandlerState;
}

impl Handler for HandlerCell {
    fn new() -> Self {
        Self::new()
    }

    fn go(&self, from: HandlerState, to: HandlerState) -> Result<(), TransitionError> {
        self.go(from, to)
    }

    fn state(&self) -> HandlerState {
        self.state()
    }
}

/// A way through every transition of the diagram.
const WAY: [HandlerState; 12] =
    [Idle, Ready, Running, Io, Running, OutOfMemory, Ready, Running, Io, OutOfMemory, Done, Idle];

/// Where one may be after `from`: by the diagram of the paper's Fig. 6b, not by the code.
const NEXT: [(HandlerState, &[HandlerState]); 6] = [
    (Idle, &[Ready]),
    (Ready, &[Running]),
    (Running, &[Io, OutOfMemory, Done]),
    (Io, &[Running, OutOfMemory]),
    (OutOfMemory, &[Ready, Done]),
    (Done, &[Idle]),
];

struct Shared<H> {
    handler: H,
    result: UnsafeCell<u32>,
}

// SAFETY: the checker says when the result is reached by two at once.
unsafe impl<H: Sync> Sync for Shared<H> {}
// SAFETY: the result goes with it.
unsafe impl<H: Send> Send for Shared<H> {}

/// The driver goes the whole way; the watcher looks twice, and what it sees lies in this order on the way.
fn is_watched_in_order<H: Handler>() {
    let handler = Arc::new(H::new());
    let driver = {
        let handler = handler.clone();
        thread::spawn(move || {
            WAY.windows(2).for_each(|step| assert_eq!(handler.go(step[0], step[1]), Ok(())));
            assert_eq!(handler.go(Running, Done), Err(TransitionError::Elsewhere));
            assert_eq!(handler.go(Idle, Done), Err(TransitionError::Illegal));
        })
    };
    let (first, second) = (handler.state(), handler.state());
    let from = WAY.iter().position(|state| *state == first).expect("a state of the way");
    assert!(WAY[from..].contains(&second), "{first:?} and then {second:?}");
    driver.join().unwrap();
    assert_eq!(handler.state(), Idle);
}

#[test]
fn a_watcher_sees_states_in_the_order_of_the_way() {
    explore(2, is_watched_in_order::<HandlerCell>);
}

/// What a body wrote before `Done` is there for who sees `Done`; the reader gives the handler back, and the next
/// driver may write again.
fn publishes<H: Handler>(threads: usize) {
    let shared = Arc::new(Shared { handler: H::new(), result: UnsafeCell::new(0) });
    shared.handler.go(Idle, Ready).unwrap();
    let run = |shared: &Shared<H>| {
        let won = shared.handler.go(Ready, Running).is_ok();
        if won {
            // SAFETY: who drives the handler has the result.
            shared.result.with_mut(|result| unsafe { *result += 1 });
            shared.handler.go(Running, Done).expect("nobody else drives it");
        }
        won
    };
    let drivers: Vec<_> = (1..threads)
        .map(|_| {
            let shared = shared.clone();
            thread::spawn(move || run(&shared))
        })
        .collect();
    if shared.handler.state() == Done {
        // SAFETY: the body ended.
        shared.result.with(|result| assert_eq!(unsafe { *result }, 1));
        shared.handler.go(Done, Idle).expect("nobody else takes the result");
        shared.handler.go(Idle, Ready).expect("nobody else makes it ready");
        run(&shared);
    }
    let won = drivers.into_iter().filter(|_| true).map(|driver| driver.join().unwrap()).filter(|won| *won);
    let won = won.count();
    assert!((1..=2).contains(&won), "{won} drivers ran");
}

#[test]
fn what_was_written_before_a_step_is_seen_after_it() {
    explore(2, || publishes::<HandlerCell>(2));
}

#[test]
fn of_two_drivers_one_runs_the_body_at_a_time() {
    explore(3, || publishes::<HandlerCell>(3));
}

/// Two drivers want different steps from the same state: one goes, the other is told, and the state is one of the
/// diagram.
fn one_of_two_goes<H: Handler>() {
    let handler = Arc::new(H::new());
    handler.go(Idle, Ready).unwrap();
    handler.go(Ready, Running).unwrap();
    let other = {
        let handler = handler.clone();
        thread::spawn(move || handler.go(Running, Done))
    };
    let mine = handler.go(Running, Io);
    let theirs = other.join().unwrap();
    let state = handler.state();
    assert!(NEXT[2].1.contains(&state), "{state:?} after Running");
    assert_eq!(mine.is_ok(), state == Io, "the step to Io");
    assert_eq!(theirs.is_ok(), state == Done, "the step to Done");
}

#[test]
fn of_two_steps_from_one_state_one_is_made() {
    explore(2, one_of_two_goes::<HandlerCell>);
}

#[test]
fn every_step_is_legal_or_refused() {
    explore(1, || {
        for (from, next) in NEXT {
            let handler = Arc::new(HandlerCell::new());
            let steps = WAY.windows(2).take_while(|step| handler.state() != from && step[0] != from);
            steps.for_each(|step| handler.go(step[0], step[1]).unwrap());
            if handler.state() != from {
                continue;
            }
            for (to, _) in NEXT.into_iter().filter(|(to, _)| !next.contains(to)) {
                assert_eq!(handler.go(from, to), Err(TransitionError::Illegal));
            }
        }
    });
}

/// A cell that looks and then stores, so that two drivers may both go.
struct Planted(AtomicU8);

impl Handler for Planted {
    fn new() -> Self {
        Self(AtomicU8::new(0))
    }

    fn go(&self, from: HandlerState, to: HandlerState) -> Result<(), TransitionError> {
        if self.state() != from {
            return Err(TransitionError::Elsewhere);
        }
        self.0.store(to as u8, Ordering::Release);
        Ok(())
    }

    fn state(&self) -> HandlerState {
        let state = self.0.load(Ordering::Acquire);
        NEXT.into_iter().map(|(from, _)| from).find(|from| *from as u8 == state).expect("a state")
    }
}

#[test]
#[should_panic(expected = "the step to")]
fn a_cell_that_looks_and_then_stores_is_caught() {
    explore(2, one_of_two_goes::<Planted>);
}
