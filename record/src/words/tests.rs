use super::*;
use red_core::Instant;

fn unit(sequence: u64, node: u64, lane: u64) -> UnitId {
    UnitId::from_bits(sequence << 16 | node << 8 | lane)
}

fn start(unit: UnitId) -> Answer {
    Answer::Polled(Some(Action::Dispatch(Dispatch { unit, lane: unit.lane() })))
}

fn at(ns: u64, call: Call, answer: Answer) -> Entry {
    Entry { now: Instant::from_nanos(ns), call, answer }
}

fn outcome(shed: Option<ShedReason>) -> Outcome {
    Outcome {
        job: JobId::from_bits(0x0007_0003),
        task: TaskId::from_bits(2),
        index: 41,
        release: Instant::from_nanos(1_000),
        deadline: Instant::from_nanos(90_000),
        at: Instant::from_nanos(95_000),
        shed,
    }
}

/// Every kind of entry, with every code, and times that go on, jump and go back.
fn all() -> Vec<Entry> {
    let (lane, first, second) = (LaneId::new(3), unit(1, 7, 3), unit(2, 255, 31));
    let release =
        |capture| Call::Release { task: TaskId::from_bits(5), at: Instant::from_nanos(90), capture };
    let mut entries = vec![
        at(100, release(None), Answer::Released(Ok(JobId::from_bits(0x0001_0002)))),
        at(100, release(Some(u64::MAX)), Answer::Released(Ok(JobId::from_bits(u32::MAX)))),
        at(100, Call::Poll(Some(lane)), start(first)),
        at(100, Call::Poll(None), start(second)),
        at(100, Call::Poll(Some(LaneId::new(31))), Answer::Polled(None)),
        at(200, Call::Complete(first), Answer::Reported(Ok(()))),
        at(u64::MAX, Call::Complete(second), Answer::Reported(Ok(()))),
        // A host that makes handles up, and a clock that goes back.
        at(50, Call::Complete(unit(77, 1, 200)), Answer::Reported(Err(CompleteError::NotRunning))),
        at(50, Call::Fail(second), Answer::Reported(Ok(()))),
        at(60, Call::Poll(None), start(unit(900, 1, 2))),
        at(60, Call::Poll(None), Answer::Polled(Some(Action::Preempt(Dispatch { unit: first, lane })))),
        at(95_500, Call::Poll(None), Answer::Polled(Some(Action::Ended(outcome(None))))),
        at(95_500, Call::TakeOutcome, Answer::Outcome(None)),
        at(95_500, Call::Edit(3), Answer::Edited(Ok(()))),
        at(95_500, Call::Retire(lane), Answer::Done(true)),
        at(95_500, Call::Restore(lane), Answer::Done(false)),
        at(95_500, Call::Remove(TaskId::from_bits(u32::MAX)), Answer::Done(true)),
        at(95_500 + STEP - 1, Call::Poll(None), Answer::Polled(None)),
        at(95_500 + 2 * STEP, Call::Poll(None), Answer::Polled(None)),
    ];
    entries.extend(RELEASE.map(|e| at(1, release(None), Answer::Released(Err(e)))));
    entries.extend(REPORT.map(|e| at(1, Call::Complete(first), Answer::Reported(Err(e)))));
    entries.extend(COMMIT.map(|e| at(1, Call::Edit(0), Answer::Edited(Err(e)))));
    entries.extend(SHED.map(|reason| at(1, Call::TakeOutcome, Answer::Outcome(Some(outcome(Some(reason)))))));
    let mut counters = Counters::default();
    (counters.units, counters.evictions) = (u64::MAX, 3);
    entries.push(at(1, Call::End, Answer::Counters(counters)));
    entries
}

fn written(entries: &[Entry]) -> Chunk {
    let (mut books, mut chunk) = (Books::new(), Chunk::new());
    for entry in entries {
        let before = chunk.words().len();
        books.encode(entry, &mut chunk);
        let words = chunk.words().len() - before;
        assert!((1..=LONGEST).contains(&words), "{entry}: {words} words");
    }
    chunk
}

#[test]
fn every_entry_comes_back_as_it_was_written() {
    let entries = all();
    let chunk = written(&entries);
    let (mut books, mut words) = (Books::new(), chunk.words().iter().copied());
    for entry in &entries {
        let read = books.decode(|| words.next().ok_or(())).unwrap();
        assert_eq!(read, Some(*entry), "{entry}");
    }
    assert_eq!(words.next(), None);
}

#[test]
fn what_a_node_costs_is_three_words() {
    let node = unit(1, 4, 0);
    let entries = [
        at(10, Call::Poll(Some(LaneId::new(0))), start(node)),
        at(10, Call::Poll(Some(LaneId::new(0))), Answer::Polled(None)),
        at(20, Call::Complete(node), Answer::Reported(Ok(()))),
    ];
    assert_eq!(written(&entries).words().len(), 3);
}

#[test]
fn words_that_nobody_wrote_are_no_entry() {
    for word in [11, 15, 4 | 9 << 4, 2 | 9 << 4 | 3 << 8, 7 | 63 << 8] {
        let mut words = [word, 0, 0, 0, 0, 0, 0].into_iter();
        assert_eq!(Books::new().decode(|| words.next().ok_or(())), Ok(None), "{word:#x}");
    }
}
