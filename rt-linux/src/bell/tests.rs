use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use super::{Bell, Woken};
use crate::clock::now_ns;

/// Long enough that reaching it means a lost wake-up, on the slowest machine.
const FAR_NS: u64 = 20_000_000_000;

fn far() -> Option<u64> {
    Some(now_ns() + FAR_NS)
}

#[test]
fn a_ring_before_the_wait_ends_it_at_once() {
    let bell = Bell::new();
    bell.ring();
    assert_eq!(bell.wait(None, 0), Woken::Rung);
}

#[test]
fn rings_are_merged_and_taken_once() {
    let bell = Bell::new();
    bell.ring();
    bell.ring();
    assert!(bell.take());
    assert!(!bell.take());
    assert_eq!(bell.wait(Some(now_ns()), 0), Woken::TimedOut);
}

#[test]
fn a_time_that_has_passed_does_not_hide_a_ring() {
    let bell = Bell::new();
    bell.ring();
    assert_eq!(bell.wait(Some(0), 0), Woken::Rung);
    assert_eq!(bell.wait(Some(0), 0), Woken::TimedOut);
    assert_eq!(bell.wait(Some(0), 1_000), Woken::TimedOut);
}

#[test]
fn a_wait_never_ends_before_its_time() {
    let bell = Bell::new();
    for spin_ns in [0, 50_000, u64::MAX] {
        let until = now_ns() + 200_000;
        assert_eq!(bell.wait(Some(until), spin_ns), Woken::TimedOut);
        assert!(now_ns() >= until, "spin {spin_ns} ns returned early");
    }
}

#[test]
fn a_bell_fits_into_the_line_of_what_it_announces() {
    assert_eq!(size_of::<Bell>(), 4);
}

#[test]
fn a_condition_ends_the_wait_and_leaves_no_ring() {
    let bell = Bell::new();
    bell.wake();
    assert!(!bell.take(), "nobody slept");
    for spin_ns in [0, 1_000] {
        assert_eq!(bell.wait_for(|| true, None, spin_ns), Woken::Rung);
        assert_eq!(bell.wait(Some(now_ns()), spin_ns), Woken::TimedOut);
    }
}

#[test]
fn a_ring_ends_the_wait_for_a_condition_that_does_not_hold() {
    let bell = Bell::new();
    bell.ring();
    assert_eq!(bell.wait_for(|| false, None, 0), Woken::Rung);
    assert_eq!(bell.wait_for(|| false, Some(now_ns() + 10_000), 0), Woken::TimedOut);
}

#[test]
fn a_spin_ends_when_the_condition_holds_or_the_time_has_come() {
    let bell = Bell::new();
    assert_eq!(bell.spin(|| true, 0), Woken::Rung);
    // Beyond the distance at which the clock is looked at seldom, and within it.
    for ahead in [100_000, 1_000] {
        let until = now_ns() + ahead;
        assert_eq!(bell.spin(|| false, until), Woken::TimedOut);
        assert!(now_ns() >= until);
    }
}

/// As `ping_pong`, by the condition alone: nobody rings.
fn ping_pong_by_condition(rounds: u64, spin_ns: u64) {
    #[derive(Default)]
    struct Side {
        bell: Bell,
        number: AtomicU64,
    }
    impl Side {
        fn send(&self, round: u64) {
            self.number.store(round, Ordering::Relaxed);
            self.bell.wake();
        }
        fn receive(&self, round: u64, spin_ns: u64) {
            let arrived = || self.number.load(Ordering::Relaxed) == round;
            assert_eq!(self.bell.wait_for(arrived, far(), spin_ns), Woken::Rung, "{round} was lost");
            while !arrived() {
                // A wake for a sleep that had ended may leave a ring, which ends one wait early.
                assert_eq!(self.bell.wait_for(arrived, far(), spin_ns), Woken::Rung, "{round} was lost");
            }
        }
    }
    let sides = Arc::new([Side::default(), Side::default()]);
    let echo = thread::spawn({
        let sides = sides.clone();
        move || {
            for round in 1..=rounds {
                sides[0].receive(round, spin_ns);
                sides[1].send(round);
            }
        }
    });
    for round in 1..=rounds {
        sides[0].send(round);
        sides[1].receive(round, spin_ns);
    }
    echo.join().expect("the echo saw every number");
}

#[test]
fn no_condition_is_missed_when_both_sides_sleep() {
    ping_pong_by_condition(20_000, 0);
}

#[test]
fn no_condition_is_missed_at_the_border_of_spin_and_sleep() {
    ping_pong_by_condition(20_000, 5_000);
}

/// Two threads pass a number back and forth. A lost wake-up shows as a time-out, a missing ordering as an old
/// number.
fn ping_pong(rounds: u64, spin_ns: u64) {
    struct Side {
        bell: Bell,
        number: AtomicU64,
    }
    let side = || Arc::new(Side { bell: Bell::new(), number: AtomicU64::new(0) });
    let (ping, pong) = (side(), side());
    let echo = thread::spawn({
        let (ping, pong) = (ping.clone(), pong.clone());
        move || {
            for round in 1..=rounds {
                assert_eq!(ping.bell.wait(far(), spin_ns), Woken::Rung, "ping {round} was lost");
                assert_eq!(ping.number.load(Ordering::Relaxed), round);
                pong.number.store(round, Ordering::Relaxed);
                pong.bell.ring();
            }
        }
    });
    for round in 1..=rounds {
        ping.number.store(round, Ordering::Relaxed);
        ping.bell.ring();
        assert_eq!(pong.bell.wait(far(), spin_ns), Woken::Rung, "pong {round} was lost");
        assert_eq!(pong.number.load(Ordering::Relaxed), round);
    }
    echo.join().expect("the echo saw every ring");
}

#[test]
fn no_ring_is_lost_when_both_sides_sleep() {
    ping_pong(20_000, 0);
}

#[test]
fn no_ring_is_lost_at_the_border_of_spin_and_sleep() {
    // About the cost of a hand-over, so that rings come before, at and after the step into sleep.
    ping_pong(20_000, 5_000);
}

#[test]
fn no_ring_is_lost_among_many_ringers_and_short_time_outs() {
    const RINGERS: u64 = 3;
    const RINGS: u64 = 10_000;
    let bell = Arc::new(Bell::new());
    let sent = Arc::new(AtomicU64::new(0));
    let ringers: Vec<_> = (0..RINGERS)
        .map(|_| {
            let (bell, sent) = (bell.clone(), sent.clone());
            thread::spawn(move || {
                for _ in 0..RINGS {
                    sent.fetch_add(1, Ordering::Relaxed);
                    bell.ring();
                }
            })
        })
        .collect();
    // Time-outs race with rings on every turn; the work counter must still be seen complete at the end.
    let give_up = now_ns() + FAR_NS;
    let mut turn = 0_u64;
    while sent.load(Ordering::Relaxed) < RINGERS * RINGS {
        turn += 1;
        let until = if turn.is_multiple_of(2) { now_ns() + 1_000 } else { give_up };
        let woken = bell.wait(Some(until), 0);
        assert!(woken == Woken::Rung || now_ns() < give_up, "a ring was lost");
    }
    for ringer in ringers {
        ringer.join().expect("a ringer only rings");
    }
}
