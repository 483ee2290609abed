//! `redrt replay` of logs that no `redrt run` wrote: a program set its scheduler up by calls on a `Recorder`.

#[path = "process/page.rs"]
mod page;
mod process;
#[path = "process/refused.rs"]
mod refused;

use process::{file, run};
use red_core::{
    Action, Capacity, Caps, Config, Dag, Duration, Empty, Frame, Instant, LaneId, Node, Scheduler, Timing,
    Wcet,
};
use red_record::class::{Large, Medium, Small};
use red_record::{Header, Recorder, Writer};
use refused::refused;
use serde_json::Value;
use std::fs;

const CONFIG: Config = Config::REDRT.with_lanes(2);

fn ms(ms: u64) -> Instant {
    Instant::from_nanos(ms * 1_000_000)
}

/// Records a camera, an encoder and two decoders over ten frames, and a node that comes in the middle; the header says
/// that the scheduler is configured so. Where the log is.
fn recorded<C: Capacity>(name: &str, config: Config) -> String {
    let log = file(&format!("replay-calls-{name}.redlog"), b"");
    let header = Header::by_calls::<C>("robot 7", "redrt", config);
    let (writer, mut tape) = Writer::start(&log, &header).expect("the folder for tests takes files");
    let mut scheduler: Box<Scheduler<C>> = Box::new(Scheduler::EMPTY);
    scheduler.configure(CONFIG);
    let host = &mut Recorder::new(&mut scheduler, Some(&mut tape));
    let sensor = host.add_sensor(Duration::from_millis(20)).expect("room");
    let mut dag = Dag::new();
    let mut add = |node| dag.add_node(node).expect("room");
    let camera = add(Node::new(Wcet::from_millis(2)));
    let frame = Frame { weights: 0, frame: 0, sensor: Some(sensor) };
    let encoder = add(Node::shared_encoder(Wcet::from_millis(4), frame));
    let decoders = [3, 5].map(|cost| add(Node::decoder(Wcet::from_millis(cost))));
    dag.add_edge(camera, encoder).expect("no cycle");
    decoders.into_iter().for_each(|decoder| dag.add_edge(encoder, decoder).expect("no cycle"));
    let timing = Timing::new(Duration::from_millis(60)).every(Duration::from_millis(20));
    let tasks = [host.add_task(&dag, timing), host.add_task(&dag, timing)].map(|task| task.expect("room"));
    let mut running = Vec::new();
    for now in 0..260 {
        running.retain(|(unit, until)| *until > now || host.complete(*unit, ms(now)).is_err());
        if now % 20 == 0 && now < 200 {
            for task in tasks {
                host.release_at(task, ms(now), None, ms(now)).expect("room");
            }
        }
        if now == 100 {
            let mut edit = Scheduler::edit(host, tasks[0]).expect("the task is there");
            let new = edit.add_node(Node::new(Wcet::from_millis(1))).expect("room");
            edit.add_edge(camera, new).expect("no cycle");
            assert!(host.commit(&edit, ms(now)).expect("it is admitted").fits());
        }
        for lane in [0, 1].map(LaneId::new) {
            while let Some(action) = host.poll_on(lane, ms(now)) {
                if let Action::Dispatch(start) = action {
                    running.push((start.unit, now + 1 + start.unit.node().index() as u64));
                }
            }
        }
    }
    host.end(ms(260));
    drop(tape);
    assert!(writer.finish().1.is_none());
    log.to_str().expect("the path is text").to_owned()
}

fn report(log: &str) -> (i32, Value) {
    let (status, out, err) = run(&["replay", log, "--json"]);
    (status, serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}{err}")))
}

#[test]
fn a_log_by_calls_has_a_report_with_numbers_for_names() {
    let log = recorded::<Small>("report", CONFIG);
    let (status, out, err) = run(&["report", &log, "--json", "--force"]);
    assert_eq!(status, 0, "{err}");
    let told: Value = serde_json::from_str(&out).expect("one JSON object");
    let page = fs::read_to_string(log.replace(".redlog", ".html")).expect("the page");
    assert_eq!(page::data(&page), told);
    let tasks: Vec<(&Value, &Value)> =
        told["tasks"].as_array().unwrap().iter().map(|task| (&task["name"], &task["released"])).collect();
    assert_eq!(tasks, [(&"task-0".into(), &10.into()), (&"task-1".into(), &10.into())]);
    assert_eq!(told["edits"][0]["change"], "task-0: +node-4");
    let (_, out, _) = run(&["replay", &log, "--json"]);
    let replayed: Value = serde_json::from_str(&out).expect("one JSON object");
    assert_eq!((&replayed["equal"], &told["pools"][0]["lanes"]), (&true.into(), &2.into()));
}

