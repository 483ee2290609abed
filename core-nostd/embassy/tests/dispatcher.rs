//! Dispatcher and lanes on embassy's executor, with a clock that the test moves. A tick is a microsecond.

mod board;

use std::cell::{Cell, RefCell};
use std::future::poll_fn;
use std::rc::Rc;
use std::task::{Poll, Waker};

use board::{Board, begin_at, wait};
use red_core::{
    Caps, Config, Dag, Duration, LaneId, Late, Node, Shed, ShedReason, TaskId, Timing, Unit, Wcet,
};
use red_embassy::{Dispatcher, Fault, LaneError, PostError, now};

type Robot = Caps<4, 8, 8>;
type Red = Dispatcher<Robot, 4>;

fn red(lanes: u8) -> &'static Red {
    let red: &'static Red = Box::leak(Box::new(Dispatcher::new()));
    red.configure(Config::REDRT.with_lanes(lanes));
    red
}

fn chain(micros: &[u64]) -> Dag<Robot> {
    let mut dag = Dag::new();
    let mut last = None;
    for us in micros {
        let node = dag.add_node(Node::new(Wcet::from_nanos(us * 1_000))).expect("room");
        if let Some(last) = last {
            dag.add_edge(last, node).expect("forwards");
        }
        last = Some(node);
    }
    dag
}

fn add(red: &Red, micros: &[u64], deadline_us: u64) -> TaskId {
    let timing = Timing::new(Duration::from_micros(deadline_us));
    red.with(|scheduler| scheduler.add_task(&chain(micros), timing)).expect("it is admitted")
}

/// Runs lane `lane`, and notes the task of each body when it begins.
fn lane(board: &Board, red: &'static Red, lane: u8, order: &Rc<RefCell<Vec<(TaskId, u8)>>>) {
    let order = Rc::clone(order);
    board.spawn(move || async move {
        let body = |unit: Unit| {
            order.borrow_mut().push((unit.first.task, lane));
            async { Ok(()) }
        };
        red.run_lane(LaneId::new(lane), body).await
    });
}

#[test]
fn handlers_run_in_the_order_of_their_sub_deadlines() {
    let (board, red, order) = (Board::new(), red(3), Rc::default());
    let _ended = board.dispatcher(red);
    (0..3).for_each(|number| lane(&board, red, number, &order));
    // Handed out by latest start, 50, 290 and 590: the lanes are woken in that order, which embassy keeps where
    // deadlines are equal.
    let [a, b, c] =
        [(850, 900), (10, 300), (10, 600)].map(|(cost_us, deadline_us)| add(red, &[cost_us], deadline_us));
    board.poll();
    for task in [a, b, c] {
        red.release_from_interrupt(task).expect("room");
    }
    board.poll();
    assert_eq!(*order.borrow(), [(b, 1), (c, 2), (a, 0)]);
}

#[test]
fn an_urgent_unit_goes_before_a_body_that_is_woken_but_has_not_begun() {
    let (board, red, order) = (Board::new(), red(2), Rc::default());
    let _ended = board.dispatcher(red);
    (0..2).for_each(|number| lane(&board, red, number, &order));
    let (relaxed, urgent) = (add(red, &[10], 5_000), add(red, &[10], 100));
    // A task between the two, which releases the urgent job while the relaxed body stands in line.
    let sensor: Rc<RefCell<Option<Waker>>> = Rc::default();
    let own = Rc::clone(&sensor);
    board.spawn(move || async move {
        embassy_executor::Metadata::for_current_task().await.set_deadline(1_000);
        poll_fn(|context| match own.borrow_mut().replace(context.waker().clone()) {
            None => Poll::Pending,
            Some(_) => {
                red.release_from_interrupt(urgent).expect("room");
                Poll::Ready(())
            }
        })
        .await;
    });
    board.poll();
    red.release_from_interrupt(relaxed).expect("room");
    sensor.borrow().iter().for_each(Waker::wake_by_ref);
    board.poll();
    assert_eq!(*order.borrow(), [(urgent, 1), (relaxed, 0)]);
}

#[test]
fn a_chain_runs_to_its_end() {
    let (board, red) = (Board::new(), red(1));
    let ended = board.dispatcher(red);
    let nodes = Rc::new(RefCell::new(Vec::new()));
    let list = Rc::clone(&nodes);
    board.spawn(move || async move {
        let body = |unit: Unit| {
            list.borrow_mut().push((unit.first.node.index(), now().as_nanos()));
            async {
                wait(10).await;
                Ok(())
            }
        };
        red.run_lane(LaneId::new(0), body).await
    });
    let task = add(red, &[10, 10, 10], 100);
    board.pass(5);
    red.release_from_interrupt(task).expect("room");
    board.pass(50);
    assert_eq!(*nodes.borrow(), [(0, 6_000), (1, 16_000), (2, 26_000)]);
    let [job] = ended.borrow()[..] else { panic!("one job: {ended:?}") };
    assert!(job.on_time());
    assert_eq!((job.release.as_nanos(), job.at.as_nanos()), (5_000, 36_000));
}

