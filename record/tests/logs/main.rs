//! Logs in files: written while a scheduler runs, read, replayed, and refused when they are not as they were written.

mod calls;
mod ends;
mod jobs;
mod starts;

use red_core::{
    Action, Caps, Config, Dag, Duration, Empty, Frame, Instant, LaneId, Node, Scheduler, TaskId, Timing,
    UnitId, Wcet,
};
use red_record::{FORMAT, Header, LogError, Reader, Recorder, Tape, Totals, Writer, replay};
use std::env;
use std::fs;
use std::path::PathBuf;
use std::process;

type Small = Caps<2, 8, 4, 2>;

/// A file that goes away.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        Self(env::temp_dir().join(format!("red-record-{}-{name}.redlog", process::id())))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _gone = fs::remove_file(&self.0);
    }
}

fn header() -> Header {
    Header {
        program: "test".into(),
        capacities: Header::capacities_of::<Small>(),
        policy: "redrt".into(),
        duration_ns: 1,
        realtime: false,
        file: "none".into(),
        format: "toml".into(),
        workload: String::new(),
        config: None,
    }
}

/// Two tasks, one of them with an encoder.
fn scheduler() -> (Box<Scheduler<Small>>, [TaskId; 2]) {
    let mut scheduler: Box<Scheduler<Small>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(Config::REDRT.with_lanes(2));
    let frame = Frame { weights: 0, frame: 0, sensor: None };
    let mut stage = Dag::new();
    let camera = stage.add_node(Node::new(Wcet::from_millis(1))).unwrap();
    let encoder = stage.add_node(Node::shared_encoder(Wcet::from_millis(3), frame)).unwrap();
    stage.add_edge(camera, encoder).unwrap();
    for _ in 0..2 {
        let decoder = stage.add_node(Node::decoder(Wcet::from_millis(2))).unwrap();
        stage.add_edge(encoder, decoder).unwrap();
    }
    let mut plain = Dag::new();
    plain.add_node(Node::new(Wcet::from_millis(4))).unwrap();
    let timing = Timing::new(Duration::from_millis(12));
    let tasks = [&stage, &plain].map(|dag| scheduler.add_task(dag, timing).unwrap());
    (scheduler, tasks)
}

fn grow(scheduler: &mut Scheduler<Small>, task: TaskId, now: Instant) -> Result<(), red_core::CommitError> {
    let mut edit = scheduler.edit(task).ok_or(red_core::CommitError::UnknownTask)?;
    let _full_after_a_while = edit.add_node(Node::new(Wcet::from_millis(1)));
    scheduler.commit(&edit, now).map(drop)
}

/// Runs for `turns` milliseconds, with all that a host may do, wrong things included.
fn run(scheduler: &mut Scheduler<Small>, tasks: [TaskId; 2], tape: &mut Tape, turns: u64) {
    let scheduler = &mut Recorder::new(scheduler, Some(tape));
    let mut running: [Option<UnitId>; 2] = [None; 2];
    for turn in 0..turns {
        let now = Instant::from_nanos(turn * 1_000_000 + turn % 7);
        for (lane, place) in running.iter_mut().enumerate() {
            if let Some(unit) = place.filter(|_| (turn + lane as u64).is_multiple_of(3)) {
                let _told =
                    if turn % 31 == 0 { scheduler.fail(unit, now) } else { scheduler.complete(unit, now) };
                let _stale = scheduler.complete(unit, now);
                *place = None;
            }
        }
        while scheduler.take_outcome().is_some() {}
        if turn % 40 == 20 {
            let _busy = scheduler.edit(7, now, |scheduler| grow(scheduler, tasks[0], now));
        }
        if turn % 5 == 0 {
            let _full = scheduler.release_at(tasks[0], now, None, now);
        }
        if turn % 6 == 0 {
            let _full = scheduler.release_at(tasks[1], now, Some(turn), now);
        }
        while let Some(action) = scheduler.poll_on(LaneId::new((turn % 2) as u8), now) {
            if let Action::Dispatch(started) = action {
                running[started.lane.index()] = Some(started.unit);
            }
        }
        // A clock that goes back.
        if turn % 50 == 49 {
            let _nothing = scheduler.poll(Instant::from_nanos(turn));
        }
        while scheduler.take_event().is_some() {}
    }
    scheduler.end(Instant::from_nanos(turns * 1_000_000));
}

