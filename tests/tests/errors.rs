//! Every error of every call of the core, provoked once, and each time nothing else has changed.

use std::any::type_name;
use std::collections::BTreeSet;
use std::error::Error;
use std::fmt::Debug;
use std::fs;
use std::path::Path;

use red_core::{
    Action, Admission, Bytes, Caps, Config, Contention, Dag, Duration, Event, EventKind, Frame, Instant,
    Late, Node, NodeId, Outcome, PoolId, Scheduler, SensorId, TaskId, Timing, UnitId, Wcet, refine,
};

/// Two tasks of four nodes, two jobs, two lanes in two pools, and a record.
type Small = Caps<2, 4, 2, 2, 2, 1, 64>;

const MS: Duration = Duration::from_millis(1);
const LONG: Duration = Duration::from_millis(100);

fn ms(n: u64) -> Instant {
    Instant::ZERO.saturating_add(Duration::from_millis(n))
}

/// Expects that `call` refuses and that `state` is the same afterwards, down to what is private in it. Answers
/// with the error's name.
fn refused<S: Debug, T: Debug, E: Error>(state: &mut S, call: impl FnOnce(&mut S) -> Result<T, E>) -> String {
    let before = format!("{state:?}");
    let name = refused_but(state, call);
    assert!(before == format!("{state:?}"), "{name} changed something");
    name
}

/// Expects that `call` refuses. For errors that document what they change.
fn refused_but<S, T: Debug, E: Error>(state: &mut S, call: impl FnOnce(&mut S) -> Result<T, E>) -> String {
    let error = call(state).expect_err("it has to be refused");
    assert!(!error.to_string().is_empty());
    let kind = type_name::<E>().rsplit("::").next().unwrap_or_default();
    format!("{kind}::{error:?}")
}

fn node(cost_ms: u64) -> Node {
    Node::new(Wcet::from_millis(cost_ms))
}

/// An encoder that reads a sensor.
fn seeing(sensor: u8) -> Node {
    let frame = Frame { weights: 0, frame: 0, sensor: Some(SensorId::new(sensor)) };
    Node::shared_encoder(Wcet::from_millis(1), frame)
}

fn encoder(cost_ms: u64) -> Node {
    Node::shared_encoder(Wcet::from_millis(cost_ms), Frame { weights: 0, frame: 0, sensor: None })
}

fn chain(costs_ms: &[u64]) -> Dag<Small> {
    let mut dag = Dag::new();
    let nodes: Vec<_> = costs_ms.iter().map(|cost| dag.add_node(node(*cost)).expect("it fits")).collect();
    nodes.windows(2).for_each(|pair| dag.add_edge(pair[0], pair[1]).expect("a chain has no cycle"));
    dag
}

/// A scheduler with one admitted chain of two nodes.
fn scheduler(config: Config) -> (Scheduler<Small>, TaskId) {
    let mut scheduler = Scheduler::new(config);
    let task = scheduler.add_task(&chain(&[1, 2]), Timing::new(LONG)).expect("it fits");
    (scheduler, task)
}

/// What `poll` gives at an instant.
fn poll(scheduler: &mut Scheduler<Small>, now: Instant) -> (Vec<UnitId>, Vec<Outcome>) {
    let (mut units, mut outcomes) = (Vec::new(), Vec::new());
    while let Some(action) = scheduler.poll(now) {
        match action {
            Action::Dispatch(started) => units.push(started.unit),
            Action::Ended(outcome) => outcomes.push(outcome),
            other => panic!("nobody asked for {other:?}"),
        }
    }
    (units, outcomes)
}

/// After an error the scheduler goes on: a job of `task` runs through.
fn runs_on(scheduler: &mut Scheduler<Small>, task: TaskId, from: Instant) {
    let mut now = from;
    let job = scheduler.release(task, now).expect("there is room");
    loop {
        let (units, outcomes) = poll(scheduler, now);
        if let Some(outcome) = outcomes.iter().find(|outcome| outcome.job == job) {
            assert!(outcome.on_time(), "{outcome:?}");
            return;
        }
        assert!(!units.is_empty(), "the job stands still");
        now = now.saturating_add(MS);
        units.into_iter().for_each(|unit| scheduler.complete(unit, now).expect("it runs"));
    }
}

fn node_errors() -> Vec<String> {
    let mut full = chain(&[1, 1, 1, 1]);
    let mut heavy = chain(&[1]);
    let endless = Node::new(Wcet::from_nanos(u64::MAX));
    let with_contention = endless.atomic(Contention::from_nanos(1));
    let names = vec![
        refused(&mut full, |dag| dag.add_node(node(1))),
        refused(&mut heavy, |dag| dag.add_node(endless)),
        refused(&mut Dag::<Small>::new(), |dag| dag.add_node(with_contention)),
    ];
    heavy.add_node(node(1)).expect("a node that fits still fits");
    names
}

