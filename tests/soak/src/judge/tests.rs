use super::*;
use red_core::{LaneId, NodeId};
use red_workload::Format;
use red_workload::policy::Policy;

/// Node 0 before node 1; node 2 comes with an edit.
const FILE: &str = r#"
pool = [{ name = "cpu", lanes = 2 }]
[[task]]
name = "t"
deadline = "1s"
period = "1s"
[[task.node]]
name = "a"
wcet = "1ms"
[[task.node]]
name = "b"
after = ["a"]
wcet = "1ms"
[[event]]
at = "1ms"
task = "t"
add = [{ name = "c", wcet = "1ms", after = ["a"] }]
"#;

fn judge() -> Judge {
    use red_core::Empty;
    let workload = red_workload::parse(FILE.as_bytes(), Format::Toml, "test").unwrap();
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &workload, Policy::Redrt.config()).unwrap();
    Judge::new(scheduler, &plan, &tasks, 2)
}

/// An event at `at`, of job 0.
fn event(at: u64, kind: EventKind, node: u8, lane: u8) -> Event {
    let (node, lane) = (NodeId::new(node), LaneId::new(lane));
    Event { at: Instant::from_nanos(at), job: 0, kind, task: TaskId::from_bits(0), node, lane }
}

/// What the judge says about these events, and about the end.
fn verdict(events: &[(u64, EventKind, u8, u8)]) -> Option<String> {
    let mut judge = judge();
    for (at, kind, node, lane) in events {
        Host::event(&mut judge, &event(*at, *kind, *node, *lane));
    }
    judge.none_forgotten();
    judge.wrong
}

use EventKind::{Completed, Edited, Ended, Released, Shed, Started};

const RIGHT: [(u64, EventKind, u8, u8); 6] = [
    (0, Released, 0, 0),
    (0, Started, 0, 0),
    (1, Completed, 0, 0),
    (1, Started, 1, 1),
    (2, Completed, 1, 1),
    (2, Ended, 0, 0),
];

#[test]
fn a_run_as_it_should_be_is_clean() {
    assert_eq!(verdict(&RIGHT), None);
    assert_eq!(verdict(&[RIGHT[0], RIGHT[1], (1, Shed(red_core::ShedReason::Fault), 0, 0)]), None);
}

#[test]
fn every_planted_fault_is_caught() {
    let without = |gone: usize| {
        let mut events = RIGHT.to_vec();
        events.remove(gone);
        events
    };
    let with = |place: usize, planted: (u64, EventKind, u8, u8)| {
        let mut events = RIGHT.to_vec();
        events.insert(place, planted);
        events
    };
    for (what, events) in [
        ("a successor before its predecessor ended", with(2, (0, Started, 1, 1))),
        ("a node twice", with(3, (1, Started, 0, 0))),
        ("two units on a lane", with(4, (2, Started, 2, 1))),
        ("a node that the job's graph does not have", with(3, (1, Started, 2, 0))),
        ("a completion on another lane", with(2, (1, Completed, 0, 1))),
        ("an end that comes too early", without(4)),
        ("an end twice", with(6, (2, Ended, 0, 0))),
        ("a start after the job was given up", with(3, (1, Shed(red_core::ShedReason::Late), 0, 0))),
        ("a job that is forgotten", without(5)),
        ("a release twice", with(1, (0, Released, 0, 0))),
        (
            "an edit that reaches a job of before",
            [&[RIGHT[0], (0, Edited, 0, 0)], &RIGHT[1..3], &[(1, Started, 2, 0)]].concat(),
        ),
    ] {
        assert!(verdict(&events).is_some(), "not caught: {what}");
    }
}
