//! *Claim.* Each unit that is handed to a seat is taken once, by a lane that sees all of its work and no other's, also
//! where it sleeps; what a spare discarded is taken no more by the thread that came back late.
//!
//! *Threads.* Who hands and the lane; then the late thread, the spare, and who hands.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `rt-linux/src/seat.rs`, `rt-linux/src/bell.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::thread;
use red_core::{PoolId, TaskId, UnitId};
use red_loom_tests::bell::{Bell, Woken};
use red_loom_tests::handler::Work;
use red_loom_tests::model::explore;
use red_loom_tests::seat::Seat;
use red_loom_tests::sleeper::Sleeper;
use std::sync::Arc;

/// Another work for every unit, in every word, so that a mixture of two shows.
fn work(number: u64) -> Work {
    Work {
        unit: UnitId::from_bits(number),
        task: TaskId::from_bits((number << 16 | number) as u32),
        pool: PoolId::new(number as u8),
        job: number,
        release_ns: number,
        deadline_ns: number,
        since_ns: number,
        sub_deadline_ns: number,
        wcet_ns: number,
        output: Some(number as u16),
        ..Work::default()
    }
}

fn hand(seat: &Seat, number: u64) {
    seat.hand(&work(number));
}

fn take(seat: &Seat) -> Option<u64> {
    seat.take().map(|found| {
        let unit = found.unit.to_bits();
        assert_eq!(found, work(unit), "torn");
        unit
    })
}

/// A seat under its lock.
#[derive(Default)]
struct Lane {
    seat: Seat,
    /// The unit that was reported last.
    reported: Mutex<u64>,
    report: Bell,
}

/// Two units, the second when the first was reported; `waits` is false for a host that does not wait for that.
fn takes_each(waits: bool) {
    let lane = Arc::new(Lane::default());
    let host = {
        let lane = lane.clone();
        thread::spawn(move || {
            let locked = lane.reported.lock().unwrap();
            hand(&lane.seat, 1);
            drop(locked);
            if waits {
                assert_eq!(lane.report.wait(None, 0), Woken::Rung);
            }
            let _locked = lane.reported.lock().unwrap();
            hand(&lane.seat, 2);
        })
    };
    for number in 1..=2 {
        let unit = loop {
            match take(&lane.seat) {
                Some(unit) => break unit,
                None => thread::yield_now(),
            }
        };
        assert_eq!(unit, number, "lost or twice");
        *lane.reported.lock().unwrap() = unit;
        lane.report.ring();
    }
    host.join().unwrap();
    assert_eq!(take(&lane.seat), None, "twice");
}

#[test]
fn a_unit_wakes_the_lane_that_sleeps() {
    explore(2, || {
        let lane = Arc::new(Lane::default());
        let host = {
            let lane = lane.clone();
            thread::spawn(move || hand(&lane.seat, 1))
        };
        let mut sleeper = Sleeper::yielding();
        while take(&lane.seat).is_none() {
            assert_eq!(lane.seat.sleep(&mut sleeper, None, 0), Woken::Rung);
        }
        host.join().unwrap();
    });
}

#[test]
fn each_unit_is_taken_once_and_whole() {
    explore(2, || takes_each(true));
}

/// A unit was handed to a thread that is late; its spare discards it and is handed the next one.
fn discards(does: bool) {
    let lane = Arc::new(Lane::default());
    let late = {
        let lane = lane.clone();
        thread::spawn(move || take(&lane.seat))
    };
    hand(&lane.seat, 1);
    let host = {
        let lane = lane.clone();
        thread::spawn(move || {
            let restored = lane.reported.lock().unwrap();
            if *restored == 1 {
                hand(&lane.seat, 2);
            }
            *restored == 1
        })
    };
    {
        let mut restored = lane.reported.lock().unwrap();
        if does {
            lane.seat.discard();
        }
        *restored = 1;
    }
    let mine = take(&lane.seat);
    let (theirs, handed) = (late.join().unwrap(), host.join().unwrap());
    let rest = take(&lane.seat);
    assert_ne!(mine, Some(1), "the spare ran what was discarded");
    let second = [mine, theirs, rest].into_iter().filter(|unit| *unit == Some(2)).count();
    assert_eq!(second, usize::from(handed), "lost or twice: {mine:?} {theirs:?} {rest:?} {handed}");
}

#[test]
fn what_was_discarded_is_taken_late_or_never() {
    explore(3, || discards(true));
}

#[test]
#[should_panic(expected = "the spare ran what was discarded")]
fn a_spare_that_does_not_discard_is_caught() {
    explore(3, || discards(false));
}

#[test]
#[should_panic(expected = "torn")]
fn a_host_that_hands_before_the_report_is_caught() {
    explore(2, || takes_each(false));
}
