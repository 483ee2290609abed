//! A run that is recorded: what is changed in its log lies deep in it.

use std::collections::HashSet;
use std::mem::discriminant;
use std::sync::LazyLock;
use std::{env, fs, process};

use red_core::{
    Action, Bytes, CommitError, Config, Contention, Dag, Duration, Frame, Instant, LaneId, Node, NodeId,
    PoolId, Scheduler, TaskId, Timing, UnitId, Wcet,
};
use red_record::{FORMAT, Header, Reader, Recorder, Writer};

pub type Small = red_core::Caps<3, 4, 3, 3, 2>;

pub const CONFIG: Config = Config { preempt: true, ..Config::REDRT.with_lanes(LANES) };
/// The tasks that [`change`] changes: the first two.
pub const TASKS: [TaskId; 2] = [TaskId::from_bits(0), TaskId::from_bits(1)];

/// Lanes of the first pool; the second has one.
const LANES: u8 = 2;
/// Changes that the host can make, from 0; of others it knows nothing.
const CHANGES: u32 = 4;

/// A shared encoder with two decoders that take `cost` milliseconds.
fn stage(cost: u64) -> (Dag<Small>, Timing) {
    let mut dag = Dag::new();
    let mut add = |node| dag.add_node(node).expect("room");
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let encoder = add(Node::shared_encoder(Wcet::from_millis(1), frame));
    let decoders = [0; 2].map(|_| add(Node::decoder(Wcet::from_millis(cost))));
    decoders.into_iter().for_each(|to| dag.add_edge(encoder, to).expect("no cycle"));
    (dag, Timing::new(Duration::from_millis(6 * cost)))
}

/// A scheduler that has [`TASKS`].
pub fn scheduler() -> Scheduler<Small> {
    let mut scheduler = Scheduler::new(CONFIG);
    let tasks = [1, 2].map(|cost| {
        let (dag, timing) = stage(cost);
        scheduler.add_task(&dag, timing).expect("room")
    });
    assert_eq!(tasks, TASKS);
    scheduler
}

/// Change `number`: of the first or the second task, a node more or the last one less.
///
/// # Errors
/// As of every commit; [`CommitError::Busy`] for a number that is none.
pub fn change(scheduler: &mut Scheduler<Small>, number: u32, now: Instant) -> Result<(), CommitError> {
    if number >= CHANGES {
        return Err(CommitError::Busy);
    }
    let mut dag = scheduler.edit(TASKS[number as usize % 2]).ok_or(CommitError::UnknownTask)?;
    if number / 2 == 0 {
        if let Ok(new) = dag.add_node(Node::new(Wcet::from_millis(1))) {
            // Whatever the first node is by now.
            let _none_or_a_cycle = dag.add_edge(NodeId::new(0), new);
        }
    } else if let Some(last) = dag.nodes().last() {
        dag.remove_node(last);
    }
    scheduler.commit(&dag, now).map(|_| ())
}

/// What any log of this host begins with.
pub fn header() -> Header {
    Header {
        program: String::new(),
        capacities: Header::capacities_of::<Small>(),
        policy: "redrt".into(),
        duration_ns: 1,
        realtime: false,
        file: String::new(),
        format: "toml".into(),
        workload: String::new(),
        config: Some(CONFIG),
    }
}

/// Entries and their words.
#[derive(Clone)]
pub struct Block {
    pub entries: u32,
    pub words: Vec<u8>,
}

/// A log of these blocks with every checksum right; in one that is not `closed` the totals are left out.
pub fn sealed(blocks: &[Block], closed: bool) -> Vec<u8> {
    let header = serde_json::to_vec(&header()).expect("plain data");
    let entries = blocks.iter().map(|block| u64::from(block.entries)).sum::<u64>();
    let mut totals = [if closed { entries } else { 0 }.to_le_bytes(), [0; 8]].concat();
    totals.extend(if closed { *b"DONE" } else { [0; 4] });
    let mut log = [&b"REDLOG"[..], &FORMAT.to_le_bytes()].concat();
    part(&mut log, &header);
    log.extend(&totals);
    log.extend(crc32fast::hash(&totals).to_le_bytes());
    for block in blocks {
        log.extend(block.entries.to_le_bytes());
        part(&mut log, &block.words);
    }
    log
}

fn part(log: &mut Vec<u8>, bytes: &[u8]) {
    log.extend((bytes.len() as u32).to_le_bytes());
    log.extend(crc32fast::hash(bytes).to_le_bytes());
    log.extend(bytes);
}

/// The one block of a run in which every call is made, and every kind of answer given.
pub static RUN: LazyLock<Block> = LazyLock::new(|| {
    let path = env::temp_dir().join(format!("red-fuzz-{}.redlog", process::id()));
    let (writer, mut tape) = Writer::start(&path, &header()).expect("a place for a log");
    let mut scheduler = Scheduler::new(CONFIG);
    let host = &mut Recorder::new(&mut scheduler, Some(&mut tape));
    let third = set_up(host);
    run(host, third);
    drop(tape);
    let (totals, failed) = writer.finish();
    let log = fs::read(&path);
    let _kept = fs::remove_file(&path);
    assert!(failed.is_none() && totals.cut.is_none(), "{totals:?}, {failed:?}");
    let log = log.expect("a log");
    let entries = u32::try_from(totals.entries).expect("a short run");
    let start = sealed(&[Block { entries, words: Vec::new() }], true).len();
    let block = Block { entries, words: log[start..].to_vec() };
    assert!(sealed(std::slice::from_ref(&block), true) == log, "a log is what its writer says");
    let (mut calls, mut answers) = (HashSet::new(), HashSet::new());
    let mut reader = Reader::new(&*log).expect("a log");
    while let Some(entry) = reader.next_entry().expect("a whole log") {
        calls.insert(discriminant(&entry.call));
        answers.insert(discriminant(&entry.answer));
    }
    assert_eq!((calls.len(), answers.len()), (16, 13), "kinds of calls and answers");
    block
});