#[test]
fn a_log_by_calls_is_replayed_without_a_difference_whatever_its_class() {
    let logs = [
        recorded::<Small>("small", CONFIG),
        recorded::<Medium>("medium", CONFIG),
        recorded::<Large>("large", CONFIG),
    ];
    for log in logs {
        let (status, out, err) = run(&["replay", &log]);
        assert_eq!(status, 0, "{out}{err}");
        let said = "recorded by robot 7: set up by calls, under policy redrt, best effort";
        assert!(out.contains(said) && out.contains("no difference"), "{out}");
        let (status, report) = report(&log);
        assert_eq!((status, report["equal"].as_bool(), &report["policy"]), (0, Some(true), &"redrt".into()));
        let keys: Vec<_> = report.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["actions", "difference", "equal", "inputs", "policy", "refused"]);
        assert!(report["actions"].as_u64().unwrap() > 80 && report["refused"].is_null(), "{report}");
    }
}

#[test]
fn a_difference_is_told_by_the_numbers_of_tasks_and_nodes() {
    // A lane less than it ran on.
    let log = recorded::<Small>("differs", Config { lanes: 1, ..CONFIG });
    let (status, said, err) = run(&["replay", &log]);
    assert_eq!(status, 1, "{said}{err}");
    assert!(["differs", "recorded:", "replayed:"].iter().all(|word| said.contains(word)), "{said}");
    let (status, report) = report(&log);
    assert_eq!((status, report["equal"].as_bool()), (1, Some(false)));
    let difference = &report["difference"];
    assert!(difference["recorded"].as_str().unwrap().contains(": task-1/0/node-0"), "{difference}");
    let before = difference["before"].as_array().expect("what came before");
    assert!(before.iter().any(|line| line.as_str().unwrap().contains(": task-0/0/node-0")), "{difference}");
}

#[test]
fn what_if_needs_a_workload_and_says_so() {
    let log = recorded::<Small>("what-if", CONFIG);
    let words = ["set up by calls", "redrt sim", "redrt run --record"];
    refused(run(&["replay", &log, "--what-if", "lanes=1"]), 2, &words);
    let (status, out, _) = run(&["replay", &log, "--what-if", "lanes=1", "--json"]);
    let report: Value = serde_json::from_str(&out).expect("JSON all the same");
    assert_eq!((status, &report["refused"]["reason"]), (2, &"no-workload".into()));
}

#[test]
fn logs_by_calls_that_cannot_be_replayed_are_refused() {
    let strange = recorded::<Caps<3, 8, 8, 3>>("strange", CONFIG);
    let words = ["replay-calls-strange.redlog", "[3, 8, 8, 3, 1]", "[4, 16, 16, 4, 2]"];
    refused(run(&["replay", &strange]), 2, &words);
    let log = recorded::<Small>("cut", CONFIG);
    let bytes = fs::read(&log).unwrap();
    fs::write(&log, &bytes[..bytes.len() - 1]).unwrap();
    refused(run(&["replay", &log]), 2, &["replay-calls-cut.redlog", "truncated"]);
    // A setting that this version does not know is none that it passes over.
    let at = bytes.windows(9).position(|word| word == b"\"preempt\"").expect("in the header");
    let mut other = bytes;
    other[at + 1] = b'q';
    let length = u32::from_le_bytes(other[8..12].try_into().unwrap()) as usize;
    let crc = crc32(&other[16..16 + length]).to_le_bytes();
    other[12..16].copy_from_slice(&crc);
    fs::write(&log, other).unwrap();
    refused(run(&["replay", &log]), 2, &["replay-calls-cut.redlog", "the header"]);
}

/// The checksum of a header, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}
