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
