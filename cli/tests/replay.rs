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
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

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

/// Records a run; where the log is. One through which the machine stood still has next to nothing to replay: again then.
fn recorded(name: &str) -> String {
    const TRIES: usize = 10;
    let _alone = alone();
    let workload = file(&format!("replay-{name}.toml"), FILE.as_bytes());
    let log = file(&format!("replay-{name}.redlog"), b"");
    let log = log.to_str().expect("the path is text").to_owned();
    let workload = workload.to_str().expect("the path is text");
    let options = ["--duration", "600ms", "--best-effort", "--json", "--force", "--record", &log];
    for _ in 0..TRIES {
        let (status, out, err) = run(&[&["run", workload], &options[..]].concat());
        assert_eq!(status, 0, "{err}");
        let summary: Value = serde_json::from_str(&out).unwrap();
        assert_eq!((&summary["record"]["dropped"], &summary["record"]["failed"]), (&0.into(), &Value::Null));
        assert!(err.contains("log: ") && err.contains("redrt replay"), "{err}");
        if summary["record"]["inputs"].as_u64().unwrap() > 200 {
            return log;
        }
    }
    panic!("of {TRIES} runs none has 200 inputs");
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
    assert_eq!((&report["refused"], &report["policy"]), (&Value::Null, &"redrt".into()));
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
        let said = refused(run(&["replay", &log]), 2, &["replay-refused.redlog", why]);
        refused(run(&["replay", &log, "--what-if", "lanes=1"]), 2, &["replay-refused.redlog", why]);
        said
    };
    let said = refuse(&bytes[..bytes.len() - 7], "truncated");
    assert!(!said.contains("inputs before that"), "the only block is not whole: {said}");
    // A name that is not there is told before the log is fed.
    refused(run(&["replay", &log, "--what-if", "deadline.x=2ms"]), 2, &["there is no task `x`"]);
    refuse(&[&bytes[..bytes.len() - 1], &[bytes[bytes.len() - 1] ^ 1]].concat(), "damaged");
    refuse(&[&bytes[..6], &[6, 0], &bytes[8..]].concat(), "update the program");
    refuse(&[&bytes[..6], &[4, 0], &bytes[8..]].concat(), "the version that recorded it");
    refuse(b"", "no replay log");
    refuse(FILE.as_bytes(), "no replay log");
    refused(run(&["replay", "/nowhere/at.all"]), 2, &["there is no such file", "check the path"]);
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
    limited.args(["--duration", "600ms", "--best-effort", "--json", "--force", "--record"]).arg(&log);
    let output = limited.output().expect("util-linux has it");
    let told = String::from_utf8_lossy(&output.stderr);
    // A log was asked for, and this machine did not take it; the figures are there.
    assert_eq!(output.status.code(), Some(3), "{told}");
    assert!(told.contains("cannot be replayed") && told.contains("is not whole"), "{told}");
    let summary: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    assert!(summary["record"]["failed"].as_str().expect("why").contains("size"), "{summary}");
    let log = log.to_str().expect("the path is text");
    refused(run(&["replay", log]), 2, &["cannot be replayed to the end", "record a shorter run"]);
}

#[test]
fn why_a_log_cannot_be_replayed_is_in_the_json() {
    let log = recorded("why");
    let bytes = fs::read(&log).unwrap();
    let older = [&bytes[..6], &[1, 0], &bytes[8..]].concat();
    for (bytes, reason, policy) in [
        (&bytes[..bytes.len() - 1], "truncated", Some("redrt")),
        (&older, "older", None),
        (b"", "not-a-log", None),
    ] {
        fs::write(&log, bytes).unwrap();
        let (status, report) = report(&log);
        assert_eq!((status, &report["equal"]), (2, &Value::Null), "{report}");
        assert_eq!((report["refused"]["reason"].as_str(), report["policy"].as_str()), (Some(reason), policy));
        assert!(report["refused"]["message"].as_str().unwrap().contains("replay-why.redlog"), "{report}");
    }
}

/// A task whose job is still there when the run is stopped, and one of many jobs.
const LONG: &str = r#"
pool = [{ name = "cpu", lanes = 2 }]
[[task]]
name = "long"
deadline = "60s"
once = true
node = [{ name = "n", wcet = "5s", body = { spin = "4s" } }]
[[task]]
name = "short"
deadline = "20ms"
period = "20ms"
node = [{ name = "n", wcet = "2ms", body = { spin = "100us" } }]
"#;

/// Between two looks at the length of a log.
const LOOK: Duration = Duration::from_millis(20);
/// A run that has written nothing by then never will.
const HANGS: Duration = Duration::from_secs(300);

/// Records a run of ten minutes until the log has grown in the file, and then ends it with this signal.
fn ended_by(signal: &str) -> (String, Option<i32>, String) {
    let workload = file(&format!("replay-{signal}.toml"), LONG.as_bytes());
    let log = file(&format!("replay-{signal}.redlog"), b"");
    let told = File::create(log.with_extension("err")).expect("a file of our own");
    let mut command = process::command(&["run", workload.to_str().expect("the path is text")]);
    command.args(["--duration", "600s", "--best-effort", "--json", "--force", "--record"]).arg(&log);
    let child = command.stdout(Stdio::piped()).stderr(told).spawn().expect("it starts");
    wait_for_a_block(&log);
    let kill = format!("kill -{signal} {}", child.id());
    assert!(Command::new("sh").args(["-c", &kill]).status().expect("there is a shell").success());
    let output = child.wait_with_output().expect("it ends");
    let log = log.to_str().expect("the path is text").to_owned();
    (log, output.status.code(), String::from_utf8(output.stdout).expect("UTF-8"))
}