fn recorded(name: &str, turns: u64) -> (Scratch, Totals) {
    let file = Scratch::new(name);
    let (writer, mut tape) = Writer::start(&file.0, &header()).expect("a folder for temporary files");
    let (mut scheduler, tasks) = scheduler();
    run(&mut scheduler, tasks, &mut tape, turns);
    drop(tape);
    let (totals, failed) = writer.finish();
    assert!(failed.is_none(), "{failed:?}");
    (file, totals)
}

/// All entries fed again: how many, and whether there was a difference.
fn again(bytes: &[u8], plant: impl Fn(&mut Scheduler<Small>)) -> Result<(u64, Option<u64>), LogError> {
    let (mut scheduler, tasks) = scheduler();
    plant(&mut scheduler);
    let change = |scheduler: &mut Scheduler<Small>, number, now| {
        assert_eq!(number, 7);
        grow(scheduler, tasks[0], now)
    };
    let found = replay(&mut Reader::new(bytes)?, &mut scheduler, change, |_, _| {}).map_err(|e| e.error)?;
    Ok((found.inputs, found.difference.map(|d| d.input)))
}

#[test]
fn a_run_is_replayed_without_a_difference() {
    let (file, totals) = recorded("equal", 20_000);
    assert_eq!(totals.dropped, 0);
    let bytes = fs::read(&file.0).unwrap();
    assert_eq!(bytes.len() as u64, totals.bytes);
    assert_eq!(again(&bytes, |_| {}).unwrap(), (totals.entries, None));
    let per_entry = totals.bytes as f64 / totals.entries as f64;
    println!("{} entries, {per_entry:.1} bytes each", totals.entries);
}

#[test]
fn a_scheduler_that_decides_otherwise_is_caught() {
    let (file, _) = recorded("planted", 200);
    let bytes = fs::read(&file.0).unwrap();
    // One job that was not in the run: its node takes a lane.
    let planted = again(&bytes, |scheduler| {
        let task = TaskId::from_bits(1);
        let _job = scheduler.release(task, Instant::ZERO);
    });
    assert!(matches!(planted, Ok((_, Some(_)))), "{planted:?}");
}

#[test]
fn a_truncated_log_is_refused_wherever_it_ends() {
    let (file, _) = recorded("truncated", 60);
    let bytes = fs::read(&file.0).unwrap();
    for end in 0..bytes.len() {
        let found = again(&bytes[..end], |_| {});
        let truncated = matches!(found, Err(LogError::Truncated { .. }));
        assert!(truncated || end < 6 && matches!(found, Err(LogError::NotALog)), "{end}: {found:?}");
    }
    let longer: Vec<u8> = bytes.iter().copied().chain([0]).collect();
    assert!(matches!(again(&longer, |_| {}), Err(LogError::Damaged { .. })));
}

#[test]
fn a_flipped_bit_is_refused_wherever_it_is() {
    let (file, _) = recorded("flipped", 60);
    let mut bytes = fs::read(&file.0).unwrap();
    for bit in 0..bytes.len() * 8 {
        bytes[bit / 8] ^= 1 << (bit % 8);
        let found = again(&bytes, |_| {});
        assert!(found.is_err(), "bit {bit}: {found:?}");
        bytes[bit / 8] ^= 1 << (bit % 8);
    }
}

