//! Any bytes as a replay log: as they are, or as the words of a log whose checksums are right, so that what lies behind
//! them is reached. What can be read is fed to a scheduler.
#![no_main]

use std::hint::black_box;

use libfuzzer_sys::fuzz_target;
use red_core::{Config, Dag, Duration, Node, Scheduler, Timing, Wcet};
use red_record::{Call, FORMAT, Header, Reader, replay};

type Small = red_core::Caps<2, 4, 3, 2>;

fuzz_target!(|bytes: &[u8]| {
    match bytes {
        [0, log @ ..] => read(log),
        [entries, words @ ..] => read(&sealed(*entries, words)),
        [] => {}
    }
});

/// A log of one block with these words, every checksum right.
fn sealed(entries: u8, words: &[u8]) -> Vec<u8> {
    let header = Header {
        program: String::new(),
        capacities: Header::capacities_of::<Small>(),
        policy: "redrt".into(),
        duration_ns: 1,
        realtime: false,
        file: String::new(),
        format: "toml".into(),
        workload: String::new(),
    };
    let header = serde_json::to_vec(&header).expect("plain data");
    let mut totals = [u64::from(entries).to_le_bytes(), [0; 8]].concat();
    totals.extend(b"DONE");
    let mut log = [&b"REDLOG"[..], &FORMAT.to_le_bytes()].concat();
    let part = |log: &mut Vec<u8>, bytes: &[u8]| {
        log.extend((bytes.len() as u32).to_le_bytes());
        log.extend(crc32fast::hash(bytes).to_le_bytes());
        log.extend(bytes);
    };
    part(&mut log, &header);
    log.extend(&totals);
    log.extend(crc32fast::hash(&totals).to_le_bytes());
    log.extend(u32::from(entries).to_le_bytes());
    part(&mut log, words);
    log
}

fn read(log: &[u8]) {
    let mut reader = match Reader::new(log) {
        Ok(reader) => reader,
        Err(refusal) => {
            black_box(refusal.to_string());
            return;
        }
    };
    let mut scheduler = Scheduler::<Small>::new(Config::REDRT.with_lanes(2));
    for cost in [1, 2] {
        let mut dag = Dag::new();
        let first = dag.add_node(Node::new(Wcet::from_millis(cost))).expect("room");
        let last = dag.add_node(Node::new(Wcet::from_millis(1))).expect("room");
        dag.add_edge(first, last).expect("no cycle");
        scheduler.add_task(&dag, Timing::new(Duration::from_millis(5))).expect("room");
    }
    let (entries, mut last) = (reader.totals().map(|totals| totals.entries), None);
    let change = |_: &mut Scheduler<Small>, number: u32, _| {
        assert!(!cfg!(feature = "planted") || number != 1, "a planted bug");
        Err(red_core::CommitError::Busy)
    };
    match replay(&mut reader, &mut scheduler, change, |_, entry| last = Some(entry.call)) {
        Ok(run) => {
            assert!(
                entries.is_some_and(|entries| run.inputs <= entries),
                "{} inputs of {entries:?}",
                run.inputs
            );
            assert!(run.difference.is_some() || last == Some(Call::End), "a log that ends with {last:?}");
            black_box(run.difference.map(|difference| format!("{difference:?}")));
        }
        Err(broken) => {
            black_box(broken.to_string());
        }
    }
}
