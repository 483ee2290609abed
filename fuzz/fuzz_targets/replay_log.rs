//! Any bytes as a replay log: as they are; as the blocks of a log whose checksums are right, so that what lies behind
//! them is reached; and as changes to the log of a run, so that what comes late in one is reached. What can be read is
//! fed to a scheduler.
#![no_main]

mod keys;
mod recorded;

use std::hint::black_box;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use recorded::{Block, CONFIG, RUN, Small, change, scheduler, sealed};
use red_core::Scheduler;
use red_record::{Call, Reader, replay, replay_calls};

// The thread that records the run is no part of an input.
fuzz_target!(init: { LazyLock::force(&RUN); }, |bytes: &[u8]| {
    match bytes {
        [0, log @ ..] => {
            if let Ok(mut log) = Reader::new(log) {
                _ = replay_calls::<Small, _>(&mut log, &mut Scheduler::new(CONFIG), |_, _| {});
            }
            _ = read(log, scheduler());
        }
        // Their tasks are there, so that little is needed to get far.
        [1, closed, blocks @ ..] => _ = read(&sealed(&split(blocks), *closed != 0), scheduler()),
        [_, closed, changes @ ..] => {
            let whole = read(&sealed(&changed(changes), *closed != 0), Scheduler::new(CONFIG));
            assert!(whole || !changes.is_empty() || *closed == 0, "the log of a run is not replayed");
        }
        _ => {}
    }
});

/// Blocks, each after its entries and its length.
fn split(mut bytes: &[u8]) -> Vec<Block> {
    let mut blocks = Vec::new();
    while let [entries, length, rest @ ..] = bytes {
        let (words, others) = rest.split_at(usize::from(*length).min(rest.len()));
        blocks.push(Block { entries: (*entries).into(), words: words.to_vec() });
        bytes = others;
    }
    blocks
}

/// The run's block with changes: each is a place in 14 bits, what to do there in two, and a byte.
fn changed(changes: &[u8]) -> Vec<Block> {
    let mut block = RUN.clone();
    let mut split = None;
    for change in changes.chunks_exact(3) {
        let [low, high, byte] = *change else { break };
        let at = usize::from(u16::from_le_bytes([low, high & 63])) % (block.words.len() + 1);
        match high >> 6 {
            0 if at < block.words.len() => block.words[at] = byte,
            1 => block.words.insert(at, byte),
            2 if at < block.words.len() => _ = block.words.remove(at),
            // The entries before it have to be guessed: rarely right, but then two blocks are one run.
            3 => split = Some((at, byte)),
            _ => {}
        }
    }
    let Some((at, entries)) = split.filter(|(at, _)| *at <= block.words.len()) else { return vec![block] };
    let words = block.words.split_off(at);
    let first = block.entries.min(entries.into());
    let second = Block { entries: block.entries - first, words };
    vec![Block { entries: first, ..block }, second]
}

/// Whether it was replayed to its end without a difference, on this scheduler.
fn read(log: &[u8], mut scheduler: Scheduler<Small>) -> bool {
    let mut reader = match Reader::new(log) {
        Ok(reader) => reader,
        Err(refusal) => {
            black_box(refusal.to_string());
            return false;
        }
    };
    let (entries, mut last) = (reader.totals().map(|totals| totals.entries), None);
    let change = |scheduler: &mut _, number, now| {
        assert!(!cfg!(feature = "planted") || number != 1, "a planted bug");
        change(scheduler, number, now)
    };
    let watch = |_: &_, entry: &red_record::Entry| {
        black_box(entry.to_string());
        last = Some(entry.call);
    };
    match replay(&mut reader, &mut scheduler, change, watch) {
        Ok(run) => {
            let whole = run.difference.is_none();
            let inputs = run.inputs;
            assert!(
                entries.map_or(!whole, |all| inputs <= all && (inputs == all || !whole)),
                "{inputs} of {entries:?}"
            );
            assert!(!whole || last == Some(Call::End), "a log that ends with {last:?}");
            black_box(run.difference.map(|difference| format!("{difference:?}")));
            whole
        }
        Err(broken) => {
            black_box(broken.to_string());
            false
        }
    }
}
