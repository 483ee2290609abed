//! Early warning: who is going to miss its deadline is told of at once, with by how much and because of whom.

use red_core::{
    Action, BestCase, Caps, Config, Contention, Dag, Dispatch, Duration, Instant, Node, PoolId, Scheduler,
    TaskId, Timing, Warning, Wcet,
};

type Robot = Scheduler<Caps<4, 4, 8, 4, 2>>;

fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

/// Two pools, the first with so many lanes and the second with one. Nobody is lost for certain before its deadline.
fn robot(lanes: u8) -> (Robot, [PoolId; 2]) {
    robot_of(Config::REDRT.with_lanes(lanes))
}

fn robot_of(config: Config) -> (Robot, [PoolId; 2]) {
    let mut scheduler = Scheduler::new(Config { best_case: BestCase::Declared, ..config });
    let second = scheduler.add_pool(1, None).expect("there is room");
    (scheduler, [PoolId::default(), second])
}

/// A task of one node.
fn add(scheduler: &mut Robot, pool: PoolId, wcet_ms: u64, deadline_ms: u64, value: u32) -> TaskId {
    let timing = Timing::new(Duration::from_millis(deadline_ms)).value(value);
    add_of(scheduler, Node::new(Wcet::from_millis(wcet_ms)).in_pool(pool), timing)
}

fn add_of(scheduler: &mut Robot, node: Node, timing: Timing) -> TaskId {
    let mut dag = Dag::new();
    dag.add_node(node).expect("it fits");
    scheduler.add_task(&dag, timing).expect("there is room")
}

/// Releases a job whose node starts at once.
fn start(scheduler: &mut Robot, task: TaskId, ms: u64) -> Dispatch {
    scheduler.release(task, at(ms)).expect("there is room");
    match scheduler.poll(at(ms)) {
        Some(Action::Dispatch(started)) => started,
        other => panic!("its lane is free: {other:?}"),
    }
}

/// Releases a job. What is told of then, once all is decided.
fn release(scheduler: &mut Robot, task: TaskId, ms: u64) -> Vec<(TaskId, u64, Option<TaskId>)> {
    scheduler.release(task, at(ms)).expect("there is room");
    while let Some(action) = scheduler.poll(at(ms)) {
        assert!(
            matches!(action, Action::Dispatch(_) | Action::Ahead(_) | Action::Preempt(_) | Action::Ended(_)),
            "nobody asked for {action:?}"
        );
    }
    let told: Vec<Warning> = std::iter::from_fn(|| scheduler.take_warning()).collect();
    let micros = |by: Duration| by.as_nanos() / 1_000;
    told.iter().map(|w| (w.task, micros(w.by), w.because.map(|(task, _)| task))).collect()
}

#[test]
fn who_waits_too_long_for_a_lane_is_told_of_because_of_who_holds_it_for_the_longest_time() {
    for (lanes, late_us) in [(1, 20_000), (2, 9_000)] {
        let (mut scheduler, [first, second]) = robot(lanes);
        let long = add(&mut scheduler, first, 31, 100, 1);
        let shorter = add(&mut scheduler, first, 20, 100, 1);
        let elsewhere = add(&mut scheduler, second, 60, 100, 1);
        let short = add(&mut scheduler, first, 4, 10, 1);
        assert_eq!(release(&mut scheduler, elsewhere, 0), []);
        assert_eq!(release(&mut scheduler, long, 0), []);
        if lanes == 2 {
            assert_eq!(release(&mut scheduler, shorter, 0), []);
        }
        // A lane is free at 31 ms, or at 20 ms; it is due at 15 ms.
        assert_eq!(release(&mut scheduler, short, 5), [(short, late_us, Some(long))], "{lanes} lanes");
        assert_eq!(scheduler.take_warning(), None, "told once");
        assert_eq!(
            scheduler.jobs_in_flight(),
            2 + usize::from(lanes),
            "nobody is in time without it: it stays"
        );
    }
}

