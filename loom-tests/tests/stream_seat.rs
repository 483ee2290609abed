//! *Claim.* Units that are handed ahead are taken once each, whole and in their order, also where two lie there, and by a
//! lane that sleeps for its stream. So is a unit that is dispatched to a lane that waits, before those behind it.
//!
//! *Threads.* Who hands and the lane.
//! *Bound.* Four preemptions.
//! *Sources.* `rt-linux/src/stream_seat.rs`, `rt-linux/src/seat.rs`, `rt-linux/src/bell.rs`, `rt-linux/src/waiting.rs`
#![cfg(loom)]

use loom::sync::Mutex;
use loom::thread;
use red_core::UnitId;
use red_loom_tests::bell::{Bell, Woken};
use red_loom_tests::handler::Work;
use red_loom_tests::model::explore_within;
use red_loom_tests::sleeper::Sleeper;
use red_loom_tests::stream_seat::{Ahead, StreamSeat};
use red_loom_tests::waiting::{Next, Waiting};
use std::sync::Arc;

/// Another one for every unit, in every word.
fn ahead(number: u64) -> Ahead {
    let work = Work { unit: UnitId::from_bits(number), job: number, wcet_ns: number, ..Work::default() };
    Ahead::new(work, (0..number).map(|other| (UnitId::from_bits(100 * number + other), number)))
}

fn take(seat: &StreamSeat) -> Option<u64> {
    seat.take().map(|found| {
        let (unit, whole) = (found.work.unit.to_bits(), ahead(found.work.unit.to_bits()));
        assert!(found.work == whole.work && found.after() == whole.after() && found.wait_ns == unit, "torn");
        unit
    })
}

#[derive(Default)]
struct Lane {
    seat: StreamSeat,
    /// The unit that was reported last, under the lock.
    reported: Mutex<u64>,
    report: Bell,
}

/// Three units: the second as soon as the first, the third once the first was reported, where who hands waits for that.
fn takes_each(waits: bool) {
    let lane = Arc::new(Lane::default());
    let host = {
        let lane = lane.clone();
        thread::spawn(move || {
            {
                let _locked = lane.reported.lock().unwrap();
                lane.seat.hand(&ahead(1));
                lane.seat.hand(&ahead(2));
            }
            if waits {
                assert_eq!(lane.report.wait(None, 0), Woken::Rung);
            }
            let _locked = lane.reported.lock().unwrap();
            lane.seat.hand(&ahead(3));
        })
    };
    for number in 1..=3 {
        let unit = loop {
            if let Some(unit) = take(&lane.seat) {
                break unit;
            }
            assert_eq!(lane.seat.bell.wait_for(|| lane.seat.is_handed(), None, 0), Woken::Rung);
        };
        assert_eq!(unit, number, "lost or twice");
        *lane.reported.lock().unwrap() = unit;
        lane.report.ring();
    }
    host.join().unwrap();
    assert_eq!(take(&lane.seat), None, "twice");
}

#[test]
fn each_unit_is_taken_once_whole_and_in_order() {
    explore_within(2, Some(4), || takes_each(true));
}

#[test]
#[should_panic]
fn a_third_unit_before_the_first_was_reported_is_caught() {
    explore_within(2, Some(4), || takes_each(false));
}

/// A lane that waits is dispatched a unit, and handed another one behind it.
fn comes_before_what_is_behind_it(by_one_way: bool) {
    let waiting = Arc::new(Waiting::new(1, 1, 0));
    waiting.plan(u64::MAX, 0);
    let host = {
        let waiting = waiting.clone();
        thread::spawn(move || {
            if by_one_way {
                waiting.hand(0, &ahead(1).work);
            } else {
                waiting.seats[0].hand(&ahead(1).work);
            }
            waiting.hand_ahead(0, &ahead(2));
        })
    };
    let (mut taken, mut sleeper) = (Vec::new(), Sleeper::yielding());
    while taken.len() < 2 {
        match waiting.wait(0, &mut sleeper, || Next::Idle) {
            Next::Run(work, _) => taken.push(work.unit.to_bits()),
            Next::Stream => {
                let seat = waiting.streams[0].as_ref().unwrap();
                taken.extend(std::iter::from_fn(|| seat.take()).map(|ahead| ahead.work.unit.to_bits()));
            }
            other => panic!("{other:?}"),
        }
    }
    host.join().unwrap();
    assert_eq!(taken, [1, 2], "the stream would run them in this order");
}

#[test]
fn a_unit_comes_before_what_is_behind_it() {
    explore_within(2, Some(4), || comes_before_what_is_behind_it(true));
}

#[test]
#[should_panic(expected = "in this order")]
fn a_unit_that_comes_by_another_way_is_caught() {
    explore_within(2, Some(4), || comes_before_what_is_behind_it(false));
}
