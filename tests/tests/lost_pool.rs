//! A pool that is lost: jobs that need it end at once, and so do later ones; all others go on.

use red_core::{
    Action, Caps, CompleteError, Config, Dag, Duration, Instant, LaneId, Node, Outcome, PoolId, Scheduler,
    ShedReason, TaskId, Timing, UnitId, Wcet,
};

type Robot = Caps<4, 8, 4, 4, 2, 1, 64>;

fn at(millis: u64) -> Instant {
    Instant::from_nanos(millis * 1_000_000)
}

/// A task of nodes of a millisecond in these pools, one after the other.
fn task(scheduler: &mut Scheduler<Robot>, pools: &[u8]) -> TaskId {
    let mut dag = Dag::new();
    let mut last = None;
    for pool in pools {
        let node = Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(*pool));
        let node = dag.add_node(node).expect("room");
        if let Some(last) = last.replace(node) {
            dag.add_edge(last, node).expect("no cycle");
        }
    }
    scheduler.add_task(&dag, Timing::new(Duration::from_millis(50))).expect("it fits")
}

/// What is dispatched, and which jobs ended, of the tasks in their order.
fn polled(scheduler: &mut Scheduler<Robot>, now: u64) -> (Vec<UnitId>, Vec<Outcome>) {
    let (mut units, mut ended) = (Vec::new(), Vec::new());
    while let Some(action) = scheduler.poll(at(now)) {
        match action {
            Action::Dispatch(dispatch) => units.push(dispatch.unit),
            Action::Ended(outcome) => ended.push(outcome),
            _ => {}
        }
    }
    (units, ended)
}

#[test]
fn jobs_that_need_it_end_and_the_others_go_on() {
    for config in [Config::REDRT, Config::RED, Config::EDF] {
        let mut scheduler = Scheduler::<Robot>::new(config);
        let gpu = scheduler.add_pool(1, None).expect("room");
        // One that runs there, one that will, one that was there, and one that never is.
        let tasks = [&[1, 0][..], &[0, 1], &[1, 0], &[0]].map(|pools| task(&mut scheduler, pools));
        let [runs, will, was, never] = tasks;
        scheduler.release(was, at(0)).expect("room");
        let (first, _) = polled(&mut scheduler, 0);
        scheduler.complete(first[0], at(1)).expect("it ran");
        let (second, _) = polled(&mut scheduler, 1);
        let jobs = [runs, will, never].map(|task| scheduler.release(task, at(1)).expect("room"));
        let (there, _) = polled(&mut scheduler, 1);
        assert_eq!((second.len(), there.len()), (1, 1), "each on its pool's lane");
        assert!(!scheduler.lose_pool(PoolId::new(2), at(2)), "there is none");
        assert_eq!(scheduler.pool_of(there[0].lane()), Some(gpu));
        assert_eq!(scheduler.pool_of(LaneId::new(2)), None);
        assert_eq!(polled(&mut scheduler, 2).1, []);
        assert!(scheduler.lose_pool(gpu, at(2)));
        let (_, ended) = polled(&mut scheduler, 2);
        let told: Vec<_> = ended.iter().map(|outcome| (outcome.job, outcome.shed)).collect();
        assert_eq!(told, [jobs[0], jobs[1]].map(|job| (job, Some(ShedReason::Fault))));
        // What ran there has to be reported all the same, and cannot be completed.
        assert_eq!(scheduler.complete(there[0], at(3)), Err(CompleteError::Late));
        // Again says nothing new.
        assert!(scheduler.lose_pool(gpu, at(3)));
        scheduler.complete(second[0], at(3)).expect("it needs the pool no more");
        let (third, ended) = polled(&mut scheduler, 3);
        assert_eq!(ended.iter().map(|o| (o.task, o.shed)).collect::<Vec<_>>(), [(was, None)]);
        scheduler.complete(third[0], at(4)).expect("it ran");
        assert_eq!(polled(&mut scheduler, 4).1.len(), 1);
        // Later ones end as they are released.
        let later = [was, never].map(|task| scheduler.release(task, at(5)).expect("room"));
        let (units, ended) = polled(&mut scheduler, 5);
        let told: Vec<_> = ended.iter().map(|o| (o.job, o.shed, o.at)).collect();
        assert_eq!(told, [(later[0], Some(ShedReason::Fault), at(5))]);
        scheduler.complete(units[0], at(6)).expect("it ran");
        assert_eq!((polled(&mut scheduler, 6).1.len(), scheduler.jobs_in_flight()), (1, 0));
    }
}
