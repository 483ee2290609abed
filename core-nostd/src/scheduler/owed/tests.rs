use super::*;
use crate::time::Instant;
use crate::{Caps, Config, Dag, Duration, Node, Timing, Wcet};

type Small = Caps<4, 16, 16>;

/// A task of one node, all in nanoseconds.
fn add(scheduler: &mut Scheduler<Small>, wcet: u64, due: u64, floor: (u32, u32)) -> TaskId {
    let mut dag = Dag::<Small>::new();
    dag.add_node(Node::new(Wcet::from_nanos(wcet))).unwrap();
    scheduler.add_task(&dag, Timing::new(Duration::from_nanos(due)).floor(floor.0, floor.1)).unwrap()
}

/// One lane is free from an instant on, and no other.
fn only(free: u64) -> <Small as Capacity>::Lanes<u64> {
    let mut lanes = <<Small as Capacity>::Lanes<u64>>::EMPTY;
    lanes.as_mut().fill(u64::MAX);
    lanes[0] = free;
    lanes
}

/// A node holds the lane for 10 ns. Of three jobs that are late beside each other two are so alone, and one of these has a floor.
#[test]
fn who_is_late_alone_is_lost_to_a_floor() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let long = add(&mut scheduler, 10, 10, (0, 0));
    scheduler.release(long, Instant::ZERO).unwrap();
    assert!(scheduler.poll(Instant::ZERO).is_some());
    let tasks = [(11, (1, 2)), (12, (1, 2)), (11, (0, 2))];
    let tasks = tasks.map(|(due, floor)| add(&mut scheduler, 2, due, floor));
    let slots = tasks.map(|task| {
        scheduler.release(task, Instant::ZERO).unwrap();
        scheduler.slots().find(|slot| scheduler.jobs[*slot].task == task).unwrap()
    });
    let late = slots.iter().fold(0, |late, slot| late | 1 << slot);
    let lost = |late| {
        let floors = scheduler.floors_without(late);
        tasks.map(|task| floors[task.index()].recently_lost())
    };
    assert_eq!((lost(late), lost(0)), ([1, 0, 0], [0; 3]));
}

/// Three jobs of each task have to start at 4: one of two may be lost, or two of three, or all.
#[test]
fn what_a_node_makes_late_is_lost_as_far_as_the_floor_can_spare_it() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let tasks = [(1, 2), (1, 3), (0, 3), (2, 2)].map(|floor| add(&mut scheduler, 1, 5, floor));
    for task in tasks.iter().cycle().take(12) {
        scheduler.release(*task, Instant::ZERO).unwrap();
    }
    let lost = |own: TaskId, free| {
        let floors = scheduler.floors_behind(0, own, &only(free));
        tasks.map(|task| floors[task.index()].recently_lost())
    };
    let [first, second, ..] = tasks;
    assert_eq!((lost(tasks[2], 5), lost(tasks[2], 4)), ([2, 2, 0, 0], [0; 4]));
    assert_eq!((lost(first, 5), lost(second, 5)), ([0, 2, 0, 0], [2, 0, 0, 0]));
}

/// What runs is not behind a node that starts now.
#[test]
fn what_has_started_is_not_made_late() {
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT);
    let [runs, other] = [5, 9].map(|due| add(&mut scheduler, 5, due, (1, 2)));
    for task in [runs, other] {
        scheduler.release(task, Instant::ZERO).unwrap();
    }
    let lost = |scheduler: &Scheduler<Small>, free| {
        let floors = scheduler.floors_behind(0, other, &only(free));
        floors[runs.index()].recently_lost()
    };
    assert_eq!((lost(&scheduler, 0), lost(&scheduler, 1)), (0, 1));
    assert!(scheduler.poll(Instant::ZERO).is_some());
    assert_eq!(lost(&scheduler, 1), 0);
}
