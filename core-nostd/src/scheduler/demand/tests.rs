use super::*;
use crate::time::Instant;
use crate::{Caps, Config, Dag, Duration, Node, PoolId, TaskId, Timing, Wcet};

type Small = Caps<4, 16, 16, 4, 2>;

/// On one lane; the second pool has two.
fn scheduler() -> (Scheduler<Small>, PoolId) {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let two = scheduler.add_pool(2, None).unwrap();
    (scheduler, two)
}

/// A task with a job in flight: nodes side by side, of which each takes so many nanoseconds.
fn add(scheduler: &mut Scheduler<Small>, pool: PoolId, nodes: &[u64], timing: Timing) -> usize {
    let mut dag = Dag::<Small>::new();
    for wcet in nodes {
        dag.add_node(Node::new(Wcet::from_nanos(*wcet)).in_pool(pool)).unwrap();
    }
    let task = scheduler.add_task(&dag, timing).unwrap();
    scheduler.release(task, Instant::ZERO).unwrap();
    task.index()
}

const fn timing(value: u32) -> Timing {
    Timing::new(Duration::from_nanos(100)).every(Duration::from_nanos(10)).value(value)
}

/// Of a task of 6 ns every 10 and value 2 beside one of some nanoseconds: whether each could be whole.
fn beside(wcet: u64, other: Timing) -> [bool; 2] {
    let (mut scheduler, _) = scheduler();
    let tasks = [
        add(&mut scheduler, PoolId::new(0), &[6], timing(2)),
        add(&mut scheduler, PoolId::new(0), &[wcet], other),
    ];
    tasks.map(|task| scheduler.can_be_whole(task))
}

#[test]
fn what_counts_before_a_task_may_fill_the_lanes() {
    assert_eq!(beside(4, timing(2)), [true, true]);
    assert_eq!(beside(5, timing(2)), [false, false]);
    assert_eq!(beside(4, timing(3)), [true, true]);
    assert_eq!(beside(5, timing(3)), [false, true]);
    assert_eq!(beside(5, timing(1)), [true, false]);
}

#[test]
fn of_who_is_worth_less_counts_what_its_floor_needs() {
    for (m, k) in [(1, 2), (2, 4), (3, 6)] {
        assert_eq!(beside(8, timing(1).floor(m, k)), [true, false]);
        assert_eq!(beside(9, timing(1).floor(m, k)), [false, false]);
    }
    assert_eq!(beside(5, timing(1).floor(1, 1)), [false, false]);
}

#[test]
fn one_without_a_period_counts_as_one_each_deadline() {
    let at_any_time = |value: u32| Timing::new(Duration::from_nanos(100)).value(value);
    assert_eq!(beside(40, at_any_time(2)), [true, true]);
    assert_eq!(beside(41, at_any_time(2)), [false, false]);
    assert_eq!(beside(41, at_any_time(1)), [true, false]);
}

#[test]
fn who_comes_no_more_asks_for_nothing() {
    let once = Timing::new(Duration::from_nanos(100)).value(2);
    for (wcet, other, until) in
        [(41, once, 0), (5, timing(2), 11), (41, timing(2).every(Duration::from_nanos(80)), 90)]
    {
        let (mut scheduler, _) = scheduler();
        let task = add(&mut scheduler, PoolId::new(0), &[6], timing(2));
        let other = add(&mut scheduler, PoolId::new(0), &[wcet], other);
        assert!(!scheduler.can_be_whole(task));
        let job = scheduler.slots().find(|slot| scheduler.jobs[*slot].task.index() == other).unwrap();
        scheduler.end_job(job, None);
        for now in 0..100 {
            scheduler.now = Instant::from_nanos(now);
            assert_eq!(scheduler.can_be_whole(task), until <= now, "{until} ns: at {now}");
        }
    }
    // Before its first job it is not there.
    let (mut scheduler, _) = scheduler();
    let task = add(&mut scheduler, PoolId::new(0), &[6], timing(2));
    let mut dag = Dag::<Small>::new();
    dag.add_node(Node::new(Wcet::from_nanos(5))).unwrap();
    let _other = scheduler.add_task(&dag, timing(2)).unwrap();
    assert!(scheduler.can_be_whole(task));
}

/// A node that takes longer than a task can wait keeps it from its lane; so do as many as there are lanes.
#[test]
fn a_long_node_of_who_counts_for_each_job_blocks() {
    let slow = |value: u32| timing(value).every(Duration::from_nanos(1_000));
    let due = |due: u64| Timing::new(Duration::from_nanos(due)).every(Duration::from_nanos(1_000)).value(2);
    let could = |pool: usize, nodes: &[u64], other: Timing, due_in: u64| {
        let (mut scheduler, two) = scheduler();
        let pool = [PoolId::new(0), two][pool];
        add(&mut scheduler, pool, nodes, other);
        let task = add(&mut scheduler, pool, &[10], due(due_in));
        scheduler.can_be_whole(task)
    };
    assert!(could(0, &[30], slow(2), 40));
    assert!(!could(0, &[30], slow(2), 39));
    assert!(could(0, &[30], slow(1), 39));
    assert!(could(0, &[30], slow(1).floor(1, 2), 39));
    assert!(!could(0, &[30], slow(1).floor(1, 1), 39));
    assert!(could(1, &[30], slow(2), 39));
    assert!(!could(1, &[30, 30], slow(2), 39));
    // Its own nodes do not, and none of another pool.
    assert!(could(0, &[1], slow(2), 11));
    let (mut scheduler, two) = scheduler();
    add(&mut scheduler, two, &[30, 30, 30], slow(9));
    let task = add(&mut scheduler, PoolId::new(0), &[10, 20], due(35));
    assert!(scheduler.can_be_whole(task));
}

#[test]
fn who_is_gone_asks_for_nothing() {
    let (mut scheduler, _) = scheduler();
    let task = add(&mut scheduler, PoolId::new(0), &[6], timing(2));
    let gone = add(&mut scheduler, PoolId::new(0), &[6], timing(2));
    assert!(!scheduler.can_be_whole(task));
    let generation = scheduler.tasks[gone].generation;
    assert!(scheduler.remove_task(TaskId::new(gone, generation), Instant::ZERO));
    assert!(scheduler.can_be_whole(task));
}
