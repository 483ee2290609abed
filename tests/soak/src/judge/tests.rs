use super::*;
use red_core::{JobId, LaneId, NodeId, ShedReason};
use red_workload::Format;
use red_workload::policy::Policy;

/// Node 0 before node 1; node 2 comes with an edit.
const FILE: &str = r#"
pool = [{ name = "cpu", lanes = 2 }, { name = "gpu", lanes = 1 }]
[[task]]
name = "t"
deadline = "1s"
period = "1s"
floor = [2, 3]
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
    judge_of(Policy::Redrt)
}

fn judge_of(policy: Policy) -> Judge {
    use red_core::Empty;
    let workload = red_workload::parse(FILE.as_bytes(), Format::Toml, "test").unwrap();
    let mut scheduler: Box<Scheduler<Robot>> = Box::new(Scheduler::EMPTY);
    let (plan, tasks) = build::admit(&mut scheduler, &workload, policy.config()).unwrap();
    Judge::new(scheduler, &workload, &plan, &tasks, policy)
}

/// An event at `at`, of job 0.
fn event(at: u64, kind: EventKind, node: u8, lane: u8) -> Event {
    let (node, lane) = (NodeId::new(node), LaneId::new(lane));
    Event { at: Instant::from_nanos(at), job: 0, kind, task: TaskId::from_bits(0), node, lane }
}

/// How job `index` ended.
fn outcome(index: u64, shed: Option<ShedReason>) -> Outcome {
    let (release, deadline) = (Instant::ZERO, Instant::from_nanos(1_000_000_000));
    let (job, task, at) = (JobId::from_bits(0), TaskId::from_bits(0), Instant::from_nanos(2));
    Outcome { job, task, index, release, deadline, at, shed }
}

/// What the judge says about these events of the job that was released, and about the end.
fn verdict(events: &[(u64, EventKind, u8, u8)]) -> Option<String> {
    let mut judge = judge();
    Host::released(&mut judge, 0, Instant::ZERO, Ok(JobId::from_bits(0)));
    for (at, kind, node, lane) in events {
        Host::event(&mut judge, &event(*at, *kind, *node, *lane));
    }
    let ends = events.iter().find_map(|(_, kind, ..)| match kind {
        Ended => Some(None),
        Shed(reason) => Some(Some(*reason)),
        _ => None,
    });
    Host::ended(&mut judge, &outcome(0, ends.flatten()));
    judge.none_forgotten(1);
    judge.wrong
}

use EventKind::{Completed, Edited, Ended, Preempted, Refused, Released, Shed, Started};

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
    let edited = [(0, Edited, 0, 0), RIGHT[0], RIGHT[1], RIGHT[2], RIGHT[3]];
    for (what, events, words) in [
        ("a successor before its predecessor ended", with(2, (0, Started, 1, 1)), "its predecessor 0"),
        ("a node twice", with(3, (1, Started, 0, 0)), "a second time"),
        ("two units on a lane", [&edited[..], &[(2, Started, 2, 1)]].concat(), "lane 1 still runs"),
        ("a node that the job's graph does not have", with(3, (1, Started, 2, 0)), "has no such node"),
        ("a start on a lane of another pool", with(3, (1, Started, 1, 2)), "of another pool"),
        ("an edit more than there are", [(0, Edited, 0, 0); 2].to_vec(), "than there are edits"),
        ("a completion on another lane", with(2, (1, Completed, 0, 1)), "not running on lane 1"),
        ("an end that comes too early", without(4), "with node 1"),
        ("an end twice", with(6, (2, Ended, 0, 0)), "not in flight"),
        ("a start after the job was given up", with(3, (1, Shed(ShedReason::Late), 0, 0)), "not in flight"),
        ("a job that is forgotten", without(5), "neither ended nor was given up"),
        ("a release twice", with(1, (0, Released, 0, 0)), "a second time"),
        ("a job that was refused", with(1, (0, Refused, 0, 0)), "it was not refused"),
        ("a unit that loses its lane", with(2, (0, Preempted, 0, 0)), "nobody asked"),
        (
            "an edit that reaches a job of before",
            [&[RIGHT[0], (0, Edited, 0, 0)], &RIGHT[1..3], &[(1, Started, 2, 0)]].concat(),
            "has no such node",
        ),
    ] {
        let told = verdict(&events);
        assert!(told.as_ref().is_some_and(|told| told.contains(words)), "{what}: {told:?}");
    }
}

