//! What the documentation promises in passing, and larger tests would not miss.

use red_core::{
    Action, Bytes, Caps, CompleteError, Config, CostEstimate, Dag, DeadlineRule, Duration, Estimator,
    EventKind, Frame, Instant, JobId, LaneId, Late, Levels, Node, NodeError, NodeId, Overload, Scheduler,
    Shed, SubDeadlines, TaskId, Timing, UnitId, Wcet,
};

type Small = Caps<2, 4, 3, 2, 1, 1, 16>;

fn at_ms(ms: u64) -> Instant {
    Instant::ZERO.saturating_add(Duration::from_millis(ms))
}

fn chain(costs: &[u64]) -> Dag<Small> {
    let mut dag = Dag::new();
    let node = |cost| Node::new(Wcet::from_millis(cost)).best_case(Duration::from_millis(cost));
    let nodes = costs.iter().map(|cost| dag.add_node(node(*cost)).unwrap());
    let nodes: Vec<NodeId> = nodes.collect();
    nodes.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).unwrap());
    dag
}

fn task(scheduler: &mut Scheduler<Small>, costs: &[u64], deadline_ms: u64) -> TaskId {
    scheduler.add_task(&chain(costs), Timing::new(Duration::from_millis(deadline_ms))).unwrap()
}

/// The unit that starts now, if one does; what else there is to do is done.
fn start(scheduler: &mut Scheduler<Small>, now: Instant) -> Option<UnitId> {
    let mut started = None;
    while let Some(action) = scheduler.poll(now) {
        if let Action::Dispatch(dispatch) = action {
            started = Some(dispatch.unit);
        }
    }
    started
}

#[test]
fn a_duration_is_shown_in_the_largest_unit_that_it_has_one_of() {
    let shown = [0, 999, 1_000, 999_999, 1_000_000, 1_234_567, 1_000_000_000, 61_500_000_000];
    let shown = shown.map(|ns| Duration::from_nanos(ns).to_string());
    let expected =
        ["0 ns", "999 ns", "1.000 us", "999.999 us", "1.000 ms", "1.234 ms", "1.000 s", "61.500 s"];
    assert_eq!(shown, expected);
}

#[test]
fn an_estimate_is_of_the_last_eight_samples_however_many_there_were() {
    let mut estimator = Estimator::new(&Node::new(Wcet::from_millis(1)));
    for taken in 1..=40_u64 {
        estimator.push(Duration::from_nanos(taken * 100));
        let last = taken.saturating_sub(7).max(1)..=taken;
        let mean = last.clone().sum::<u64>() * 100 / (last.clone().count() as u64);
        assert_eq!(estimator.mean(), Some(CostEstimate::from_nanos(mean)), "after {taken}");
        assert_eq!(estimator.minimum(), Some(Duration::from_nanos(last.start() * 100)), "after {taken}");
        assert_eq!(estimator.maximum(), Some(Duration::from_nanos(taken * 100)), "after {taken}");
    }
}

#[test]
fn events_of_tasks_and_jobs_have_their_time() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1], 10);
    scheduler.release(task, at_ms(3)).unwrap();
    let edit = scheduler.edit(task).unwrap();
    let _fits = scheduler.commit(&edit, at_ms(4)).unwrap();
    let events = std::iter::from_fn(|| scheduler.take_event().copied());
    let of = |kind| move |event: &red_core::Event| event.kind == kind;
    let events: Vec<_> = events.collect();
    let times = [EventKind::Released, EventKind::Edited]
        .map(|kind| events.iter().find(|event| of(kind)(event)).map(|event| event.at));
    assert_eq!(times, [Some(at_ms(3)), Some(at_ms(4))]);
}