/// Waits until there is more in a log than its beginning: 16 bytes, the header whose length they tell, and the totals.
fn wait_for_a_block(log: &Path) {
    let begun = Instant::now();
    loop {
        let bytes = fs::read(log).expect("it was made");
        let header =
            bytes.get(8..12).map(|length| u32::from_le_bytes(length.try_into().expect("four bytes")));
        if header.is_some_and(|header| bytes.len() > 16 + header as usize + 24) {
            return;
        }
        assert!(begun.elapsed() < HANGS, "no block of {} came", log.display());
        thread::sleep(LOOK);
    }
}

#[test]
fn what_if_judges_the_jobs_of_a_run_that_was_stopped_until_then() {
    let _alone = alone();
    let (log, status, summary) = ended_by("INT");
    assert_eq!(status, Some(0));
    let summary: Value = serde_json::from_str(&summary).expect("one JSON object");
    assert_eq!(summary["stopped_by"], "SIGINT");
    let (status, out, err) = run(&["replay", &log, "--json", "--what-if", "policy=redrt"]);
    assert_eq!(status, 0, "{err}");
    let answer: Value = serde_json::from_str(&out).unwrap();
    for key in ["tasks", "horizon_ns"] {
        assert_eq!(answer["recorded"][key], summary[key], "{key}");
    }
    // The first job could still have been in time.
    for run in ["recorded", "what_if"] {
        let long = &answer[run]["tasks"][0];
        assert_eq!(
            (&long["released"], &long["completed"], &long["missed"]),
            (&1.into(), &0.into(), &0.into())
        );
    }
    assert_eq!(answer["what_if"]["horizon_ns"], summary["horizon_ns"]);
}

#[test]
fn the_log_of_a_killed_run_is_replayed_up_to_its_last_block() {
    let _alone = alone();
    let (log, status, _) = ended_by("KILL");
    assert_eq!(status, None);
    refused(
        run(&["replay", &log]),
        2,
        &["it was not closed", "inputs before that were fed", "no difference"],
    );
    let (status, report) = report(&log);
    assert_eq!((status, &report["refused"]["reason"]), (2, &"not-closed".into()));
    assert!(report["inputs"].as_u64() > Some(0), "{report}");
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
    assert_eq!(other["at_wcet"], serde_json::json!([]), "every node has run");
    assert_eq!(what_if(" policy = edf , deadline . t = 2ms,lanes= 1"), other);
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
        ("lanes=2,policy=edf,lanes=3", "lanes is given twice; give it once"),
    ] {
        refused(run(&["replay", &log, "--what-if", wrong]), 2, &[why]);
    }
}

/// A disk on which it takes two seconds until everything is there.
const SLOW_DISK: &[u8] =
    b"#include <unistd.h>\nint fdatasync(int file) { (void)file; return (int)sleep(2); }\n";

/// A disk that does not keep what it took.
const BAD_DISK: &[u8] =
    b"#include <errno.h>\nint fdatasync(int file) { (void)file; errno = EIO; return -1; }\n";

/// This disk, for `LD_PRELOAD`.
fn disk(name: &str, source: &[u8]) -> PathBuf {
    let source = file(&format!("replay-{name}.c"), source);
    let disk = source.with_extension("so");
    let compiled = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&disk, &source]).status();
    assert!(compiled.expect("no C compiler; install it with: apt-get install gcc libc6-dev").success());
    disk
}

#[test]
fn a_log_that_the_disk_did_not_keep_is_not_whole() {
    let (disk, log) = (disk("bad", BAD_DISK), file("replay-bad.redlog", b""));
    let workload = file("replay-bad.toml", FILE.as_bytes());
    let (log, workload) = [&log, &workload].map(|path| path.to_str().expect("the path is text")).into();
    let _alone = alone();
    let mut command = process::command(&["run", workload, "--duration", "100ms", "--best-effort"]);
    let output =
        command.args(["--force", "--record", log]).env("LD_PRELOAD", disk).output().expect("it starts");
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    refused(run(&["replay", log]), 2, &["cannot be replayed to the end", "the file could not be written"]);
}

#[test]
fn a_log_that_keeps_its_run_waiting_says_so_where_somebody_looks() {
    let (disk, log) = (disk("slow", SLOW_DISK), file("replay-slow.redlog", b""));
    let workload = file("replay-slow.toml", FILE.as_bytes());
    let path = |path: &Path| path.to_str().expect("the path is text").to_owned();
    let run = format!(
        "LD_PRELOAD={} {} run {} --duration 100ms --best-effort --force --record {}",
        path(&disk),
        env!("CARGO_BIN_EXE_redrt"),
        path(&workload),
        path(&log)
    );
    let _alone = alone();
    let terminal = Command::new("script").args(["-qec", &run, "/dev/null"]).env("TERM", "xterm").output();
    let terminal = terminal.expect("no script; install it with: apt-get install bsdutils");
    let shown = String::from_utf8_lossy(&terminal.stdout);
    assert!(terminal.status.success() && shown.contains("writing the log: 1 s"), "{shown}");
}