#[test]
fn a_counter_that_wraps_in_mid_job_keeps_the_order() {
    // Row 21: the first node ends before the counter wraps, the others after.
    begin_at(u32::MAX - 20);
    let (board, red) = (Board::new(), red(1));
    let ended = board.dispatcher(red);
    let order: Rc<RefCell<Vec<TaskId>>> = Rc::default();
    let list = Rc::clone(&order);
    board.spawn(move || async move {
        let body = |unit: Unit| {
            list.borrow_mut().push(unit.first.task);
            async {
                wait(10).await;
                Ok(())
            }
        };
        red.run_lane(LaneId::new(0), body).await
    });
    let (long, short) = (add(red, &[10, 10, 10], 200), add(red, &[10], 100));
    board.poll();
    let before = now();
    red.release_from_interrupt(long).expect("room");
    board.pass(15);
    red.release_from_interrupt(short).expect("room");
    board.pass(60);
    assert_eq!(*order.borrow(), [long, long, short, long]);
    assert!(ended.borrow().iter().all(red_core::Outcome::on_time), "{ended:?}");
    assert_eq!(now().since(before), Duration::from_micros(75));
    assert!(now().as_nanos() > u64::from(u32::MAX) * 1_000, "the counter wrapped");
}

#[test]
fn a_body_that_waits_lets_others_run() {
    let (board, red) = (Board::new(), red(2));
    let ended = board.dispatcher(red);
    let running = Rc::new(Cell::new((0, 0)));
    for number in 0..2 {
        let running = Rc::clone(&running);
        board.spawn(move || async move {
            let body = |_| {
                let running = Rc::clone(&running);
                async move {
                    let (now, most) = running.get();
                    running.set((now + 1, most.max(now + 1)));
                    wait(20).await;
                    running.set((running.get().0 - 1, running.get().1));
                    Ok(())
                }
            };
            red.run_lane(LaneId::new(number), body).await
        });
    }
    let tasks = [add(red, &[20], 500), add(red, &[20], 400)];
    for task in tasks {
        red.release_from_interrupt(task).expect("room");
    }
    board.pass(30);
    assert_eq!(running.get(), (0, 2));
    assert_eq!(ended.borrow().len(), 2);
}

#[test]
fn the_dispatcher_sleeps_until_a_deadline() {
    // Nobody runs the lane and nothing else happens: only the dispatcher's timer can end the job.
    let (board, red) = (Board::new(), red(1));
    red.configure(Config { late: Late::AbortJob, shed: Shed::Never, ..Config::REDRT });
    let ended = board.dispatcher(red);
    let task = add(red, &[10], 1_000);
    red.release_from_interrupt(task).expect("room");
    board.pass(1_000);
    assert!(ended.borrow().is_empty(), "{ended:?}");
    board.pass(2);
    let [job] = ended.borrow()[..] else { panic!("one job: {ended:?}") };
    assert_eq!(job.shed, Some(ShedReason::Late));
}

#[test]
fn a_full_mailbox_is_told_and_counted() {
    let (board, red) = (Board::new(), red(1));
    let ended = board.dispatcher(red);
    let task = add(red, &[10], 1_000);
    let posted = [(); 6].map(|()| red.release_from_interrupt(task));
    assert_eq!(posted, [Ok(()), Ok(()), Ok(()), Ok(()), Err(PostError::Full), Err(PostError::Full)]);
    assert_eq!(red.lost_releases(), 2);
    // Nobody runs the lane. The scheduler has eight places: the ninth release and those after it are lost.
    for _ in 0..2 {
        board.poll();
        for _ in 0..4 {
            let _ = red.release_from_interrupt(task);
        }
    }
    board.poll();
    assert_eq!(red.lost_releases(), 2 + 4);
    assert_eq!(red.with(|scheduler| scheduler.jobs_in_flight()), 8);
    assert!(ended.borrow().is_empty());
}

#[test]
fn a_body_that_fails_gives_its_job_up() {
    let (board, red) = (Board::new(), red(1));
    let ended = board.dispatcher(red);
    board.spawn(move || async move { red.run_lane(LaneId::new(0), |_| async { Err(Fault) }).await });
    let task = add(red, &[10, 10], 100);
    red.release_from_interrupt(task).expect("room");
    board.poll();
    let [job] = ended.borrow()[..] else { panic!("one job: {ended:?}") };
    assert_eq!(job.shed, Some(ShedReason::Fault));
}

#[test]
fn a_lane_has_one_task_and_must_be_there() {
    let (board, red) = (Board::new(), red(1));
    let refused = Rc::new(RefCell::new(Vec::new()));
    for number in [0, 0, 4] {
        let refused = Rc::clone(&refused);
        board.spawn(move || async move {
            let why = red.run_lane(LaneId::new(number), |_| async { Ok(()) }).await;
            refused.borrow_mut().push((number, why));
        });
    }
    board.poll();
    refused.borrow_mut().sort_by_key(|(number, _)| *number);
    assert_eq!(*refused.borrow(), [(0, LaneError::Taken), (4, LaneError::Unknown)]);
}