#[test]
fn a_new_node_has_no_name_that_a_job_of_an_older_graph_uses() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1, 1, 1, 1], 10);
    scheduler.release(task, Instant::ZERO).unwrap();
    let mut edit = scheduler.edit(task).unwrap();
    let gone = edit.nodes().last().unwrap();
    assert!(edit.remove_node(gone));
    let _fits = scheduler.commit(&edit, Instant::ZERO).unwrap();
    let add = |scheduler: &Scheduler<Small>| {
        scheduler.edit(task).unwrap().add_node(Node::new(Wcet::from_millis(1)))
    };
    assert_eq!(add(&scheduler), Err(NodeError::Full));
    while let Some(unit) = start(&mut scheduler, Instant::ZERO) {
        scheduler.complete(unit, Instant::ZERO).unwrap();
    }
    assert_eq!(add(&scheduler), Ok(gone));
}

#[test]
fn a_node_is_known_as_long_as_a_job_has_it() {
    let mut scheduler = Scheduler::new(Config::EDF);
    let task = task(&mut scheduler, &[1, 1], 50);
    let gone = NodeId::new(1);
    scheduler.release(task, at_ms(0)).unwrap();
    let unit = start(&mut scheduler, at_ms(0)).expect("one that runs");
    let mut edit = scheduler.edit(task).unwrap();
    assert!(edit.remove_node(gone));
    assert!(scheduler.commit(&edit, at_ms(0)).unwrap().fits());
    assert!(scheduler.task_node(task, gone).is_some(), "a job is about to run it");
    assert_eq!(scheduler.fail(unit, at_ms(1)), Ok(()));
    assert!(scheduler.task_node(task, gone).is_none(), "its place may be another's");
}

#[test]
fn a_job_takes_over_nothing_of_one_that_was_suspended_in_its_place() {
    let config = Config { preempt: true, late: Late::AbortJob, ..Config::REDRT.with_lanes(1) };
    let mut scheduler = Scheduler::<Small>::new(config);
    let mut dag = Dag::new();
    let whole = Duration::from_millis(10);
    dag.add_node(Node::new(Wcet::from_millis(10)).best_case(whole)).unwrap();
    let long = scheduler.add_task(&dag, Timing::new(Duration::from_millis(15))).unwrap();
    let short = Timing::new(Duration::from_millis(10)).value(2);
    let short = scheduler.add_task(&chain(&[9]), short).unwrap();
    let first: JobId = scheduler.release(long, at_ms(0)).unwrap();
    assert!(start(&mut scheduler, at_ms(0)).is_some());
    // The long job has run for a millisecond when it loses its lane, and cannot make it afterwards.
    scheduler.release(short, at_ms(1)).unwrap();
    let urgent = start(&mut scheduler, at_ms(1)).expect("it takes the lane");
    scheduler.complete(urgent, at_ms(10)).unwrap();
    assert_eq!(start(&mut scheduler, at_ms(10)), None, "the long job was given up");
    let second = scheduler.release(long, at_ms(10)).unwrap();
    assert_eq!(second.index(), first.index(), "it has the place of the other");
    let unit = start(&mut scheduler, at_ms(10)).expect("the lane is free");
    assert_eq!(unit.lane(), LaneId::new(0));
    scheduler.complete(unit, at_ms(14)).unwrap();
    let (_, estimator) = scheduler.task_node(long, unit.node()).unwrap();
    assert_eq!(estimator.mean(), Some(CostEstimate::from_millis(4)));
}

#[test]
fn a_node_that_was_suspended_took_what_it_ran_before_and_after() {
    let config = Config { preempt: true, ..Config::REDRT.with_lanes(1) };
    let mut scheduler = Scheduler::<Small>::new(config);
    let (long, short) = (task(&mut scheduler, &[1, 10], 40), task(&mut scheduler, &[9], 10));
    scheduler.release(long, at_ms(0)).unwrap();
    let head = start(&mut scheduler, at_ms(0)).unwrap();
    scheduler.complete(head, at_ms(1)).unwrap();
    assert!(start(&mut scheduler, at_ms(1)).is_some());
    scheduler.release(short, at_ms(3)).unwrap();
    let urgent = start(&mut scheduler, at_ms(3)).expect("it takes the lane");
    scheduler.complete(urgent, at_ms(12)).unwrap();
    let again = start(&mut scheduler, at_ms(12)).expect("the lane is free");
    scheduler.complete(again, at_ms(19)).unwrap();
    let (_, estimator) = scheduler.task_node(long, again.node()).unwrap();
    assert_eq!(estimator.mean(), Some(CostEstimate::from_millis(2 + 7)));
}