fn edge_errors() -> Vec<String> {
    let mut dag = chain(&[1, 1, 1]);
    let [a, b, c] = [0, 1, 2].map(NodeId::new);
    let mut names = vec![
        refused(&mut dag, |dag| dag.add_edge(c, a)),
        refused(&mut dag, |dag| dag.add_edge(b, a)),
        refused(&mut dag, |dag| dag.add_edge(b, b)),
        refused(&mut dag, |dag| dag.add_edge(a, b)),
        refused(&mut dag, |dag| dag.add_edge(a, NodeId::new(3))),
        refused(&mut dag, |dag| dag.add_edge(NodeId::new(200), a)),
    ];
    dag.add_edge(a, c).expect("an edge that closes no cycle");
    let mut stages = Dag::<Small>::new();
    let mut add = |node| stages.add_node(node).expect("room");
    let [first, second] = [add(encoder(1)), add(encoder(1))];
    let [decoder, fusion] = [add(Node::decoder(Wcet::from_millis(1))), add(node(1))];
    for (from, to) in [(first, decoder), (first, second), (first, fusion), (second, fusion)] {
        stages.add_edge(from, to).expect("one encoder for each decoder");
    }
    names.push(refused(&mut stages, |dag| dag.add_edge(second, decoder)));
    names
}

fn refine_errors() -> Vec<String> {
    let mut dag = chain(&[1, 6, 1]);
    let stage = NodeId::new(1);
    let decoder = Node::decoder(Wcet::from_millis(1));
    let endless = Node::decoder(Wcet::from_nanos(u64::MAX));
    let names = vec![
        refused(&mut dag, |dag| refine(dag, NodeId::new(3), encoder(2), &[decoder])),
        refused(&mut dag, |dag| refine(dag, stage, encoder(2), &[])),
        refused(&mut dag, |dag| refine(dag, stage, encoder(2), &[decoder; 2])),
        refused(&mut dag, |dag| refine(dag, stage, encoder(2), &[endless])),
    ];
    refine(&dag, stage, encoder(2), &[decoder]).expect("four nodes fit");
    names
}

fn pool_errors() -> Vec<String> {
    let (mut two_lanes, task) = scheduler(Config::REDRT.with_lanes(2));
    let (mut two_pools, _) = scheduler(Config::REDRT);
    two_pools.add_pool(1, None).expect("a second lane and pool");
    let names = vec![
        refused(&mut two_lanes, |s| s.add_pool(0, None)),
        refused(&mut two_lanes, |s| s.add_pool(1, None)),
        refused(&mut two_lanes, |s| s.add_pool(u8::MAX, None)),
        refused(&mut two_pools, |s| s.add_pool(1, None)),
    ];
    runs_on(&mut two_lanes, task, ms(0));
    names
}

fn sensor_errors() -> Vec<String> {
    let (mut scheduler, task) = scheduler(Config::REDRT);
    let zero = refused(&mut scheduler, |s| s.add_sensor(Duration::ZERO));
    for n in (1..=4).chain([1]) {
        scheduler.add_sensor(Duration::from_millis(n)).expect("as many periods as nodes");
    }
    let full = refused(&mut scheduler, |s| s.add_sensor(Duration::from_secs(1)));
    runs_on(&mut scheduler, task, ms(0));
    vec![zero, full]
}

fn add_task_errors() -> Vec<String> {
    let enforcing = Config { admission: Admission::Enforce, ..Config::REDRT.with_memory(Bytes(10)) };
    let (mut one, task) = scheduler(enforcing);
    let (mut two, _) = scheduler(Config::REDRT);
    two.add_task(&chain(&[1]), Timing::new(LONG)).expect("the second task");
    let timing = Timing::new(LONG);
    let single = |node: Node| {
        let mut dag = Dag::new();
        dag.add_node(node).expect("one node");
        dag
    };
    let mut stage = single(encoder(1).memory(Bytes(6)));
    let decoder = stage.add_node(Node::decoder(Wcet::from_millis(1)).memory(Bytes(6))).expect("two nodes");
    stage.add_edge(NodeId::new(0), decoder).expect("encoder to decoder");
    let names = vec![
        refused(&mut two, |s| s.add_task(&chain(&[1]), timing)),
        refused(&mut one, |s| s.add_task(&Dag::new(), timing)),
        refused(&mut one, |s| s.add_task(&chain(&[1]), Timing::new(Duration::ZERO))),
        refused(&mut one, |s| s.add_task(&chain(&[1]), Timing::new(Duration::from_nanos((1 << 62) + 1)))),
        refused(&mut one, |s| s.add_task(&single(node(1).in_pool(PoolId::new(1))), timing)),
        refused(&mut one, |s| s.add_task(&single(node(1).in_pool(PoolId::new(255))), timing)),
        refused(&mut one, |s| s.add_task(&single(seeing(0)), timing)),
        refused(&mut one, |s| s.add_task(&single(seeing(255)), timing)),
        refused(&mut one, |s| s.add_task(&single(node(1).memory(Bytes(11))), timing)),
        refused(&mut one, |s| s.add_task(&stage, timing)),
        refused(&mut one, |s| s.add_task(&chain(&[60, 60]), timing)),
        refused(&mut one, |s| s.add_task(&chain(&[6, 6]), timing.every(Duration::from_millis(10)))),
    ];
    runs_on(&mut one, task, ms(0));
    names
}

