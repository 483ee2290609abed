//! Where a log ends: with the end of the run, or with the reason why it does not.

use crate::{Scratch, Small, again, grow, header, recorded, scheduler};
use red_core::{Action, Instant, LaneId, Scheduler};
use red_record::{Answer, Broken, Call, Cut, LogError, Reader, Recorder, Writer, replay};
use std::fs;

/// Where the totals of a log lie: entries, dropped, state and a checksum.
pub(crate) fn totals_at(log: &[u8]) -> usize {
    16 + u32::from_le_bytes(log[8..12].try_into().unwrap()) as usize
}

/// The log with this state.
fn with_state(log: &[u8], state: &[u8; 4], dropped: u64) -> Vec<u8> {
    let (mut log, at) = (log.to_vec(), totals_at(log));
    log[at + 8..at + 16].copy_from_slice(&dropped.to_le_bytes());
    log[at + 16..at + 20].copy_from_slice(state);
    let crc = crc32fast::hash(&log[at..at + 20]);
    log[at + 20..at + 24].copy_from_slice(&crc.to_le_bytes());
    log
}

fn broken(bytes: &[u8]) -> Broken {
    let (mut scheduler, tasks) = scheduler();
    let change = |scheduler: &mut Scheduler<Small>, _, now| grow(scheduler, tasks[0], now);
    replay(&mut Reader::new(bytes).expect("a log"), &mut scheduler, change, |_, _| {})
        .expect_err("it is not whole")
}

#[test]
fn the_last_entry_says_when_and_how_the_run_ended() {
    let (file, totals) = recorded("end", 100);
    let bytes = fs::read(&file.0).unwrap();
    let mut log = Reader::new(&*bytes).unwrap();
    let mut last = None;
    while let Some(entry) = log.next_entry().unwrap() {
        last = Some(entry);
    }
    let last = last.expect("it has entries");
    assert_eq!((last.call, last.now), (Call::End, Instant::from_nanos(100_000_000)));
    let Answer::End(end) = last.answer else { panic!("{last}") };
    assert!(end.counters.units > 0 && end.counters.clock_steps_back == 2, "{end:?}");
    assert_eq!(log.totals().map(|totals| totals.entries), Some(totals.entries));
}

#[test]
fn a_step_back_of_the_clock_is_counted_once_with_a_log_and_without() {
    let file = Scratch::new("step back");
    let (_writer, mut tape) = Writer::start(&file.0, &header()).unwrap();
    let steps = [None, Some(&mut tape)].map(|tape| {
        let (mut scheduler, tasks) = scheduler();
        let mut recorder = Recorder::new(&mut scheduler, tape);
        let [early, late] = [1, 2].map(Instant::from_nanos);
        recorder.release_at(tasks[0], late, None, late).expect("room");
        let Some(Action::Dispatch(dispatch)) = recorder.poll_on(LaneId::new(0), late) else {
            panic!("nothing starts");
        };
        recorder.complete_and_poll(dispatch.unit, early).expect("it runs");
        scheduler.counters().clock_steps_back
    });
    assert_eq!(steps, [1, 1]);
}

/// What a recording is that polls, and ends so many times, and polls so many times more.
fn ended(name: &str, ends: usize, after: usize) -> Result<(u64, Option<u64>), LogError> {
    let file = Scratch::new(name);
    let (writer, mut tape) = Writer::start(&file.0, &header()).unwrap();
    let (mut scheduler, _) = scheduler();
    let recorder = &mut Recorder::new(&mut scheduler, Some(&mut tape));
    let (lane, now) = (LaneId::new(0), Instant::from_nanos(1));
    assert!(recorder.poll_on(lane, now).is_none());
    (0..ends).for_each(|_| recorder.end(now));
    (0..after).for_each(|_| assert!(recorder.poll_on(lane, now).is_none()));
    drop(tape);
    assert!(writer.finish().1.is_none());
    again(&fs::read(&file.0).unwrap(), |_| {})
}

