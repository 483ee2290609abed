use crate::scheduler::Scheduler;
use crate::{Caps, Config, CostEstimate, Dag, Duration, Instant, Node, Timing, Wcet};

/// A run that was given up tells of its node once it is past the WCET, if it was alone on its lane.
#[test]
fn what_a_job_that_is_given_up_has_run_counts_once_it_is_too_long() {
    for (ran, merged, counts) in [(2, false, false), (3, false, true), (3, true, false)] {
        let mut dag = Dag::<Caps<1, 4, 4>>::new();
        let node = dag.add_node(Node::new(Wcet::from_nanos(2))).unwrap();
        let mut scheduler = Scheduler::<Caps<1, 4, 4>>::new(Config::REDRT);
        let task = scheduler.add_task(&dag, Timing::new(Duration::from_nanos(9))).unwrap();
        scheduler.release(task, Instant::ZERO).unwrap();
        assert!(scheduler.poll(Instant::ZERO).is_some());
        assert!(scheduler.poll(Instant::from_nanos(ran)).is_none());
        scheduler.lanes[0].merged = merged;
        scheduler.observe_given_up(0);
        let mean = scheduler.task_node(task, node).unwrap().1.mean();
        assert_eq!(mean, counts.then_some(CostEstimate::from_nanos(2)), "{ran} ns, merged: {merged}");
    }
}