#[test]
fn who_goes_is_told_of_because_of_whom_and_by_how_much_it_would_have_been_late() {
    // The lane is busy until 2 ms. The lower one would be in time at 8 ms, and the higher one at 14 ms too late.
    let (mut scheduler, [first, _]) = robot(1);
    let before = add(&mut scheduler, first, 2, 100, 9);
    let low = add(&mut scheduler, first, 6, 12, 1);
    let high = add(&mut scheduler, first, 6, 13, 9);
    assert_eq!(release(&mut scheduler, before, 0), []);
    assert_eq!(release(&mut scheduler, low, 0), []);
    assert_eq!(release(&mut scheduler, high, 0), [(low, 0, Some(high))]);
    // Now the lower one comes later and would end at 14 ms.
    let (mut scheduler, [first, _]) = robot(1);
    let before = add(&mut scheduler, first, 2, 100, 9);
    let high = add(&mut scheduler, first, 6, 12, 9);
    let low = add(&mut scheduler, first, 6, 13, 1);
    assert_eq!(release(&mut scheduler, before, 0), []);
    assert_eq!(release(&mut scheduler, high, 0), []);
    assert_eq!(release(&mut scheduler, low, 0), [(low, 1_000, Some(high))]);
}

/// Keys that are equal go by release, whatever place in the table a job has.
#[test]
fn of_equal_keys_the_older_job_is_the_one_in_time() {
    let (mut scheduler, [first, second]) = robot(1);
    let elsewhere = add(&mut scheduler, second, 2, 100, 1);
    let before = add(&mut scheduler, first, 10, 100, 1);
    let (older, newer) = (add(&mut scheduler, first, 6, 19, 1), add(&mut scheduler, first, 6, 17, 1));
    let unit = start(&mut scheduler, elsewhere, 0).unit;
    assert_eq!(release(&mut scheduler, before, 0), []);
    assert_eq!(release(&mut scheduler, older, 1), []);
    scheduler.complete(unit, at(2)).expect("it runs");
    assert!(scheduler.take_outcome().is_some());
    // The newer one has the first place. Both are due at 20 ms, and end at 16 and 22.
    let told = release(&mut scheduler, newer, 3);
    assert_eq!((told.len(), told[0].0, told[0].1), (1, newer, 2_000), "{told:?}");
}

#[test]
fn who_is_late_by_its_own_work_is_told_of_because_of_nobody() {
    let (mut scheduler, [first, second]) = robot(1);
    let elsewhere = add(&mut scheduler, second, 60, 100, 1);
    let late = add(&mut scheduler, first, 9, 4, 1);
    assert_eq!(release(&mut scheduler, elsewhere, 0), []);
    assert_eq!(release(&mut scheduler, late, 1), [(late, 5_000, None)]);
}

#[test]
fn who_gets_a_lane_by_preemption_is_not_told_of() {
    for (is_atomic, preempt) in [(false, true), (true, true), (false, false)] {
        let (mut scheduler, [first, _]) = robot_of(Config { preempt, ..Config::REDRT });
        let node = Node::new(Wcet::from_millis(31));
        let node = if is_atomic { node.atomic(Contention::default()) } else { node };
        let long = add_of(&mut scheduler, node, Timing::new(Duration::from_millis(100)));
        let short = add(&mut scheduler, first, 4, 10, 1);
        assert_eq!(release(&mut scheduler, long, 0), []);
        let told = (is_atomic || !preempt).then_some((short, 20_000, Some(long)));
        assert_eq!(release(&mut scheduler, short, 5), Vec::from_iter(told), "{is_atomic} {preempt}");
    }
}

#[test]
fn what_nodes_took_of_late_counts_and_not_what_they_were_to_take() {
    for (took_ms, told_us) in [(8, Some(2_000)), (2, None)] {
        let (mut scheduler, [first, _]) = robot(1);
        let other = add(&mut scheduler, first, 3, 100, 1);
        let waits = add(&mut scheduler, first, 3, 9, 1);
        // The first one counts as no longer than its WCET.
        for job in 0..9 {
            let started = start(&mut scheduler, other, 10 * job);
            scheduler.complete(started.unit, at(10 * job + took_ms)).expect("it runs");
            while scheduler.poll(at(10 * job + took_ms)).is_some() {}
        }
        assert_eq!(release(&mut scheduler, other, 100), []);
        // By their worst cases both end within 6 ms, and by the cheap bound within 9.
        let told = told_us.map(|us| (waits, us, Some(other)));
        assert_eq!(release(&mut scheduler, waits, 100), Vec::from_iter(told), "{took_ms} ms");
    }
}

