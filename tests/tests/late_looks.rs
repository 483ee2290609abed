//! A host whose lanes are all busy tells of releases later, and polls at none of their instants.

use red_core::{
    Action, Caps, Config, Dag, Duration, Instant, JobId, Node, Outcome, Scheduler, ShedReason, TaskId,
    Timing, UnitId, Wcet,
};
use std::collections::BTreeMap;

type Robot = Scheduler<Caps<4, 4, 8, 1, 1>>;

fn at(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

/// A task of one node.
fn add(scheduler: &mut Robot, wcet_ms: u64, deadline_ms: u64, value: u32) -> TaskId {
    let mut dag = Dag::new();
    dag.add_node(Node::new(Wcet::from_millis(wcet_ms))).expect("it fits");
    let timing = Timing::new(Duration::from_millis(deadline_ms)).value(value);
    scheduler.add_task(&dag, timing).expect("there is room")
}

/// All that there is to do: the unit that starts, and how jobs ended.
fn poll(scheduler: &mut Robot, ms: u64) -> (Option<UnitId>, Vec<Outcome>) {
    let (mut unit, mut ended) = (None, Vec::new());
    while let Some(action) = scheduler.poll(at(ms)) {
        match action {
            Action::Dispatch(started) => unit = Some(started.unit),
            Action::Ended(outcome) => ended.push(outcome),
            other => panic!("nobody asked for {other:?}"),
        }
    }
    (unit, ended)
}

#[test]
fn who_will_be_late_is_known_as_of_its_release() {
    let mut scheduler = Robot::new(Config::REDRT);
    let long = add(&mut scheduler, 31, 240, 2);
    let short = add(&mut scheduler, 12, 18, 50);
    scheduler.release(long, at(0)).expect("there is room");
    let (unit, _) = poll(&mut scheduler, 0);
    scheduler.release(short, at(5)).expect("there is room");
    assert_eq!(scheduler.take_warning(), None, "more may come at 5 ms");
    // It would start at 31 ms, and is due at 23.
    scheduler.complete(unit.expect("the lane was free"), at(31)).expect("it ran");
    let warning = scheduler.take_warning().expect("a look was due at 5 ms");
    assert_eq!((warning.task, warning.by), (short, Duration::from_millis(20)));
    assert_eq!(warning.because.map(|(task, _)| task), Some(long));
    let (_, ended) = poll(&mut scheduler, 31);
    let ended: Vec<_> = ended.iter().map(|end| (end.task, end.shed, end.at)).collect();
    assert_eq!(ended, [(long, None, at(31)), (short, Some(ShedReason::Hopeless), at(31))]);
}

/// Of a table of eight that is full, with a release that waits for its look: how all jobs ended, and the last two jobs.
fn full_table(takes_warnings: bool) -> (Vec<Outcome>, [JobId; 2]) {
    let mut scheduler = Robot::new(Config::REDRT);
    let long = add(&mut scheduler, 31, 240, 2);
    let low = add(&mut scheduler, 4, 60, 1);
    let high = add(&mut scheduler, 16, 49, 9);
    scheduler.release(long, at(0)).expect("there is room");
    let (mut unit, mut ended) = poll(&mut scheduler, 0);
    for _ in 0..6 {
        scheduler.release(low, at(1)).expect("there is room");
    }
    assert_eq!(poll(&mut scheduler, 1), (None, vec![]), "31 + 6 * 4 ms are less than 61");
    // The eighth of eight. With it the last of low ends at 71 ms.
    scheduler.release(high, at(2)).expect("there is room");
    let last = [3, 4].map(|ms| {
        let job = scheduler.release(low, at(ms)).expect("what was given up as of 2 ms makes room");
        while takes_warnings && scheduler.take_warning().is_some() {}
        ended.extend(scheduler.take_outcome());
        job
    });
    let mut ms = 4;
    while scheduler.jobs_in_flight() > 0 {
        let (started, more) = poll(&mut scheduler, ms);
        ended.extend(more);
        unit = unit.or(started);
        let Some(runs) = unit.take() else { break };
        ms += if ms == 4 { 27 } else { 4 };
        scheduler.complete(runs, at(ms)).expect("it ran");
    }
    ended.extend(poll(&mut scheduler, ms).1);
    (ended, last)
}

#[test]
fn a_full_table_takes_the_place_of_one_that_such_a_look_gave_up() {
    let (ended, last) = full_table(false);
    let mut ends: BTreeMap<(usize, &str), u32> = BTreeMap::new();
    ended.iter().for_each(|end| {
        *ends.entry((end.task.index(), end.shed.map_or("", ShedReason::name))).or_default() += 1;
    });
    assert_eq!(ended.len(), 10, "{ends:?}");
    assert!(ends.keys().all(|(_, shed)| *shed != "full"), "{ends:?}");
    // Of tasks 0, 1 and 2 the last is high, the one before it low.
    assert_eq!(ends.get(&(2, "")), Some(&1), "{ends:?}");
    let first = ended.iter().find(|end| end.shed.is_some()).expect("one had to go");
    assert_eq!((first.task.index(), first.at), (1, at(2)));
    assert_eq!(full_table(true), (ended, last), "a host that takes warnings decides the same");
}

/// One of two jobs of 10 ms that come at 1 ms has to go once nothing starts before 25 ms: that of less value.
fn who_starts_at_25_ms(takes_ms: &[u64]) -> (TaskId, TaskId) {
    let mut scheduler = Robot::new(Config::REDRT);
    let unit = add(&mut scheduler, 25, 900, 1);
    let low = add(&mut scheduler, 10, 35, 1);
    let high = add(&mut scheduler, 10, 39, 100);
    let mut ms = 0;
    let mut runs = None;
    for takes in takes_ms {
        ms += 1_000;
        scheduler.release(unit, at(ms)).expect("there is room");
        let (started, _) = poll(&mut scheduler, ms);
        runs = Some((started.expect("the lane is free"), ms + takes));
        if *takes < 25 {
            scheduler.complete(started.expect("the lane is free"), at(ms + takes)).expect("it ran");
            poll(&mut scheduler, ms + takes);
            runs = None;
        }
    }
    scheduler.release(low, at(ms + 1)).expect("there is room");
    scheduler.release(high, at(ms + 1)).expect("there is room");
    if let Some((unit, ends)) = runs {
        scheduler.complete(unit, at(ends)).expect("it ran");
    }
    let (started, _) = poll(&mut scheduler, ms + 25);
    let member = scheduler.members(started.expect("two jobs are ready")).next();
    (member.expect("a unit has a member").task, high)
}

#[test]
fn a_unit_that_took_longer_is_known_to_have() {
    let (started, high) = who_starts_at_25_ms(&[5, 5, 5, 5, 5, 5, 25]);
    assert_eq!(started, high);
}

#[test]
fn a_host_with_an_idle_lane_looks_when_it_polls() {
    let (started, high) = who_starts_at_25_ms(&[]);
    assert_eq!(started, high);
}

#[test]
fn an_idle_lane_has_no_look_made_up_for() {
    let mut scheduler = Robot::new(Config::REDRT);
    let short = add(&mut scheduler, 10, 15, 1);
    for ms in [0, 0, 1] {
        scheduler.release(short, at(ms)).expect("there is room");
    }
    assert_eq!(scheduler.take_warning(), None, "the host is about to poll, and looks once");
    poll(&mut scheduler, 1);
    assert!(scheduler.take_warning().is_some(), "two of three are late");
}