#[test]
fn lanes_that_a_host_makes_up_are_no_other_lanes_in_the_log() {
    let file = Scratch::new("made-up");
    let (writer, mut tape) = Writer::start(&file.0, &header()).unwrap();
    let (mut scheduler, tasks) = scheduler();
    let recorder = &mut Recorder::new(&mut scheduler, Some(&mut tape));
    let now = Instant::from_nanos(1);
    for lane in [62, 63, 64, 127, 255].map(LaneId::new) {
        assert!(!recorder.retire_lane(lane) && !recorder.restore_lane(lane));
        recorder.release_at(tasks[1], now, None, now).ok();
        while recorder.poll_on(lane, now).is_some() {}
    }
    recorder.end(now);
    drop(tape);
    let (totals, _) = writer.finish();
    assert_eq!(again(&fs::read(&file.0).unwrap(), |_| {}).unwrap(), (totals.entries, None));
}

#[test]
fn a_log_ends_with_the_end_of_the_run_and_nothing_else() {
    assert!(matches!(ended("end-once", 1, 0), Ok((2, None))));
    assert!(matches!(ended("end-never", 0, 1), Err(LogError::Unended)));
    for (ends, after) in [(1, 1), (2, 0)] {
        assert!(matches!(ended("end-again", ends, after), Err(LogError::Damaged { .. })), "{ends}, {after}");
    }
}

#[test]
fn a_log_without_its_last_inputs_is_fed_up_to_there_and_says_why() {
    let (file, totals) = recorded("cut", 60);
    let bytes = fs::read(&file.0).unwrap();
    let cuts =
        [(Cut::Slow, b"SLOW"), (Cut::Failed, b"FAIL"), (Cut::TooLarge, b"LONG"), (Cut::Panicked, b"LOST")];
    for (cut, state) in cuts {
        let found = broken(&with_state(&bytes, state, 17));
        assert!(
            matches!(found.error, LogError::Incomplete { dropped: 17, cut: why } if why == cut),
            "{:?}",
            found.error
        );
        assert_eq!(found.inputs, totals.entries);
        assert!(found.to_string().contains(cut.cure()), "{found}");
    }
    // A state that nobody writes, and a whole log that something is missing in.
    for (state, dropped) in [(b"OTHR", 0), (b"DONE", 1)] {
        assert!(matches!(again(&with_state(&bytes, state, dropped), |_| {}), Err(LogError::Damaged { .. })));
    }
}

#[test]
fn the_log_of_a_killed_program_is_fed_up_to_its_last_whole_block() {
    // Several blocks, and as the file lies there before anybody closes it.
    let (file, totals) = recorded("killed", 20_000);
    let bytes = fs::read(&file.0).unwrap();
    let at = totals_at(&bytes);
    let mut open = with_state(&bytes, &[0; 4], 0);
    open[at..at + 8].fill(0);
    let crc = crc32fast::hash(&open[at..at + 20]);
    open[at + 20..at + 24].copy_from_slice(&crc.to_le_bytes());
    // Everything is there, then the last block is not, then not even the first.
    let blocks = blocks(&bytes, at + 24);
    assert!(blocks.len() > 2, "{blocks:?}");
    let (last, entries_of_last) = blocks[blocks.len() - 1];
    for (end, inputs) in [
        (open.len(), totals.entries),
        (open.len() - 1, totals.entries - entries_of_last),
        (last + 5, totals.entries - entries_of_last),
        (last, totals.entries - entries_of_last),
        (at + 24, 0),
    ] {
        let found = broken(&open[..end]);
        assert!(matches!(found.error, LogError::NotClosed), "{end}: {:?}", found.error);
        assert_eq!(found.inputs, inputs, "{end}");
    }
    // A block that is there and damaged is no end.
    open[last - 1] ^= 1;
    assert!(matches!(broken(&open).error, LogError::Damaged { .. }));
}

/// Where each block begins, and its entries.
pub(crate) fn blocks(log: &[u8], mut at: usize) -> Vec<(usize, u64)> {
    let int = |at: usize| u32::from_le_bytes(log[at..at + 4].try_into().unwrap());
    let mut blocks = Vec::new();
    while at < log.len() {
        blocks.push((at, int(at).into()));
        at += 12 + int(at + 4) as usize;
    }
    blocks
}

#[test]
fn a_truncated_log_is_fed_up_to_the_cut() {
    let (file, totals) = recorded("truncated-fed", 20_000);
    let bytes = fs::read(&file.0).unwrap();
    let (_, entries_of_last) = *blocks(&bytes, totals_at(&bytes) + 24).last().expect("blocks");
    let found = broken(&bytes[..bytes.len() - 1]);
    assert!(matches!(found.error, LogError::Truncated { .. }), "{:?}", found.error);
    assert_eq!(found.inputs, totals.entries - entries_of_last);
}
