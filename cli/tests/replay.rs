//! `redrt run --record` and `redrt replay`, as a user meets them.

#[path = "process/alone.rs"]
mod alone;
mod process;
#[path = "process/refused.rs"]
mod refused;

use alone::alone;
use process::{file, run};
use refused::refused;
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

/// A stage with an encoder, and a node that comes and goes.
const FILE: &str = r#"
pool = [{ name = "cpu", lanes = 2 }]
[[task]]
name = "t"
deadline = "60ms"
period = "20ms"
[[task.node]]
name = "camera"
wcet = "3ms"
body = { spin = "500us" }
[[task.node]]
name = "see"
after = ["camera"]
mimonet = { weights = "w", frame = "f", encoder = { wcet = "5ms", body = { spin = "2ms" } }, decoders = [
  { name = "one", wcet = "4ms", body = { spin = "1ms" } }, { name = "two", wcet = "4ms", body = { spin = "1ms" } } ] }
[[event]]
at = "200ms"
task = "t"
add = [ { name = "extra", wcet = "5ms", after = ["camera"], body = { spin = "1ms" } } ]
[[event]]
at = "400ms"
task = "t"
remove = ["extra"]
"#;

/// Records a run; where the log is.
fn recorded(name: &str) -> String {
    let _alone = alone();
    let workload = file(&format!("replay-{name}.toml"), FILE.as_bytes());
    let log = file(&format!("replay-{name}.redlog"), b"");
    let log = log.to_str().expect("the path is text").to_owned();
    let workload = workload.to_str().expect("the path is text");
    let options = ["--duration", "600ms", "--best-effort", "--json", "--record", &log];
    let (status, out, err) = run(&[&["run", workload], &options[..]].concat());
    assert_eq!(status, 0, "{err}");
    let summary: Value = serde_json::from_str(&out).unwrap();
    assert!(summary["record"]["inputs"].as_u64().unwrap() > 200, "{summary}");
    assert_eq!(summary["record"]["dropped"], 0);
    assert!(err.contains("log: ") && err.contains("redrt replay"), "{err}");
    log
}

fn report(log: &str) -> (i32, Value) {
    let (status, out, err) = run(&["replay", log, "--json"]);
    (status, serde_json::from_str(&out).unwrap_or_else(|e| panic!("{e}: {out}{err}")))
}

#[test]
fn a_recorded_run_is_replayed_without_a_difference() {
    let log = recorded("equal");
    let (status, out, err) = run(&["replay", &log]);
    assert_eq!(status, 0, "{out}{err}");
    assert!(out.contains("no difference"), "{out}");
    let (status, report) = report(&log);
    assert_eq!((status, report["equal"].as_bool(), &report["difference"]), (0, Some(true), &Value::Null));
    assert!(report["actions"].as_u64().unwrap() > 100, "{report}");
}

/// The header says what is set up; a workload in which a node waits for nobody makes another schedule.
#[test]
fn the_first_difference_is_shown_with_what_came_before_it() {
    let log = recorded("differs");
    let bytes = fs::read(&log).unwrap();
    let length = u32::from_le_bytes(bytes[8..12].try_into().unwrap()) as usize;
    let mut header: Value = serde_json::from_slice(&bytes[16..16 + length]).unwrap();
    let planted = header["workload"]
        .as_str()
        .unwrap()
        .replace("name = \"see\"\nafter = [\"camera\"]", "name = \"see\"");
    assert_ne!(header["workload"], *planted, "the plant took");
    header["workload"] = planted.into();
    let text = serde_json::to_vec(&header).unwrap();
    let mut other = bytes[..8].to_vec();
    other.extend((text.len() as u32).to_le_bytes());
    other.extend(crc32(&text).to_le_bytes());
    other.extend(text);
    other.extend(&bytes[16 + length..]);
    fs::write(&log, other).unwrap();
    let (status, said, _) = run(&["replay", &log]);
    assert_eq!(status, 1, "{said}");
    assert!(["differs", "recorded:", "replayed:"].iter().all(|word| said.contains(word)), "{said}");
    let (status, report) = report(&log);
    assert_eq!((status, report["equal"].as_bool()), (1, Some(false)));
    assert_ne!(report["difference"]["recorded"], report["difference"]["replayed"]);
}

/// The checksum of a header, bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg()))
    })
}