#[test]
fn entries_that_a_block_does_not_announce_are_not_passed_over() {
    let file = Scratch::new("announced");
    let (writer, mut tape) = Writer::start(&file.0, &header()).unwrap();
    let (mut scheduler, tasks) = scheduler();
    {
        let scheduler = &mut Recorder::new(&mut scheduler, Some(&mut tape));
        let (lane, at) = (LaneId::new(0), |ms: u64| Instant::from_nanos(ms * 1_000_000));
        scheduler.release_at(tasks[0], at(0), None, at(0)).unwrap();
        let Some(Action::Dispatch(camera)) = scheduler.poll_on(lane, at(0)) else { panic!("a lane is free") };
        assert!(scheduler.poll_on(lane, at(0)).is_none());
        // The usual turn, which is one word of three entries.
        scheduler.complete(camera.unit, at(1)).unwrap();
        assert!(matches!(scheduler.poll_on(lane, at(1)), Some(Action::Dispatch(_))));
        assert!(scheduler.poll_on(lane, at(1)).is_none());
        scheduler.end(at(2));
    }
    drop(tape);
    let (totals, _) = writer.finish();
    let log = fs::read(&file.0).unwrap();
    let int = |at: usize| u32::from_le_bytes(log[at..at + 4].try_into().unwrap());
    let at = 16 + int(8) as usize;
    let announcing = |entries: u64| {
        let mut log = log.clone();
        log[at..at + 8].copy_from_slice(&entries.to_le_bytes());
        let crc = crc32fast::hash(&log[at..at + 20]);
        log[at + 20..at + 24].copy_from_slice(&crc.to_le_bytes());
        log[at + 24..at + 28].copy_from_slice(&(entries as u32).to_le_bytes());
        again(&log, |_| {})
    };
    assert_eq!(announcing(totals.entries).unwrap(), (totals.entries, None));
    for fewer in 1..totals.entries {
        let found = announcing(totals.entries - fewer);
        assert!(matches!(found, Err(LogError::Damaged { .. })), "{fewer} fewer: {found:?}");
    }
}

#[test]
fn other_formats_are_told_apart() {
    let (file, _) = recorded("formats", 10);
    let mut bytes = fs::read(&file.0).unwrap();
    let mut with_format = |format: u16| {
        bytes[6..8].copy_from_slice(&format.to_le_bytes());
        again(&bytes, |_| {})
    };
    assert!(matches!(with_format(FORMAT - 1), Err(LogError::Older(4))));
    assert!(matches!(with_format(FORMAT + 1), Err(LogError::Newer(6))));
    assert!(matches!(again(b"PK\x03\x04 something else", |_| {}), Err(LogError::NotALog)));
}

#[test]
fn a_log_that_was_not_closed_says_so() {
    let file = Scratch::new("open");
    let (writer, tape) = Writer::start(&file.0, &header()).unwrap();
    let open = fs::read(&file.0).unwrap();
    assert!(matches!(again(&open, |_| {}), Err(LogError::NotClosed)));
    drop(tape);
    let (totals, _) = writer.finish();
    assert_eq!((totals.entries, totals.dropped, totals.cut), (0, 0, None));
    assert!(matches!(again(&fs::read(&file.0).unwrap(), |_| {}), Err(LogError::Unended)));
}

#[test]
fn a_run_that_ends_beyond_all_time_is_refused() {
    for (duration_ns, is_refused) in [(1 << 62, false), ((1 << 62) + 1, true)] {
        let file = Scratch::new("beyond");
        let (writer, tape) = Writer::start(&file.0, &Header { duration_ns, ..header() }).unwrap();
        drop(tape);
        assert!(writer.finish().1.is_none());
        let read = Reader::new(&*fs::read(&file.0).unwrap()).err();
        assert_eq!(
            matches!(read, Some(LogError::Damaged { what: "the header", .. })),
            is_refused,
            "{read:?}"
        );
    }
}

#[test]
fn other_capacities_are_refused() {
    let (file, _) = recorded("capacities", 10);
    let bytes = fs::read(&file.0).unwrap();
    let mut other: Box<Scheduler<Caps<2, 8, 8, 2>>> = Box::new(Scheduler::EMPTY);
    other.configure(Config::REDRT);
    let found = replay(&mut Reader::new(&*bytes).unwrap(), &mut other, |_, _, _| Ok(()), |_, _| {});
    assert!(matches!(found.map_err(|e| e.error), Err(LogError::Capacities { .. })));
}

#[test]
fn a_full_disk_is_told_before_the_run() {
    let full = Writer::start(std::path::Path::new("/dev/full"), &header());
    assert!(full.is_err());
}
