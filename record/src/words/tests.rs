use super::codes::{ADMIT, POOL, SENSOR, SHED};
use super::*;
use crate::entry::End;
use crate::started::{Members, Started};
use red_core::{
    Bound, Bytes, Certificate, CompleteError, Contention, Counters, Duration, Frame, Node, NodeId, Outcome,
    PoolId, Ppm, SensorId, ShedReason, Wcet,
};

fn unit(sequence: u64, node: u64, lane: u64) -> UnitId {
    UnitId::from_bits(sequence << 16 | node << 8 | lane)
}

/// A unit of the job that was released last in place 3.
fn start(unit: UnitId) -> Answer {
    Answer::Started(Started { unit, job: JobId::from_bits(0x0007_0003), members: None })
}

fn ahead(unit: UnitId) -> Answer {
    Answer::Ahead(Started { unit, job: JobId::from_bits(0x0007_0003), members: None })
}

fn started(unit: UnitId, job: u32, members: Option<(u64, u64)>) -> Answer {
    let members = members.map(|(jobs, nodes)| Members { jobs, nodes });
    Answer::Started(Started { unit, job: JobId::from_bits(job), members })
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

/// Every kind of set-up call and of a graph's parts, with every code.
fn set_up() -> Vec<Entry> {
    let at = |call, answer| at(95_500, call, answer);
    let pool = |memory| Call::AddPool { lanes: 255, memory };
    let sensor = Call::AddSensor(Duration::from_nanos(u64::MAX));
    let task = |ns, period| {
        let (deadline, period) = (Duration::from_nanos(ns), Option::map(period, Duration::from_nanos));
        Call::AddTask { deadline, period, value: u32::MAX, floor: [127, 128] }
    };
    let commit = Call::Commit { task: TaskId::from_bits(u32::MAX), revision: u32::MAX };
    let node = |place, node| at(Call::Node { place: NodeId::new(place), node }, Answer::Nothing);
    let wcet = Wcet::from_nanos(u64::MAX);
    let frame =
        |sensor| Frame { weights: u16::MAX, frame: 0x0102, sensor: Option::map(sensor, SensorId::new) };
    let edges = |group, to| Call::Edges { from: NodeId::new(200), group, to };
    let mut entries = vec![
        at(pool(None), Answer::Pool(Ok(PoolId::new(31)))),
        at(pool(Some(Bytes(0))), Answer::Pool(Ok(PoolId::new(0)))),
        at(pool(Some(Bytes(u64::MAX))), Answer::Pool(Ok(PoolId::new(255)))),
        at(Call::DispatchAhead(PoolId::new(255)), Answer::Done(false)),
        at(Call::DispatchAhead(PoolId::new(0)), Answer::Done(true)),
        at(Call::LosePool(PoolId::new(3)), Answer::Done(true)),
        at(Call::LosePool(PoolId::new(255)), Answer::Done(false)),
        at(Call::ObserveUse(PoolId::new(255), Ppm(u32::MAX)), Answer::Done(true)),
        at(sensor, Answer::Sensor(Ok(SensorId::new(7)))),
        node(0, Node::new(Wcet::ZERO)),
        node(
            255,
            Node::new(wcet).best_case(Duration::from_nanos(3)).memory(Bytes(4)).in_pool(PoolId::new(9)),
        ),
        node(3, Node::new(wcet).atomic(Contention::ZERO)),
        node(3, Node::decoder(Wcet::ZERO).atomic(Contention::from_nanos(u64::MAX))),
        node(4, Node::shared_encoder(wcet, frame(None))),
        node(4, Node::shared_encoder(wcet, frame(Some(0)))),
        node(4, Node::shared_encoder(wcet, frame(Some(255))).in_pool(PoolId::new(255))),
        at(edges(0, 1), Answer::Nothing),
        at(edges(3, u64::MAX), Answer::Nothing),
        at(task(u64::MAX, None), Answer::Task(Ok(TaskId::from_bits(u32::MAX)))),
        at(task(1, Some(0)), Answer::Task(Ok(TaskId::from_bits(0)))),
    ];
    for (bound, memory_holds) in
        [(Bound::Graham, true), (Bound::LongPath { paths: 255 }, false), (Bound::SeveralPools, true)]
    {
        let [work, critical_path, response, limit] = [5, u64::MAX, 0, 1 << 62].map(Duration::from_nanos);
        let proof = Certificate { bound, lanes: 32, work, critical_path, response, limit, memory_holds };
        entries.push(at(commit, Answer::Committed(Ok(proof))));
    }
    entries.extend(POOL.map(|e| at(pool(None), Answer::Pool(Err(e)))));
    entries.extend(SENSOR.map(|e| at(sensor, Answer::Sensor(Err(e)))));
    entries.extend(ADMIT.map(|e| at(task(0, None), Answer::Task(Err(e)))));
    entries.extend(COMMIT.map(|e| at(commit, Answer::Committed(Err(e)))));
    entries
}

/// Every kind of entry, with every code, and times that go on, jump and go back.
fn all() -> Vec<Entry> {
    let (lane, first, second) = (LaneId::new(3), unit(1, 7, 3), unit(2, 255, 31));
    let release =
        |capture| Call::Release { task: TaskId::from_bits(5), at: Instant::from_nanos(90), capture };
    let mut entries = vec![
        at(100, release(None), Answer::Released(Ok(JobId::from_bits(0x0001_0002)))),
        at(100, release(Some(u64::MAX)), Answer::Released(Ok(JobId::from_bits(u32::MAX)))),
        at(100, release(None), Answer::Released(Ok(JobId::from_bits(0x0007_0003)))),
        at(100, Call::Poll(Some(lane)), start(first)),
        at(100, Call::Poll(None), start(second)),
        at(100, Call::Poll(Some(LaneId::new(31))), Answer::Nothing),
        at(200, Call::Complete(first), Answer::Reported(Ok(()))),
        at(u64::MAX, Call::Complete(second), Answer::Reported(Ok(()))),
        // A host that makes handles up, and a clock that goes back.
        at(50, Call::Complete(unit(77, 1, 200)), Answer::Reported(Err(CompleteError::NotRunning))),
        at(50, Call::Fail(second), Answer::Reported(Ok(()))),
        at(60, Call::Poll(None), start(unit(900, 1, 2))),
        at(60, Call::Poll(None), Answer::Preempted(first)),
        // A job whose release is not in the log, one whose place is another's by now, and units of several jobs.
        at(60, Call::Poll(Some(lane)), started(unit(901, 1, 3), 0x0001_0009, None)),
        at(60, Call::Poll(Some(lane)), started(unit(902, 1, 3), 0x0006_0003, None)),
        at(60, Call::Poll(Some(lane)), started(unit(903, 1, 3), 0x0007_0003, Some((1 << 63, u64::MAX)))),
        at(60, Call::Poll(None), started(unit(7, 1, 3), 0x0001_0002, Some((3, 258)))),
        // One behind another on the same lane, which is reported first.
        at(60, Call::Poll(Some(lane)), start(unit(904, 9, 3))),
        at(60, Call::Poll(Some(lane)), ahead(unit(905, 1, 3))),
        at(61, Call::Complete(unit(904, 9, 3)), Answer::Reported(Ok(()))),
        at(62, Call::Complete(unit(905, 1, 3)), Answer::Reported(Ok(()))),
        at(95_500, Call::Poll(None), Answer::Ended(outcome(None))),
        at(95_500, Call::TakeOutcome, Answer::Nothing),
        at(95_500, Call::Edit(3), Answer::Edited(Ok(()))),
        at(95_500, Call::Retire(lane), Answer::Done(true)),
        at(95_500, Call::Restore(lane), Answer::Done(false)),
        at(95_500, Call::Remove(TaskId::from_bits(u32::MAX)), Answer::Done(true)),
        at(95_500 + STEP - 1, Call::Poll(None), Answer::Nothing),
        at(95_500 + 2 * STEP, Call::Poll(None), Answer::Nothing),
    ];
    entries.extend(set_up());
    entries.extend(RELEASE.map(|e| at(1, release(None), Answer::Released(Err(e)))));
    entries.extend(REPORT.map(|e| at(1, Call::Complete(first), Answer::Reported(Err(e)))));
    entries.extend(COMMIT.map(|e| at(1, Call::Edit(0), Answer::Edited(Err(e)))));
    entries.extend(SHED.map(|reason| at(1, Call::TakeOutcome, Answer::Ended(outcome(Some(reason))))));
    let mut counters = Counters::default();
    (counters.units, counters.evictions) = (u64::MAX, 3);
    entries.push(at(1, Call::End, Answer::End(End { counters, jobs_in_flight: 64, starts: u64::MAX })));
    entries
}

fn written(entries: &[Entry]) -> Chunk {
    let (mut books, mut chunk) = (Books::new(), Chunk::new());
    for entry in entries {
        let before = chunk.words().len();
        // As `Recorder` does.
        let is_usual = match (entry.call, entry.answer) {
            (Call::Complete(unit), Answer::Reported(Ok(()))) => books.begin_turn(unit, entry.now),
            (Call::Poll(Some(lane)), Answer::Nothing) => books.end_turn(lane, entry.now, &mut chunk),
            (Call::Poll(Some(lane)), Answer::Started(started)) => books.go_on_turn(lane, &started, entry.now),
            _ => false,
        };
        if is_usual {
            continue;
        }
        if !books.is_near(entry.now) {
            books.spell(entry.now, &mut chunk);
        }
        books.encode(entry, &mut chunk);
        let words = chunk.words().len() - before;
        assert!(words <= LONGEST, "{entry}: {words} words");
    }
    books.break_turn(&mut chunk);
    assert_eq!(chunk.entries(), entries.len() as u64);
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

/// What a lane does at one turn after another.
fn turns() -> Vec<Entry> {
    let lane = LaneId::new(3);
    let poll = |ns, answer| at(ns, Call::Poll(Some(lane)), answer);
    let release = Call::Release { task: TaskId::from_bits(5), at: Instant::ZERO, capture: None };
    let mut entries = vec![at(0, release, Answer::Released(Ok(JobId::from_bits(0x0007_0003))))];
    entries.push(poll(5, Answer::Nothing));
    for n in 1..5 {
        let (ns, done) = (n * 10, Answer::Reported(Ok(())));
        entries.push(at(ns, Call::Complete(unit(n - 1, 4, 3)), done));
        entries.push(poll(ns, start(unit(n, 4, 3))));
        entries.push(poll(ns, Answer::Nothing));
    }
    entries.push(at(60, Call::Complete(unit(4, 4, 3)), Answer::Reported(Ok(()))));
    entries.push(poll(60, Answer::Nothing));
    // The first unit was not this scheduler's.
    entries.remove(2);
    entries
}

#[test]
fn a_turn_is_one_word() {
    let chunk = written(&turns());
    // Three turns go on, the last one does not; before them a release of four words, a poll, and the first unit with its
    // poll.
    assert_eq!(chunk.words().len(), 4 + 4 + 3);
    assert_eq!(chunk.entries(), turns().len() as u64);
}

#[test]
fn a_turn_that_goes_another_way_comes_back_as_it_was_written() {
    // Everything else that may come, at every place of a turn.
    for planted in all() {
        for place in 0..=turns().len() {
            let mut entries = turns();
            entries.insert(place, planted);
            let chunk = written(&entries);
            let (mut books, mut words) = (Books::new(), chunk.words().iter().copied());
            for entry in &entries {
                let read = books.decode(|| words.next().ok_or(())).unwrap();
                assert_eq!(read, Some(*entry), "{planted} at {place}");
            }
            assert_eq!(words.next(), None);
        }
    }
}

#[test]
fn words_that_nobody_wrote_are_no_entry() {
    for word in [
        12,
        15,
        11 | 63 << 8,
        11 | 2 << 4,
        4 | 9 << 4,
        4 | 1 << 4 | 63 << 8,
        2 | 9 << 4 | 3 << 8,
        7 | 63 << 8,
        // A set-up call of no kind, on a lane, and a node with an answer.
        12 | 63 << 8 | 9 << 14,
        12 | 2 << 4 | 63 << 8 | 6 << 14,
        12 | 3 << 8 | 2 << 14,
        12 | 1 << 4 | 63 << 8 | 2 << 14,
        14,
    ] {
        let mut words = [word, 0, 0, 0, 0, 0, 0].into_iter();
        assert_eq!(Books::new().decode(|| words.next().ok_or(())), Ok(None), "{word:#x}");
    }
}

#[test]
fn each_job_of_a_place_and_each_set_of_members_is_another_entry() {
    let lane = LaneId::new(3);
    let jobs =
        [(0x0007_0003, None), (0x0008_0003, None), (0x0007_0003, Some((8, 7))), (0x0007_0003, Some((8, 6)))];
    for (job, members) in jobs {
        let mut entries = turns();
        let last = entries.len() - 1;
        entries.truncate(last - 1);
        entries.push(at(60, Call::Complete(unit(4, 4, 3)), Answer::Reported(Ok(()))));
        entries.push(at(60, Call::Poll(Some(lane)), started(unit(5, 4, 3), job, members)));
        let chunk = written(&entries);
        let (mut books, mut words) = (Books::new(), chunk.words().iter().copied());
        let read = entries.iter().map(|_| books.decode(|| words.next().ok_or(())).unwrap().unwrap());
        assert_eq!(read.last(), entries.last().copied(), "{job:#x}");
    }
}

#[test]
fn no_bit_of_a_set_up_entry_is_without_a_meaning() {
    for entry in set_up() {
        let chunk = written(&[entry]);
        for place in 0..chunk.words().len() {
            // In the first word only below the time.
            for bit in 0..if place == 0 { 28 } else { 64 } {
                let mut words = chunk.words().to_vec();
                words[place] ^= 1 << bit;
                let mut words = words.into_iter();
                let read = Books::new().decode(|| words.next().ok_or(()));
                assert_ne!(read, Ok(Some(entry)), "{entry}: bit {bit} of word {place}");
            }
        }
    }
}
