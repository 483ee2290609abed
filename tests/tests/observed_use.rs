//! What others use of a device counts as overload under the paper's rule, also where the lanes themselves are hardly
//! busy.

use red_core::{
    Action, Bytes, Caps, Config, Dag, Duration, Instant, Node, PoolId, Ppm, Scheduler, ShedReason, Timing,
    Wcet,
};

type Robot = Caps<4, 8, 8, 4, 2, 1, 64>;

fn at(millis: u64) -> Instant {
    Instant::from_nanos(millis * 1_000_000)
}

/// Why one of two jobs was given up within ten ticks, if it was: there are four lanes, and memory for one of them.
fn given_up(config: Config, used: Option<Ppm>) -> Option<ShedReason> {
    let mut scheduler = Scheduler::<Robot>::new(Config { memory: Some(Bytes(10)), ..config.with_lanes(4) });
    let mut dag = Dag::new();
    dag.add_node(Node::new(Wcet::from_millis(50)).memory(Bytes(10))).expect("room");
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(200))).expect("it fits");
    assert!(!scheduler.observe_use(PoolId::new(1), Ppm(0)), "there is none");
    for _ in 0..2 {
        scheduler.release(task, at(0)).expect("room");
    }
    for now in 0..50 {
        if let Some(used) = used {
            assert!(scheduler.observe_use(PoolId::new(0), used));
        }
        while let Some(action) = scheduler.poll(at(now)) {
            if let Action::Ended(outcome) = action {
                return outcome.shed;
            }
        }
    }
    None
}

#[test]
fn the_papers_rule_sheds_where_others_keep_the_device_busy() {
    assert_eq!(given_up(Config::RED, None), None, "a quarter of the lanes is busy");
    assert_eq!(given_up(Config::RED, Some(Ppm(900_000))), None, "not above theta");
    assert_eq!(given_up(Config::RED, Some(Ppm(900_001))), Some(ShedReason::Urgency));
}

#[test]
fn ours_sheds_nothing_where_no_job_is_late() {
    assert_eq!(given_up(Config::REDRT, Some(Ppm(1_000_000))), None);
}
