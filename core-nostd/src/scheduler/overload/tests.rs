use super::*;
use crate::{Caps, Config, Dag, Duration, Node, Timing, Wcet};

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
            let mut dag = Dag::<Caps<4, 16, 16>>::new();
            dag.add_node(Node::new(Wcet::from_nanos(wcet))).unwrap();
            let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(due))).unwrap();
            scheduler.release(task, Instant::ZERO).unwrap();
        }
        scheduler.forward_by_band();
        assert_eq!(scheduler.pools[0].pressed, Instant::from_nanos(until), "{longest} ns");
    }
}