#[test]
fn a_result_is_not_overwritten_while_a_decoder_of_a_removed_task_reads_it() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT.with_lanes(2));
    let mut dag = Dag::new();
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let encoder = dag.add_node(Node::shared_encoder(Wcet::from_millis(1), frame)).unwrap();
    let decoder = dag.add_node(Node::decoder(Wcet::from_millis(5))).unwrap();
    dag.add_edge(encoder, decoder).unwrap();
    let [removed, stays] =
        [0; 2].map(|_| scheduler.add_task(&dag, Timing::new(Duration::from_millis(20))).unwrap());
    let result = |scheduler: &Scheduler<Small>, unit| scheduler.unit(unit).unwrap().output.unwrap();

    scheduler.release(removed, at_ms(0)).unwrap();
    let writer = start(&mut scheduler, at_ms(0)).unwrap();
    scheduler.complete(writer, at_ms(1)).unwrap();
    let reader = start(&mut scheduler, at_ms(1)).unwrap();
    let read = result(&scheduler, reader);
    assert!(scheduler.remove_task(removed, at_ms(2)));
    scheduler.release(stays, at_ms(2)).unwrap();
    let writer = start(&mut scheduler, at_ms(2)).unwrap();
    assert_ne!(result(&scheduler, writer), read);

    // Nobody reads it any more.
    scheduler.complete(writer, at_ms(3)).unwrap();
    assert_eq!(scheduler.complete(reader, at_ms(3)), Err(CompleteError::Late));
    scheduler.release(stays, at_ms(3)).unwrap();
    let next = start(&mut scheduler, at_ms(3)).unwrap();
    assert_eq!(
        (next.node(), result(&scheduler, next)),
        (encoder, read),
        "after the decoder of the job before"
    );
}

#[test]
fn events_that_find_no_room_are_counted() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1], 10);
    for ms in 0..20 {
        scheduler.release(task, at_ms(ms)).unwrap();
        let unit = start(&mut scheduler, at_ms(ms)).unwrap();
        scheduler.complete(unit, at_ms(ms)).unwrap();
    }
    let dropped = scheduler.events_dropped();
    let kept = std::iter::from_fn(|| scheduler.take_event().copied()).count() as u64;
    assert_eq!(kept, 16);
    assert!(dropped >= 3 * 20 - kept, "{dropped} of a release, a start and an end each of 20 jobs");
}

#[test]
fn a_lane_that_asks_for_its_next_unit_keeps_its_chain() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT.with_lanes(2));
    let task = task(&mut scheduler, &[1, 1], 10);
    scheduler.release(task, at_ms(0)).unwrap();
    let last = LaneId::new(1);
    let Some(Action::Dispatch(first)) = scheduler.poll_on(last, at_ms(0)) else { panic!("a lane is free") };
    assert_eq!(first.lane, last);
    let next = scheduler.complete_and_poll(first.unit, at_ms(1)).unwrap();
    let Some(Action::Dispatch(second)) = next else { panic!("the next of the chain is ready") };
    assert_eq!(second.lane, last);
}

#[test]
fn a_certificate_says_whether_nodes_may_wait_for_memory() {
    let mut dag = Dag::<Small>::new();
    for bytes in [2, 3, 4] {
        dag.add_node(Node::new(Wcet::from_millis(1)).memory(Bytes(bytes))).unwrap();
    }
    // The two largest run beside each other at most.
    for (budget, holds) in [(6, false), (7, true)] {
        let mut scheduler = Scheduler::new(Config::REDRT.with_lanes(2).with_memory(Bytes(budget)));
        let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(10))).unwrap();
        assert_eq!(scheduler.certificate(task).unwrap().memory_holds, holds, "{budget} bytes");
    }
}