fn release_errors() -> Vec<String> {
    let (mut scheduler, task) = scheduler(Config::REDRT);
    let removed = scheduler.add_task(&chain(&[1]), Timing::new(LONG)).expect("a second task");
    assert!(scheduler.remove_task(removed, ms(0)));
    while scheduler.take_event().is_some() {}
    let late = Instant::from_nanos(i64::MAX as u64);
    let mut names = vec![
        refused(&mut scheduler, |s| s.release(removed, ms(0))),
        refused(&mut scheduler, |s| s.release(TaskId::from_bits(u32::MAX), ms(0))),
        refused(&mut scheduler, |s| s.release_at(task, late, None, ms(0))),
        refused(&mut scheduler, |s| s.release_at(task, Instant::MAX, None, ms(0))),
    ];
    let jobs = [0, 1].map(|_| scheduler.release(task, ms(0)).expect("two jobs fit"));
    // A job that finds no place uses its index up and is in the record; nothing else changes.
    let seen =
        |s: &Scheduler<Small>| (s.jobs_in_flight(), s.ready_sub_jobs(), s.running_units(), s.counters());
    let before = seen(&scheduler);
    while scheduler.take_event().is_some() {}
    names.push(refused_but(&mut scheduler, |s| s.release(task, ms(0))));
    assert_eq!(seen(&scheduler), before);
    let noted = scheduler.take_event().copied();
    assert!(matches!(noted, Some(Event { kind: EventKind::Refused, job: 2, .. })), "{noted:?}");
    assert!(scheduler.take_event().is_none());
    assert_eq!([0, 1].map(|index| scheduler.job_id(task, index)), jobs.map(Some));
    let mut now = ms(0);
    while scheduler.jobs_in_flight() > 0 {
        let (units, _) = poll(&mut scheduler, now);
        now = now.saturating_add(MS);
        units.into_iter().for_each(|unit| scheduler.complete(unit, now).expect("it runs"));
    }
    poll(&mut scheduler, now);
    runs_on(&mut scheduler, task, now);
    assert_eq!(scheduler.job_id(task, 2), None);
    names
}

fn complete_errors() -> Vec<String> {
    let (mut scheduler, task) = scheduler(Config { late: Late::AbortJob, ..Config::EDF });
    let forged = UnitId::from_bits(1 << 16);
    let mut names = vec![
        refused(&mut scheduler, |s| s.complete(forged, ms(0))),
        refused(&mut scheduler, |s| s.fail(UnitId::from_bits(0), ms(0))),
        refused(&mut scheduler, |s| s.complete(UnitId::from_bits(u64::MAX), ms(0))),
    ];
    runs_on(&mut scheduler, task, ms(0));
    let release = ms(10);
    scheduler.release(task, release).expect("there is room");
    let (units, _) = poll(&mut scheduler, release);
    scheduler.complete(units[0], release).expect("it runs");
    for call in [Scheduler::complete, Scheduler::fail] {
        names.push(refused(&mut scheduler, |s| call(s, units[0], release)));
    }
    names.push(refused(&mut scheduler, |s| s.complete_and_poll(units[0], release)));
    let other_lane = UnitId::from_bits(units[0].to_bits() | 1);
    names.push(refused(&mut scheduler, |s| s.complete(other_lane, release)));
    // The job is given up while its second node runs; the report frees the lane, is counted, and changes no
    // more.
    let (units, _) = poll(&mut scheduler, release);
    let after = release.saturating_add(LONG).saturating_add(MS);
    let (_, outcomes) = poll(&mut scheduler, after);
    assert_eq!((outcomes.len(), scheduler.running_units()), (1, 1));
    let before = scheduler.counters();
    names.push(refused_but(&mut scheduler, |s| s.complete(units[0], after)));
    assert_eq!(scheduler.counters().late_completions, before.late_completions + 1);
    assert_eq!((scheduler.jobs_in_flight(), scheduler.running_units()), (0, 0));
    names.push(refused(&mut scheduler, |s| s.complete(units[0], after)));
    runs_on(&mut scheduler, task, after);
    names
}

