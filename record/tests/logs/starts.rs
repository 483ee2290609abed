//! What a host is told with a start beyond what the entry of it has: a log is replayed to the same of it, or differs.

use crate::jobs::{LANE, at, chain, fed_to};
use crate::{Scratch, Small, header};
use red_core::{
    Action, Config, Dag, DeadlineRule, Duration, Empty, Frame, Node, Scheduler, TaskId, Timing, Wcet,
};
use red_record::{Answer, Call, End, Reader, Recorder, Replay, Writer, replay};
use std::fs;

/// One task of these nodes in a row.
fn scheduler(config: Config, nodes: &[Node]) -> Box<Scheduler<Small>> {
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(config);
    let dag: Dag<Small> = chain(nodes);
    scheduler.add_task(&dag, Timing::new(Duration::from_millis(50))).expect("room");
    scheduler
}

/// What the end was as recorded and as replayed, if it differs; nothing else does.
fn ends(found: &Replay) -> Option<[End; 2]> {
    let difference = found.difference.as_ref()?;
    assert_eq!((difference.recorded.call, difference.input), (Call::End, found.inputs), "{difference:?}");
    let (Answer::End(recorded), Answer::End(replayed)) = (difference.recorded.answer, difference.now) else {
        panic!("{difference:?}")
    };
    Some([recorded, replayed])
}

/// The replay of a job ends otherwise, and only in what their starts were.
fn starts_differ(name: &str, with: impl Fn(bool) -> Box<Scheduler<Small>>) {
    let jobs = [(0, None)];
    let same = fed_to(name, with(true), Some(LANE), with(true), &jobs);
    assert!(same.difference.is_none(), "{name}: {same:?}");
    let found = fed_to(name, with(true), Some(LANE), with(false), &jobs);
    let [recorded, replayed] = ends(&found).unwrap_or_else(|| panic!("{name}: no difference"));
    assert_ne!(recorded.starts, replayed.starts, "{name}");
    assert_eq!(recorded, End { starts: recorded.starts, ..replayed }, "{name}");
}

#[test]
fn another_number_of_a_result_is_a_difference() {
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let plain = || Node::new(Wcet::from_millis(1));
    starts_differ("output", |is_encoder| {
        let first = if is_encoder { Node::shared_encoder(Wcet::from_millis(1), frame) } else { plain() };
        let last = if is_encoder { Node::decoder(Wcet::from_millis(1)) } else { plain() };
        scheduler(Config::EDF, &[first, last])
    });
}

#[test]
fn another_execution_time_is_a_difference() {
    starts_differ("wcet", |longer| {
        let node = Node::new(Wcet::from_millis(if longer { 3 } else { 2 }));
        scheduler(Config::EDF, &[node])
    });
}

#[test]
fn another_sub_deadline_is_a_difference() {
    starts_differ("sub-deadline", |latest| {
        let rule = if latest { DeadlineRule::LatestStart } else { Config::EDF.rule };
        scheduler(Config { rule, ..Config::EDF }, &[Node::new(Wcet::from_millis(1)); 2])
    });
}

#[test]
fn a_job_that_is_left_open_is_a_difference() {
    let file = Scratch::new("left-open");
    let (writer, mut tape) = Writer::start(&file.0, &header()).expect("a folder for temporary files");
    let mut recorded = scheduler(Config::EDF, &[Node::new(Wcet::from_millis(1))]);
    let recorder = &mut Recorder::new(&mut recorded, Some(&mut tape));
    recorder.release_at(TaskId::from_bits(0), at(0), None, at(0)).expect("room");
    let Some(Action::Dispatch(first)) = recorder.poll_on(LANE, at(0)) else { panic!("a lane is free") };
    recorder.complete(first.unit, at(1)).expect("it runs");
    recorder.end(at(1));
    drop(tape);
    assert!(writer.finish().1.is_none());
    let bytes = fs::read(&file.0).expect("it was written");
    let again = |nodes: usize| {
        let mut scheduler = scheduler(Config::EDF, &vec![Node::new(Wcet::from_millis(1)); nodes]);
        let mut log = Reader::new(&*bytes).expect("a log");
        replay(&mut log, &mut scheduler, |_, _, _| Ok(()), |_, _| {}).expect("a whole log")
    };
    assert!(again(1).difference.is_none());
    // Nobody asked what comes after the first node.
    let jobs = ends(&again(2)).expect("a job is open").map(|end| end.jobs_in_flight);
    assert_eq!(jobs, [0, 1]);
}