#[test]
fn a_job_may_end_at_its_deadline_whatever_else_ends_then() {
    let config = Config { late: Late::AbortJob, shed: Shed::Never, ..Config::REDRT.with_lanes(2) };
    let mut scheduler = Scheduler::<Small>::new(config);
    let (late, on_time) = (task(&mut scheduler, &[5], 9), task(&mut scheduler, &[10], 10));
    scheduler.release(on_time, at_ms(0)).unwrap();
    let unit = start(&mut scheduler, at_ms(0)).unwrap();
    scheduler.release(late, at_ms(0)).unwrap();
    assert!(start(&mut scheduler, at_ms(0)).is_some());
    let Some(Action::Ended(given_up)) = scheduler.poll(at_ms(10)) else { panic!("one is late") };
    assert_eq!((given_up.task, scheduler.poll(at_ms(10))), (late, None));
    assert_eq!(scheduler.complete(unit, at_ms(10)), Ok(()));
}

/// Also after a look at something else.
#[test]
fn the_next_instant_to_decide_is_when_the_first_job_is_late() {
    let config = Config { late: Late::AbortJob, shed: Shed::Never, ..Config::REDRT.with_lanes(1) };
    let mut scheduler = Scheduler::<Small>::new(config);
    let (first, second) = (task(&mut scheduler, &[20], 9), task(&mut scheduler, &[5], 12));
    scheduler.release(first, at_ms(0)).unwrap();
    scheduler.release(second, at_ms(0)).unwrap();
    assert!(start(&mut scheduler, at_ms(0)).is_some());
    let just_after = |ms| Some(at_ms(ms).saturating_add(Duration::from_nanos(1)));
    assert_eq!(scheduler.poll_at(), just_after(9));
    assert!(matches!(scheduler.poll(just_after(9).unwrap()), Some(Action::Ended(_))));
    assert_eq!((scheduler.poll(just_after(9).unwrap()), scheduler.poll_at()), (None, just_after(12)));
}

#[test]
fn a_unit_whose_job_is_gone_keeps_its_lane_whoever_has_the_place_of_the_job() {
    let config = Config { preempt: true, ..Config::REDRT.with_lanes(1) };
    let mut scheduler = Scheduler::<Small>::new(config);
    let (long, short) = (task(&mut scheduler, &[10], 40), task(&mut scheduler, &[1], 5));
    let first = scheduler.release(long, at_ms(0)).unwrap();
    let gone = start(&mut scheduler, at_ms(0)).unwrap();
    assert!(scheduler.remove_task(long, at_ms(1)));
    assert!(scheduler.take_outcome().is_some());
    let other = task(&mut scheduler, &[10], 40);
    assert_eq!(scheduler.release(other, at_ms(1)).unwrap().index(), first.index());
    scheduler.release(short, at_ms(1)).unwrap();
    while let Some(action) = scheduler.poll(at_ms(1)) {
        assert!(matches!(action, Action::Ended(_)), "{action:?}");
    }
    assert_eq!(scheduler.complete(gone, at_ms(2)), Err(CompleteError::Late));
    assert!(start(&mut scheduler, at_ms(2)).is_some());
}

#[test]
fn ready_sub_jobs_are_counted_until_they_start() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1, 1], 10);
    assert_eq!(scheduler.ready_sub_jobs(), 0);
    for _ in 0..2 {
        scheduler.release(task, at_ms(0)).unwrap();
    }
    assert_eq!(scheduler.ready_sub_jobs(), 2);
    assert!(start(&mut scheduler, at_ms(0)).is_some());
    assert_eq!(scheduler.ready_sub_jobs(), 1);
}

#[test]
fn a_node_that_no_graph_of_the_task_has_is_not_known() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1, 1], 10);
    let known = [0, 1, 2, 3, 4, 255].map(|node| scheduler.task_node(task, NodeId::new(node)).is_some());
    assert_eq!(known, [true, true, false, false, false, false]);
}