/// What the judge says when these calls tell of job 0, whose events are right, and of others.
fn books(tell: impl FnOnce(&mut Judge), asked: u64) -> Option<String> {
    let mut judge = judge();
    Host::released(&mut judge, 0, Instant::ZERO, Ok(JobId::from_bits(0)));
    RIGHT.iter().for_each(|(at, kind, node, lane)| judge.event(&event(*at, *kind, *node, *lane)));
    tell(&mut judge);
    judge.none_forgotten(asked);
    judge.wrong
}

#[test]
fn every_release_and_every_outcome_is_accounted_for() {
    assert_eq!(books(|judge| Host::ended(judge, &outcome(0, None)), 1), None);
    type Tell = fn(&mut Judge);
    let planted: [(&str, Tell, u64, &str); 8] = [
        ("a job without an outcome", |_| {}, 1, "the outcome of (0, 0) is None"),
        ("a release that was never made", |judge| judge.ended(&outcome(0, None)), 2, "of 2 releases 1"),
        ("a release that nobody asked for", |judge| judge.ended(&outcome(0, None)), 0, "of 0 releases 1"),
        (
            "an outcome of another kind",
            |judge| judge.ended(&outcome(0, Some(ShedReason::Late))),
            1,
            "the outcome of (0, 0) is Some(Some(Late))",
        ),
        (
            "an outcome of no job",
            |judge| [0, 1].iter().for_each(|i| judge.ended(&outcome(*i, None))),
            1,
            "it was not released then",
        ),
        ("an outcome twice", |judge| (0..2).for_each(|_| judge.ended(&outcome(0, None))), 1, "a second time"),
        (
            "an outcome of another deadline",
            |judge| judge.ended(&Outcome { deadline: Instant::from_nanos(9), ..outcome(0, None) }),
            1,
            "due at another instant",
        ),
        (
            "a job that was accepted and never began",
            |judge| {
                Host::released(judge, 0, Instant::ZERO, Ok(JobId::from_bits(0)));
                (0..2).for_each(|i| judge.ended(&outcome(i, None)));
            },
            2,
            "2 jobs were accepted, 1 began",
        ),
    ];
    for (what, tell, asked, words) in planted {
        let told = books(tell, asked);
        assert!(told.as_ref().is_some_and(|told| told.contains(words)), "{what}: {told:?}");
    }
}

#[test]
fn more_than_a_floor_allows_given_up_for_urgency_is_caught() {
    let given_up = |jobs: &[u64], reason: ShedReason| {
        let mut judge = judge();
        for job in 0..4 {
            Host::released(&mut judge, 0, Instant::ZERO, Ok(JobId::from_bits(0)));
            judge.event(&Event { job, ..event(0, Released, 0, 0) });
        }
        for job in 0..4 {
            let reason = if jobs.contains(&job) { reason } else { ShedReason::Fault };
            judge.event(&Event { job, ..event(1, Shed(reason), 0, 0) });
            Host::ended(&mut judge, &outcome(job, Some(reason)));
        }
        judge.none_forgotten(4);
        judge.wrong
    };
    // Two of any three stay.
    assert_eq!(given_up(&[0, 3], ShedReason::Urgency), None);
    assert_eq!(given_up(&[0, 1, 2], ShedReason::Hopeless), None);
    assert_eq!(given_up(&[0, 1, 2], ShedReason::Overload), None);
    assert!(given_up(&[1, 3], ShedReason::Urgency).is_some_and(|why| why.contains("floor")));
}

#[test]
fn a_start_before_one_of_a_smaller_key_is_caught() {
    let second_first = |releases: [u64; 2]| {
        let mut judge = judge_of(Policy::Edf);
        for (job, release) in (0..).zip(releases) {
            Host::released(&mut judge, 0, Instant::from_nanos(release), Ok(JobId::from_bits(0)));
            judge.event(&Event { job, ..event(5, Released, 0, 0) });
        }
        judge.event(&Event { job: 1, ..event(5, Started, 0, 0) });
        judge.wrong
    };
    assert_eq!(second_first([4, 3]), None);
    assert!(second_first([3, 4]).is_some_and(|why| why.contains("whose key is smaller")));
    assert!(second_first([3, 3]).is_some_and(|why| why.contains("whose key is smaller")));
}