fn commit_errors() -> Vec<String> {
    let enforcing = Config { admission: Admission::Enforce, ..Config::REDRT.with_memory(Bytes(10)) };
    let (mut scheduler, task) = scheduler(enforcing);
    let removed = scheduler.add_task(&chain(&[1]), Timing::new(LONG)).expect("a second task");
    let orphan = scheduler.edit(removed).expect("still there");
    assert!(scheduler.remove_task(removed, ms(0)));
    assert!(scheduler.edit(removed).is_none());
    let adding = |scheduler: &Scheduler<Small>, node: Node| {
        let mut edit = scheduler.edit(task).expect("it is admitted");
        edit.add_node(node).expect("there is room");
        edit
    };
    let mut empty = scheduler.edit(task).expect("it is admitted");
    assert!(empty.remove_node(NodeId::new(0)) && empty.remove_node(NodeId::new(1)));
    let elsewhere = adding(&scheduler, node(1).in_pool(PoolId::new(1)));
    let blind = adding(&scheduler, seeing(0));
    let large = adding(&scheduler, node(1).memory(Bytes(11)));
    let slow = adding(&scheduler, node(100));
    let mut names = vec![
        refused(&mut scheduler, |s| s.commit(&orphan, ms(0))),
        refused(&mut scheduler, |s| s.commit(&empty, ms(0))),
        refused(&mut scheduler, |s| s.commit(&elsewhere, ms(0))),
        refused(&mut scheduler, |s| s.commit(&blind, ms(0))),
        refused(&mut scheduler, |s| s.commit(&large, ms(0))),
        refused(&mut scheduler, |s| s.commit(&slow, ms(0))),
    ];
    // A job on the first version, an edit, a job on the second: a third version has to wait.
    scheduler.release(task, ms(0)).expect("there is room");
    let (first, second) = (adding(&scheduler, node(1)), adding(&scheduler, node(2)));
    assert!(scheduler.commit(&first, ms(0)).expect("two versions fit").fits());
    names.push(refused(&mut scheduler, |s| s.commit(&second, ms(0))));
    let third = scheduler.edit(task).expect("it is admitted");
    names.push(refused(&mut scheduler, |s| s.commit(&third, ms(0))));
    let (units, _) = poll(&mut scheduler, ms(0));
    scheduler.fail(units[0], ms(1)).expect("it runs");
    poll(&mut scheduler, ms(1));
    assert!(scheduler.commit(&third, ms(1)).expect("the older version has drained").fits());
    runs_on(&mut scheduler, task, ms(1));
    names
}

/// Every error that the sources of the core declare.
fn declared() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut open = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../core-nostd/src")];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(path).expect("a folder").map(|entry| entry.expect("an entry").path()));
            continue;
        }
        let text = fs::read_to_string(&path).expect("sources are UTF-8");
        for block in text.split("crate::error::errors! {\n").skip(1) {
            let block = block.split("\n}\n").next().unwrap_or_default();
            let mut kind = "";
            for line in block.lines().map(str::trim) {
                if let Some(name) = line.strip_prefix("pub enum ").and_then(|rest| rest.strip_suffix(" {")) {
                    kind = name;
                } else if let Some(variant) = line.strip_suffix(',').filter(|name| !name.starts_with("//")) {
                    found.insert(format!("{kind}::{variant}"));
                }
            }
        }
    }
    found
}

#[test]
fn every_error_is_provoked_and_changes_nothing() {
    let kinds = [
        node_errors(),
        edge_errors(),
        refine_errors(),
        pool_errors(),
        sensor_errors(),
        add_task_errors(),
        release_errors(),
        complete_errors(),
        commit_errors(),
    ];
    let provoked: BTreeSet<String> = kinds.into_iter().flatten().collect();
    assert!(provoked.len() > 30, "only {} errors", provoked.len());
    assert_eq!(provoked, declared());
}

#[test]
#[should_panic(expected = "Planted::Change changed something")]
fn a_refusal_that_changes_something_is_caught() {
    #[derive(Debug)]
    enum Planted {
        Change,
    }
    impl std::fmt::Display for Planted {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("planted")
        }
    }
    impl Error for Planted {}
    refused(&mut 0, |state| {
        *state += 1;
        Err::<(), _>(Planted::Change)
    });
}