#[test]
fn a_job_that_was_given_up_is_not_on_time_and_one_that_ends_late_is_not() {
    let mut scheduler = Scheduler::<Small>::new(Config { shed: Shed::Never, ..Config::REDRT });
    let task = task(&mut scheduler, &[1], 10);
    let mut ended = |fails: bool, end_ms: u64| {
        scheduler.release(task, at_ms(end_ms - 10)).unwrap();
        let unit = start(&mut scheduler, at_ms(end_ms - 10)).unwrap();
        let late = at_ms(end_ms).saturating_add(Duration::from_nanos(u64::from(end_ms == 80)));
        if fails { scheduler.fail(unit, late) } else { scheduler.complete(unit, late) }.unwrap();
        scheduler.take_outcome().unwrap().on_time()
    };
    assert_eq!(
        [ended(false, 20), ended(true, 40), ended(false, 60), ended(false, 80)],
        [true, false, true, false]
    );
}

#[test]
fn each_execution_beyond_its_wcet_is_counted() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let task = task(&mut scheduler, &[1], 10);
    for (job, took) in [1, 2, 1, 3, 4].into_iter().enumerate() {
        let now = at_ms(20 * job as u64);
        scheduler.release(task, now).unwrap();
        let unit = start(&mut scheduler, now).unwrap();
        scheduler.complete(unit, now.saturating_add(Duration::from_millis(took))).unwrap();
        assert!(scheduler.take_outcome().is_some());
    }
    assert_eq!(scheduler.counters().overruns, 3);
}

#[test]
fn where_no_events_are_kept_none_are_dropped() {
    let mut scheduler = Scheduler::<Caps<1, 4, 3, 2>>::new(Config::REDRT);
    let mut dag = Dag::new();
    dag.add_node(Node::new(Wcet::from_millis(1))).unwrap();
    let task = scheduler.add_task(&dag, Timing::new(Duration::from_millis(10))).unwrap();
    scheduler.release(task, at_ms(0)).unwrap();
    assert_eq!(scheduler.take_event(), None);
    assert_eq!(scheduler.events_dropped(), 0);
}

#[test]
fn a_node_that_no_graph_can_have_is_due_at_zero() {
    let dag = chain(&[1, 1]);
    let levels = Levels::of(&dag);
    let due = SubDeadlines::assign(&levels, DeadlineRule::LatestStart, Duration::from_millis(10), &[1]);
    let of = |node| (due.sub_deadline(NodeId::new(node)), due.key(NodeId::new(node)));
    assert_eq!(of(1), (10_000_000, 9_000_000));
    assert_eq!((of(4), of(255)), ((0, 0), (0, 0)));
}

#[test]
fn the_last_instant_of_the_clock_is_one_like_others() {
    let config = Config::RED;
    let tick = Duration::from_nanos(1);
    let mut scheduler = Scheduler::new(Config { overload: Overload { tick, ..config.overload }, ..config });
    let task = task(&mut scheduler, &[1], 10);
    scheduler.release(task, Instant::ZERO).unwrap();
    let unit = start(&mut scheduler, Instant::ZERO).expect("a job is released");
    assert_eq!(start(&mut scheduler, Instant::MAX), None);
    scheduler.complete(unit, Instant::MAX).unwrap();
    assert_eq!((start(&mut scheduler, Instant::MAX), scheduler.jobs_in_flight()), (None, 0));
}

#[test]
fn at_the_end_of_the_clock_no_tick_is_due() {
    let mut scheduler = Scheduler::<Small>::new(Config::RED);
    let task = task(&mut scheduler, &[1], 1);
    scheduler.release(task, Instant::ZERO).unwrap();
    assert!(start(&mut scheduler, Instant::ZERO).is_some());
    assert_eq!(start(&mut scheduler, Instant::MAX), None);
    assert_eq!(scheduler.poll_at(), None);
}