#[test]
fn a_part_of_a_microsecond_is_told_as_a_whole_one() {
    let (mut scheduler, _) = robot(1);
    let node = Node::new(Wcet::from_nanos(4_000_001));
    let late = add_of(&mut scheduler, node, Timing::new(Duration::from_millis(4)));
    assert_eq!(release(&mut scheduler, late, 0), [(late, 1, None)]);
}

#[test]
fn who_never_ends_is_told_of_as_soon_as_its_last_lane_is_lost() {
    let (mut scheduler, [first, second]) = robot(1);
    let here = add(&mut scheduler, first, 3, 100, 1);
    let busy = add(&mut scheduler, second, 3, 100, 1);
    let late = add(&mut scheduler, second, 3, 100, 1);
    let started = start(&mut scheduler, busy, 0);
    for task in [here, late] {
        assert_eq!(release(&mut scheduler, task, 0), []);
    }
    scheduler.fail(started.unit, at(1)).expect("it runs");
    assert!(scheduler.retire_lane(started.lane), "it runs nothing");
    while scheduler.poll(at(1)).is_some() {}
    let told = scheduler.take_warning().expect("the lane was its last");
    assert_eq!((told.task, told.by.as_nanos(), told.deadline), (late, u64::MAX, at(100)));
    assert_eq!(scheduler.take_warning(), None, "nobody else needs it");
}

#[test]
fn who_needs_a_pool_without_lanes_is_told_of_even_if_it_costs_nothing() {
    let (mut scheduler, [first, _]) = robot(1);
    let free = add(&mut scheduler, first, 0, 10, 1);
    assert!(scheduler.retire_lane(red_core::LaneId::new(0)));
    assert_eq!(release(&mut scheduler, free, 0).len(), 1);
}

#[test]
fn who_cannot_be_in_time_by_estimates_ranks_below_who_can_whatever_it_is_worth() {
    let (mut scheduler, [first, _]) = robot(1);
    let before = add(&mut scheduler, first, 1, 100, 9);
    // 3 and 8 ms one after the other in 10: possible at best, as best cases are 0, and not by estimates.
    let mut dag = Dag::new();
    let [a, b] =
        [3, 8].map(|ms| dag.add_node(Node::new(Wcet::from_millis(ms)).in_pool(first)).expect("it fits"));
    dag.add_edge(a, b).expect("there is no cycle");
    let timing = Timing::new(Duration::from_millis(10)).value(9);
    let worth = scheduler.add_task(&dag, timing).expect("there is room");
    let short = add(&mut scheduler, first, 4, 5, 1);
    // The first job is a probe, and ranks as if it could be in time.
    let probe = start(&mut scheduler, worth, 0);
    scheduler.fail(probe.unit, at(3)).expect("it runs");
    while scheduler.poll(at(3)).is_some() {}
    while scheduler.take_warning().is_some() {}
    assert_eq!(release(&mut scheduler, before, 100), []);
    assert_eq!(release(&mut scheduler, worth, 100).len(), 1);
    // By their keys they would run from 101 to 104 and to 108 ms, and then the rest. By rank the short one is first, and in time.
    assert_eq!(release(&mut scheduler, short, 100), []);
    assert_eq!(scheduler.jobs_in_flight(), 3, "so the other costs nobody anything");
}

#[test]
fn what_waits_on_an_idle_lane_is_counted_behind_its_predecessor() {
    let (mut scheduler, [first, _]) = robot(2);
    assert!(scheduler.dispatch_ahead(first));
    let mut dag = Dag::new();
    let [before, short, long] =
        [10, 5, 10].map(|ms| dag.add_node(Node::new(Wcet::from_millis(ms)).in_pool(first)).expect("it fits"));
    for after in [short, long] {
        dag.add_edge(before, after).expect("there is no cycle");
    }
    let fork = scheduler.add_task(&dag, Timing::new(Duration::from_millis(100))).expect("there is room");
    let other = add(&mut scheduler, first, 5, 15, 1);
    assert_eq!(release(&mut scheduler, fork, 0), []);
    // One lane is busy until 10 ms, and the other one is idle. Then they are busy until 15 and 20 ms.
    assert_eq!(release(&mut scheduler, other, 1), [(other, 4_000, Some(fork))]);
}
