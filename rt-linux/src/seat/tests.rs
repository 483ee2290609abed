use core::mem::offset_of;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use red_core::{
    Action, Caps, Config, Dag, Duration, Instant, Node, NodeId, PoolId, Scheduler, TaskId, Timing, UnitId,
    Wcet,
};

use super::Seat;
use crate::bell::Woken;
use crate::clock::now_ns;
use crate::handler::Work;
use crate::sleeper::Sleeper;

/// Long enough that reaching it means a lost wake-up, on the slowest machine.
const FAR_NS: u64 = 20_000_000_000;

/// Another work for every unit, so that a mixture of two shows.
fn work(number: u64) -> Work {
    let unit = UnitId::from_bits(number);
    Work { unit, job: number, release_ns: number, wcet_ns: number, ..Work::default() }
}

#[test]
fn a_hand_off_fits_into_one_cache_line() {
    assert_eq!(offset_of!(Seat, bell), 0);
    assert!(offset_of!(Seat, overdue) == 64, "the work ends with the line");
    assert!(offset_of!(Seat, own) >= 128, "the lane's own words are on other lines");
    assert_eq!(align_of::<Seat>(), 128);
}

#[test]
fn every_word_of_the_work_arrives() {
    let largest = Work {
        task: TaskId::from_bits(0xffff_00ff),
        node: NodeId::new(255),
        pool: PoolId::new(31),
        unit: UnitId::from_bits(u64::MAX << 16 | 31),
        job: (1 << 48) - 1,
        release_ns: u64::MAX - 1,
        deadline_ns: u64::MAX - 2,
        since_ns: u64::MAX - 3,
        sub_deadline_ns: u64::MAX - 4,
        wcet_ns: u64::MAX - 5,
        output: Some(255),
    };
    let seat = Seat::default();
    let works =
        [largest, Work { output: Some(0), ..largest }, Work { output: None, ..largest }, Work::default()];
    for (number, work) in (1_u64..).zip(works) {
        let unit = UnitId::from_bits(work.unit.to_bits() & 0xff | number << 16);
        let work = Work { unit, ..work };
        seat.hand(&work);
        assert_eq!(seat.take(), Some(work));
        assert_eq!(seat.take(), None);
    }
}

#[test]
fn what_was_discarded_is_not_taken_and_the_next_one_is() {
    let seat = Seat::default();
    seat.hand(&work(1));
    seat.discard();
    assert_eq!(seat.take(), None);
    seat.hand(&work(2));
    assert_eq!(seat.take(), Some(work(2)));
}

#[test]
fn the_running_unit_is_the_last_that_was_given_by_anybody() {
    let seat = Seat::default();
    let unit = UnitId::from_bits;
    seat.hand(&work(1 << 16));
    assert_eq!(seat.running(), unit(1 << 16));
    seat.keep(unit(2 << 16));
    assert_eq!(seat.running(), unit(2 << 16));
    seat.hand(&work(3 << 16));
    assert_eq!(seat.running(), unit(3 << 16));
}

#[test]
fn later_units_of_a_scheduler_have_larger_handles() {
    type One = Caps<1, 2, 1, 1>;
    let mut dag = Dag::<One>::new();
    let first = dag.add_node(Node::new(Wcet::from_millis(1))).expect("room");
    let second = dag.add_node(Node::new(Wcet::from_millis(1))).expect("room");
    // The node with the larger number first, so that it is not the node that orders the handles.
    dag.add_edge(second, first).expect("no cycle");
    let mut scheduler = Scheduler::<One>::new(Config::REDRT);
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_secs(1))).expect("room");
    let mut before = 0;
    for job in 0..4 {
        let now = Instant::from_nanos(job * 1_000_000);
        scheduler.release(task, now).expect("room");
        while let Some(action) = scheduler.poll(now) {
            let Action::Dispatch(next) = action else { continue };
            assert!(next.unit.to_bits() > before);
            before = next.unit.to_bits();
            scheduler.complete(next.unit, now).expect("it runs");
        }
    }
}

#[test]
fn a_ring_ends_the_wait_without_a_unit_and_a_hand_off_leaves_no_ring() {
    let (seat, mut sleeper) = (Seat::default(), Sleeper::yielding());
    seat.bell.ring();
    assert_eq!(seat.sleep(&mut sleeper, None, 0), Woken::Rung);
    assert_eq!(seat.take(), None);
    seat.hand(&work(1));
    assert_eq!(seat.sleep(&mut sleeper, None, 0), Woken::Rung);
    assert!(seat.take().is_some());
    assert_eq!(seat.sleep(&mut sleeper, Some(now_ns()), 0), Woken::TimedOut);
}

/// Two lanes hand each other units. A lost wake-up shows as a time-out, a missing ordering as an old work.
fn ping_pong(rounds: u64, spin_ns: u64) {
    fn take(seat: &Seat, sleeper: &mut Sleeper, spin_ns: u64, number: u64) {
        let until = now_ns() + FAR_NS;
        let found = loop {
            match seat.take() {
                Some(handed) => break handed,
                None => {
                    assert_eq!(seat.sleep(sleeper, Some(until), spin_ns), Woken::Rung, "{number} was lost");
                }
            }
        };
        assert_eq!(found, work(number));
    }
    let seats = Arc::new([Seat::default(), Seat::default()]);
    let echo = thread::spawn({
        let seats = seats.clone();
        move || {
            let mut sleeper = Sleeper::yielding();
            for number in 1..=rounds {
                take(&seats[1], &mut sleeper, spin_ns, number);
                seats[0].hand(&work(number));
            }
        }
    });
    let mut sleeper = Sleeper::spinning();
    for number in 1..=rounds {
        seats[1].hand(&work(number));
        take(&seats[0], &mut sleeper, spin_ns, number);
    }
    echo.join().expect("the echo saw every unit");
}

#[test]
fn no_unit_is_lost_when_both_lanes_sleep() {
    ping_pong(20_000, 0);
}

#[test]
fn no_unit_is_lost_at_the_border_of_spin_and_sleep() {
    ping_pong(20_000, 5_000);
}

#[test]
fn of_two_threads_of_a_lane_one_takes_each_unit() {
    const UNITS: u64 = 20_000;
    struct Lane {
        seat: Seat,
        taken: AtomicU64,
    }
    let lane = Arc::new(Lane { seat: Seat::default(), taken: AtomicU64::new(0) });
    let threads: Vec<_> = (0..2)
        .map(|_| {
            let lane = lane.clone();
            thread::spawn(move || {
                while lane.taken.load(Ordering::Acquire) < UNITS {
                    match lane.seat.take() {
                        Some(found) => {
                            let unit = found.unit;
                            assert_eq!(found, work(unit.to_bits()));
                            let before = lane.taken.fetch_add(1, Ordering::AcqRel);
                            assert_eq!(before + 1, unit.to_bits(), "taken twice, or lost");
                        }
                        None => thread::yield_now(),
                    }
                }
            })
        })
        .collect();
    for number in 1..=UNITS {
        lane.seat.hand(&work(number));
        let until = now_ns() + FAR_NS;
        while lane.taken.load(Ordering::Acquire) < number {
            assert!(now_ns() < until, "unit {number} was lost");
            thread::yield_now();
        }
    }
    for thread in threads {
        thread.join().expect("each unit is taken once and whole");
    }
}
