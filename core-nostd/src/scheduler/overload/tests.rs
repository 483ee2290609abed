use super::*;
use crate::{Caps, Config, Dag, Duration, Node, Timing, Wcet};

/// What has to be done within so many nanoseconds, and is worth so much.
const fn due_in(nanos: u64, value: u32) -> Timing {
    Timing::new(Duration::from_nanos(nanos)).value(value)
}

/// A job of a task of its own, of one node of so many nanoseconds.
fn add_job<C: Capacity>(scheduler: &mut Scheduler<C>, wcet: u64, timing: Timing) {
    let mut dag = Dag::<C>::new();
    dag.add_node(Node::new(Wcet::from_nanos(wcet))).unwrap();
    let task = scheduler.add_task(&dag, timing).unwrap();
    scheduler.release(task, Instant::ZERO).unwrap();
}

#[test]
fn jobs_that_fit_in_any_order_need_no_forward_schedule() {
    let mut dag = Dag::<Caps<4, 16, 16>>::new();
    for _ in 0..4 {
        dag.add_node(Node::new(Wcet::from_nanos(1))).unwrap();
    }
    let mut scheduler = Scheduler::<Caps<4, 16, 16>>::new(Config::REDRT);
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(50))).unwrap();
    for jobs in 1..=13 {
        scheduler.release(task, Instant::ZERO).unwrap();
        assert_eq!(scheduler.fits_by_far(), 50_u64.checked_sub(4 * jobs), "{jobs} jobs");
    }
}

/// Pressure lasts for four times the longest relative deadline, but for no more than 16 times the longest that is late.
#[test]
fn a_job_that_has_hours_does_not_keep_ranks_in_front_for_hours() {
    for (longest, until) in [(30, 120), (40, 160), (10_000, 160)] {
        let mut scheduler = Scheduler::<Caps<4, 16, 16>>::new(Config::REDRT);
        for (wcet, due) in [(8, 10), (8, 10), (1, longest)] {
            add_job(&mut scheduler, wcet, due_in(due, 0));
        }
        scheduler.forward_by_band();
        assert_eq!(scheduler.pools[0].pressed, Instant::from_nanos(until), "{longest} ns");
        for (now, is_pressed) in [(until - 1, true), (until, false)] {
            scheduler.now = Instant::from_nanos(now);
            let floors = scheduler.floors_without(0);
            scheduler.set_bands(&floors);
            assert_eq!(scheduler.is_pressed(0), is_pressed, "{longest} ns: at {now}");
        }
    }
}

#[test]
fn what_a_lane_does_for_nobody_or_for_several_counts() {
    for is_for_several in [false, true] {
        let mut scheduler = Scheduler::<Caps<4, 16, 16>>::new(Config::REDRT);
        add_job(&mut scheduler, 5, due_in(20, 1));
        assert!(scheduler.poll(Instant::ZERO).is_some());
        if is_for_several {
            scheduler.lanes[0].merged = true;
        } else {
            scheduler.end_job(0, Some(ShedReason::Overload));
        }
        add_job(&mut scheduler, 3, due_in(20, 1));
        let own = if is_for_several { 5 } else { 0 };
        assert_eq!(scheduler.fits_by_far(), Some(20 - 5 - 3 - own), "several: {is_for_several}");
    }
}

/// Two of 2 and 6 ns come before 10 ns that are worth more. Without the 6 there is room for the 2.
#[test]
fn who_need_not_go_after_all_is_not_warned_of() {
    let mut scheduler = Scheduler::<Caps<4, 16, 16>>::new(Config::REDRT);
    for (wcet, due, value) in [(2, 4, 1), (6, 9, 2), (10, 14, 3)] {
        add_job(&mut scheduler, wcet, due_in(due, value));
    }
    assert!(scheduler.poll(Instant::ZERO).is_some());
    let is_there = |slot: usize| scheduler.in_flight >> slot & 1 != 0;
    assert_eq!([0, 1, 2].map(is_there), [true, false, true]);
    assert_eq!([0, 1, 2].map(|slot| scheduler.is_warned_of(slot)), [false, true, false]);
}

/// The first would keep the lane from the second, which is worth more, and can wait. The last is late in any order, and what the second asks
/// for does not fit, so that no order by deadline is taken.
#[test]
fn who_can_wait_for_a_higher_one_need_not_go() {
    type Two = Caps<4, 16, 16, 4, 2>;
    let mut scheduler = Scheduler::<Two>::new(Config::REDRT);
    let other = scheduler.add_pool(1, None).unwrap();
    add_job(&mut scheduler, 195, due_in(200, 1));
    add_job(&mut scheduler, 4, due_in(10, 2).every(Duration::from_nanos(3)));
    let mut late = Dag::<Two>::new();
    let before = late.add_node(Node::new(Wcet::from_nanos(3)).in_pool(other)).unwrap();
    let after = late.add_node(Node::new(Wcet::from_nanos(1))).unwrap();
    late.add_edge(before, after).unwrap();
    let late = scheduler.add_task(&late, due_in(2, 0)).unwrap();
    scheduler.release(late, Instant::ZERO).unwrap();
    assert!(scheduler.poll(Instant::ZERO).is_some());
    assert_eq!([0, 1, 2].map(|slot| scheduler.in_flight >> slot & 1 != 0), [true, true, false]);
}
