use super::*;
use crate::entry::{Answer, Call};

fn entry(ns: u64) -> Entry {
    Entry { now: Instant::from_nanos(ns), call: Call::Poll(None), answer: Answer::Polled(None) }
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
