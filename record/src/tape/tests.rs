use super::*;
use crate::entry::{Answer, Call};
use crate::{Header, Writer};
use red_core::{JobId, TaskId};
use std::{env, fs, process, thread};

fn entry(ns: u64) -> Entry {
    Entry { now: Instant::from_nanos(ns), call: Call::Poll(None), answer: Answer::Nothing }
}

/// Puts one word each until nothing fits, and `more`.
fn overfull(more: u64) -> (Arc<Exchange>, u64) {
    let (mut tape, exchange) = Tape::new();
    let mut kept = 0;
    while tape.dropped == 0 {
        tape.put(&entry(kept));
        kept += 1;
    }
    kept -= 1;
    (1..more).for_each(|ns| tape.put(&entry(ns)));
    (exchange, kept)
}

#[test]
fn what_finds_no_room_is_counted_and_what_is_kept_has_no_gap() {
    let (exchange, kept) = overfull(17);
    let mut entries = 0;
    loop {
        match exchange.full.pop().expect("the end is told") {
            Letter::Chunk(chunk) => entries += chunk.entries(),
            Letter::End(dropped) => break assert_eq!(dropped, 17),
        }
    }
    assert_eq!(entries, kept);
    assert!(exchange.full.pop().is_none());
}

#[test]
fn a_chunk_that_comes_back_too_late_opens_no_gap() {
    let (mut tape, exchange) = Tape::new();
    while tape.dropped == 0 {
        tape.put(&entry(0));
    }
    if let Some(Letter::Chunk(mut chunk)) = exchange.full.pop() {
        chunk.clear();
        assert!(exchange.empty.claim().expect("free").push(chunk).is_ok());
    }
    tape.put(&entry(1));
    assert_eq!(tape.dropped, 2);
    // Taken and not used, it would be freed on a lane.
    assert!(exchange.empty.pop().is_some());
}

#[test]
fn what_the_writer_asks_for_is_handed_over_before_its_chunk_is_full() {
    let (mut tape, exchange) = Tape::new();
    tape.put(&entry(0));
    assert!(exchange.full.pop().is_none());
    exchange.wanted.store(true, Ordering::Relaxed);
    tape.put(&entry(1));
    assert!(matches!(exchange.full.pop(), Some(Letter::Chunk(chunk)) if chunk.entries() == 1));
    // Once.
    tape.put(&entry(2));
    assert!(exchange.full.pop().is_none());
}

#[test]
fn lanes_whose_turns_are_all_as_usual_hand_over_what_is_asked_for() {
    let (mut tape, exchange) = Tape::new();
    let (lane, job, now) = (LaneId::new(3), JobId::from_bits(2), Instant::from_nanos(1));
    let unit = |sequence: u64| UnitId::from_bits(sequence << 16 | 3);
    let started = |sequence| Started { unit: unit(sequence), job, members: None };
    let release = Call::Release { task: TaskId::from_bits(0), at: now, capture: None };
    tape.put(&Entry { now, call: release, answer: Answer::Released(Ok(job)) });
    tape.put(&Entry { now, call: Call::Poll(Some(lane)), answer: Answer::Started(started(1)) });
    let mut turn = |done: u64| {
        let is_usual = tape.completed(unit(done), now)
            && tape.dispatched(lane, &started(done + 1), now)
            && tape.found_nothing(lane, now);
        assert!(is_usual);
    };
    turn(1);
    assert!(exchange.full.pop().is_none());
    exchange.wanted.store(true, Ordering::Relaxed);
    turn(2);
    assert!(matches!(exchange.full.pop(), Some(Letter::Chunk(chunk)) if chunk.entries() == 8));
    turn(3);
    assert!(exchange.full.pop().is_none());
}

/// Waits for the writer's thread, which comes in time if at all.
fn wait_until(is_so: impl Fn() -> bool) {
    let begin = std::time::Instant::now();
    while !is_so() {
        assert!(begin.elapsed().as_secs() < 60, "the writer does not ask, or does not write");
        thread::yield_now();
    }
}

#[test]
fn a_writer_with_nothing_to_do_asks_for_what_there_is_and_writes_it() {
    let path = env::temp_dir().join(format!("red-record-{}-asks.redlog", process::id()));
    let header = Header {
        program: String::new(),
        capacities: [0; 5],
        policy: String::new(),
        duration_ns: 1,
        realtime: false,
        file: String::new(),
        format: String::new(),
        workload: String::new(),
        config: None,
    };
    let (writer, mut tape) = Writer::start(&path, &header).expect("a folder for temporary files");
    let length = || fs::metadata(&path).expect("it was begun").len();
    let begin = length();
    tape.put(&entry(0));
    wait_until(|| tape.exchange.wanted.load(Ordering::Relaxed));
    tape.put(&entry(1));
    wait_until(|| length() != begin);
    drop(tape);
    let (totals, failed) = writer.finish();
    fs::remove_file(&path).expect("our own file");
    assert!(failed.is_none() && totals.entries == 2, "{totals:?}");
}