/// Both tasks by calls, with what is refused, and a third whose nodes are in two pools and not in the first places.
fn set_up(host: &mut Recorder<'_, Small>) -> TaskId {
    let sensor = host.add_sensor(Duration::from_millis(3)).expect("room");
    let _no_period = host.add_sensor(Duration::ZERO);
    let pool = host.add_pool(1, Some(Bytes(10))).expect("room");
    let _no_room = host.add_pool(9, None);
    for (cost, task) in (1..).zip(TASKS) {
        let (dag, timing) = stage(cost);
        assert_eq!(host.add_task(&dag, timing), Ok(task));
    }
    let mut dag = Dag::new();
    let _empty = host.add_task(&dag, Timing::new(Duration::from_millis(9)));
    let frame = Frame { weights: 0, frame: 0, sensor: Some(sensor) };
    let gone = dag.add_node(Node::new(Wcet::from_millis(9))).expect("room");
    let first = dag.add_node(Node::shared_encoder(Wcet::from_millis(1), frame)).expect("room");
    let atomic = Node::new(Wcet::from_millis(1)).atomic(Contention::from_nanos(5)).memory(Bytes(10));
    let last = dag.add_node(atomic.in_pool(pool)).expect("room");
    assert!(dag.remove_node(gone));
    dag.add_edge(first, last).expect("no cycle");
    let timing = Timing::new(Duration::from_millis(20)).every(Duration::from_millis(10)).value(3).floor(1, 2);
    let third = host.add_task(&dag, timing).expect("room");
    let _full = host.add_task(&dag, timing);
    third
}

/// A node more or one less for `task`, a graph that is too old, and one of a pool that is not there.
fn commit(host: &mut Recorder<'_, Small>, task: TaskId, now: Instant) {
    let Some(mut edit) = Scheduler::edit(host, task) else { return };
    let old = edit;
    match edit.nodes().nth(2) {
        Some(last) => _ = edit.remove_node(last),
        None => _ = edit.add_node(Node::new(Wcet::from_millis(1)).best_case(Duration::from_micros(9))),
    }
    let _first = host.commit(&edit, now);
    let _busy_or_conflict = host.commit(&old, now);
    if let Some(mut edit) = Scheduler::edit(host, task) {
        let _full = edit.add_node(Node::new(Wcet::from_millis(1)).in_pool(PoolId::new(7)));
        let _unknown_pool = host.commit(&edit, now);
    }
}

fn run(host: &mut Recorder<'_, Small>, third: TaskId) {
    let tasks = TASKS;
    let lanes = [0, 1, 2].map(LaneId::new);
    let mut running = [None::<UnitId>; 3];
    for step in 0..80_u64 {
        // Once a step back, and once a leap that no word of an entry has room for.
        let now = match step {
            40 => Instant::from_nanos(1),
            41.. => Instant::from_nanos((1 << 37) + step * 500_000),
            _ => Instant::from_nanos(step * 500_000),
        };
        match step {
            10 | 50 => _ = host.edit(step as u32 / 50, now, |s| change(s, step as u32 / 50, now)),
            20 => _ = host.edit(CHANGES, now, |s| change(s, CHANGES, now)),
            25 | 27 | 29 | 55 => commit(host, third, now),
            75 => {
                let of_none = Scheduler::edit(host, tasks[1]).expect("it is there");
                host.remove_task(tasks[1], now);
                let _unknown_task = host.commit(&of_none, now);
                let (dag, timing) = stage(1);
                let _in_its_place = host.add_task(&dag, timing);
            }
            _ if step % 8 == 6 => _ = host.release_at(third, now, None, now),
            // Two encoders of one frame, which share an execution.
            _ if step % 12 == 0 => _ = tasks.map(|task| host.release_at(task, now, Some(step), now)),
            _ if step % 3 == 1 => _ = host.release_at(tasks[0], now, None, now),
            _ => {}
        }
        for lane in lanes {
            if step % 11 == 2 {
                host.restore_lane(lane);
            }
            let done = running[lane.index()].take_if(|_| (step + lane.index() as u64) % 3 == 0);
            match done {
                Some(unit) if step % 11 == 0 => {
                    let _late = host.fail(unit, now);
                    host.retire_lane(lane);
                }
                Some(unit) => _ = host.complete(unit, now),
                None => {}
            }
            while step % 4 == 0 && host.take_outcome().is_some() {}
            while let Some(action) = if step % 5 == 4 { host.poll(now) } else { host.poll_on(lane, now) } {
                match action {
                    Action::Dispatch(dispatch) => running[dispatch.unit.lane().index()] = Some(dispatch.unit),
                    Action::Preempt(dispatch) => running[dispatch.unit.lane().index()] = None,
                    _ => {}
                }
            }
        }
    }
    host.end(Instant::from_nanos(1 << 38));
}