#[test]
fn logs_that_are_not_whole_are_refused() {
    let log = recorded("refused");
    let bytes = fs::read(&log).unwrap();
    let refuse = |bytes: &[u8], why: &str| {
        fs::write(&log, bytes).unwrap();
        refused(run(&["replay", &log]), 2, &["replay-refused.redlog", why]);
    };
    refuse(&bytes[..bytes.len() - 7], "truncated");
    refuse(&[&bytes[..bytes.len() - 1], &[bytes[bytes.len() - 1] ^ 1]].concat(), "damaged");
    refuse(&[&bytes[..6], &[2, 0], &bytes[8..]].concat(), "update the program");
    refuse(&[&bytes[..6], &[0, 0], &bytes[8..]].concat(), "the version that recorded it");
    refuse(b"", "no replay log");
    refuse(FILE.as_bytes(), "no replay log");
    refused(run(&["replay", "/nowhere/at.all"]), 2, &["cannot read it"]);
    refused(run(&["replay", "."]), 2, &["cannot read it"]);
}

#[test]
fn a_place_that_takes_no_log_is_refused_before_the_run() {
    let workload = file("replay-place.toml", FILE.as_bytes());
    let workload = workload.to_str().expect("the path is text");
    let record = |path: &str| run(&["run", workload, "--best-effort", "--record", path]);
    refused(record("/nowhere/at.all"), 2, &["cannot write the log"]);
    refused(record("/dev/full"), 2, &["cannot write the log", "a device"]);
    refused(record(workload), 2, &["--record", "is the workload file itself"]);
    // A FIFO would wait for its reader, and two names of a new file would be two outputs in one.
    let fifo = Path::new(workload).with_extension("fifo");
    let _not_there = fs::remove_file(&fifo);
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("coreutils").success());
    refused(record(fifo.to_str().expect("the path is text")), 2, &["cannot write the log", "a FIFO"]);
    let folder = fifo.parent().expect("a folder").to_str().expect("the path is text");
    let (one, other) = (format!("{folder}/replay-new.out"), format!("{folder}/./replay-new.out"));
    let _not_there = fs::remove_file(&one);
    let both = ["run", workload, "--best-effort", "--trace", &one, "--record", &other];
    refused(run(&both), 2, &["are one file"]);
    assert_eq!(fs::read_to_string(workload).unwrap(), FILE);
}

#[test]
fn a_log_beyond_the_limit_of_file_sizes_is_told_and_ends_no_run() {
    let whole = fs::metadata(recorded("limit")).expect("it is there").len();
    let workload = file("replay-limit.toml", FILE.as_bytes());
    let log = file("replay-limit.redlog", b"");
    let _alone = alone();
    let mut limited = Command::new("prlimit");
    limited.arg(format!("--fsize={}", whole / 2)).arg(env!("CARGO_BIN_EXE_redrt")).arg("run").arg(&workload);
    limited.args(["--duration", "600ms", "--best-effort", "--record"]).arg(&log);
    let output = limited.output().expect("util-linux has it");
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("cannot be replayed"), "{told}");
}

#[test]
fn what_if_answers_in_virtual_time_with_what_was_recorded() {
    let log = recorded("what-if");
    let what_if = |changes: &str| {
        let (status, out, err) = run(&["replay", &log, "--json", "--what-if", changes]);
        assert_eq!(status, 0, "{err}");
        serde_json::from_str::<Value>(&out).unwrap()
    };
    let same = what_if("policy=redrt");
    for task in [&same["recorded"]["tasks"][0], &same["what_if"]["tasks"][0]] {
        assert_eq!((task["released"].as_u64(), task["name"].as_str()), (Some(30), Some("t")), "{task}");
    }
    let other = what_if("policy=edf,deadline.t=2ms,lanes=1");
    assert_eq!((&other["recorded"]["policy"], &other["what_if"]["policy"]), (&"redrt".into(), &"edf".into()));
    assert_eq!(other["what_if"]["pools"][0]["lanes"], 1);
    assert_eq!(other["what_if"]["tasks"][0]["on_time"], 0, "{other}");
    let (status, out, _) = run(&["replay", &log, "--what-if", "lanes.cpu=4"]);
    assert!(status == 0 && out.contains("recorded") && out.contains("what if"), "{out}");
    for (wrong, why) in [
        ("deadline.x=2ms", "there is no task `x`; the log has t"),
        ("lanes.x=2", "there is no pool `x`; the log has cpu"),
        ("lanes=0", "expected 1 to 32 lanes"),
        ("lanes=32,lanes.cpu=33", "expected 1 to 32 lanes"),
        ("policy=best", "expected one of edf"),
        ("deadline=0s", "expected more than 0"),
        ("depth=1", "expected policy=POLICY"),
        ("policy", "expected policy=POLICY"),
    ] {
        refused(run(&["replay", &log, "--what-if", wrong]), 2, &[why]);
    }
}
