//! Rows 61 to 68: what a GPU and its driver do, by a stand-in for the driver.

use crate::process::{command, ended, file};
use crate::redrt::count;
use red_cuda::{Called, Device, Driver, Kind};
use red_cuda_stand_in::{LACKING, StandIn, with};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicI32, Ordering};

const PTX: &[u8] =
    b".version 6.0\n.target sm_53\n.visible .entry first() { ret; }\n.visible .entry second() { ret; }\n";
/// Of two lanes, which run every kernel once in the warm-up.
const WARM_UPS: u64 = 2;

/// Two streams: a task of two kernels, one after the other, in a budget that one leak exceeds; and a task of the CPU.
fn workload(row: &str, more: &str) -> String {
    file(&format!("{row}.ptx"), PTX);
    let kernel = |name: &str| {
        format!("body = {{ cuda = {{ module = '{row}.ptx', kernel = '{name}', grid = [1], block = [1] }} }}")
    };
    let text = format!(
        "pool = [{{ name = 'gpu', kind = 'cuda', lanes = 2, memory = '8MiB' }}, {{ name = 'cpu', lanes = 1 }}]\n\
         [[task]]\nname = 'sees'\nperiod = '20ms'\ndeadline = '2s'\n\
         node = [{{ name = 'first', wcet = '2ms', memory = '3MiB', {} }},\n\
         {{ name = 'second', wcet = '2ms', memory = '3MiB', after = ['first'], {} }}]\n\
         [[task]]\nname = 'steers'\nperiod = '20ms'\ndeadline = '2s'\n\
         node = [{{ name = 'a', pool = 'cpu', wcet = '1ms', body = {{ spin = '10us' }} }}]\n{more}",
        kernel("first"),
        kernel("second"),
    );
    file(&format!("{row}.toml"), text.as_bytes()).display().to_string()
}

fn run(stand_in: &StandIn, path: &str) -> (i32, Value, String) {
    run_with(stand_in, &["run", path])
}

fn run_with(stand_in: &StandIn, arguments: &[&str]) -> (i32, Value, String) {
    let mut run = command(&[arguments, &["--best-effort", "--json", "--duration", "600ms"]].concat());
    let (status, out, told) = ended(&stand_in.give(&mut run).output().expect("the command starts"));
    (status, serde_json::from_str(&out).unwrap_or(Value::Null), told)
}

/// Released, on time and given up, of both tasks.
fn jobs(summary: &Value) -> [[u64; 3]; 2] {
    [0, 1].map(|task| ["released", "on_time", "shed"].map(|key| count(&summary["tasks"][task], key)))
}

#[test]
fn row_61_without_a_driver_a_device_or_a_new_enough_version_it_is_told_and_the_cpu_works() {
    let path = workload("row-61", "");
    let lacking = StandIn::new("").driver(Path::new(LACKING));
    let drivers = [
        (lacking, "lacks cuStreamWaitEvent"),
        (StandIn::new("devices 0"), "nvidia-smi"),
        (StandIn::new("version 10010"), "CUDA 10.1"),
        (StandIn::new("").driver(Path::new("/nowhere")), "CUDA driver"),
    ];
    for (driver, words) in drivers {
        // With a driver of its own the machine has one also where the last of them has not.
        if words == "CUDA driver" && Driver::load().is_ok() {
            continue;
        }
        let (status, summary, told) = run(&driver, &path);
        assert_eq!((status, summary), (3, Value::Null), "{told}");
        for words in [words, "pool `gpu` is of kind cuda", "write kind = \"cpu\""] {
            assert!(told.contains(words), "no `{words}` in: {told}");
        }
        for other in [["sim", &path, "--json"], ["run", "examples/cruise.toml", "--duration=100ms"]] {
            let more: &[&str] = if other[0] == "run" { &["--best-effort"] } else { &[] };
            let mut other = command(&[&other[..], more].concat());
            let (status, _, told) = ended(&driver.give(&mut other).output().expect("the command starts"));
            assert_eq!(status, 0, "{told}");
        }
    }
}

#[test]
fn row_62_out_of_memory_fails_one_job_and_gives_its_memory_back() {
    let path = workload("row-62", "");
    // In the run every third kernel for a while.
    let refusals: String =
        (0..4).map(|n| format!("refuse cuLaunchKernel {} 2\n", 2 * WARM_UPS + 3 + 3 * n)).collect();
    let (status, summary, told) = run(&StandIn::new(&refusals), &path);
    assert_eq!(status, 0, "{told}");
    let [[released, on_time, shed], steers] = jobs(&summary);
    assert_eq!((on_time, shed), (released - 4, 4), "{summary}");
    assert_eq!((steers, count(&summary, "failed")), ([30, 30, 0], 4));
    assert!(told.contains("CUDA_ERROR_OUT_OF_MEMORY") && told.contains("`sees."), "{told}");
    // Where there is less than the pool may use, or too little for the buffers, nothing starts.
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let scene = std::fs::read_to_string(examples.join("obstacle-cuda.toml")).expect("the example");
    let kernels = examples.join("kernels/road.ptx");
    std::fs::create_dir_all(Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels"))
        .expect("a folder for tests");
    file("kernels/road.ptx", &std::fs::read(kernels).expect("its kernels"));
    let without = scene.replace("memory = \"64MiB\"\n", "");
    let starts = [
        (scene.as_str(), "300000", "may use 67108864 bytes of the device's memory, of which 300000 are free"),
        (&without, "300000", "too little memory left"),
    ];
    for (text, memory, words) in starts {
        let path = file("row-62-scene.toml", text.as_bytes());
        let (status, summary, told) =
            run(&StandIn::new(&format!("memory {memory}")), path.to_str().expect("UTF-8"));
        assert_eq!((status, summary), (3, Value::Null));
        assert!(told.contains(words), "no `{words}` in: {told}");
    }
    let small = scene.replacen("memory = \"1MiB\"", "memory = \"1KiB\"", 1);
    let path = file("row-62-scene.toml", small.as_bytes());
    let (status, _, told) = run(&StandIn::new(""), path.to_str().expect("UTF-8"));
    assert!(status == 2 && told.contains("expected memory = \"368640B\" or more"), "{status}: {told}");
}

/// What a run is whose device answers with this error after a while.
fn loses(row: &str, code: i32, words: &[&str]) {
    let stand_in = StandIn::new(&format!("fault second {} {code}", WARM_UPS + 6));
    let path = workload(row, "");
    // What is given up must not depend on a policy that sheds.
    let (status, summary, told) = run_with(&stand_in, &["run", &path, "--policy", "edf"]);
    assert_eq!(status, 3, "{told}");
    for words in words.iter().chain(&["the device was lost", "start"]) {
        assert!(told.contains(words), "no `{words}` in: {told}");
    }
    assert!(told.contains("jobs that needed what was lost were given up"), "{told}");
    assert!(!told.contains("mend the body") && !told.contains("no process gets it back"), "{told}");
    let [sees, steers] = jobs(&summary);
    assert_eq!(sees, [30, 5, 25], "its jobs end at once, and later ones as they are released: {summary}");
    assert_eq!(steers, [30, 30, 0], "the CPU goes on");
    assert_eq!((count(&summary, "lanes_lost"), summary["device_lost"].is_string()), (2, true));
    let log = stand_in.log();
    let error = format!(" = {code}");
    let first = log.iter().position(|line| line.ends_with(&error)).unwrap_or(log.len());
    let again = log[first..]
        .iter()
        .find(|line| line.starts_with("call cuLaunchKernel") || line.starts_with("call cuStreamCreate"));
    assert_eq!(again, None, "never again in that context");
}

#[test]
fn row_63_an_illegal_access_ends_the_device_and_the_run_is_to_be_started_again() {
    loses("row-63", 700, &["CUDA_ERROR_ILLEGAL_ADDRESS", "start the process again"]);
    for code in [702, 719] {
        loses("row-63-other", code, &["start the process again"]);
    }
}

/// Where the device was all there is, the run ends with it.
fn ends_with_it() {
    let path = workload("row-64-alone", "");
    let text = std::fs::read_to_string(&path).expect("it was written");
    let alone = text.split("[[task]]\nname = 'steers'").next().expect("the first task");
    let alone = file("row-64-alone.toml", alone.replace(", { name = 'cpu', lanes = 1 }", "").as_bytes());
    let stand_in = StandIn::new(&format!("fault second {} 999", WARM_UPS + 6));
    let mut run = command(&["run", alone.to_str().unwrap(), "--best-effort", "--json", "--duration", "60s"]);
    let (status, out, told) = ended(&stand_in.give(&mut run).output().expect("the command starts"));
    let summary: Value = serde_json::from_str(&out).expect("a summary");
    assert_eq!((status, count(&summary, "lanes_lost")), (3, 2), "{told}");
    assert!(told.contains("the device was lost") && told.contains("RestartSec"), "{told}");
    assert!(count(&summary["tasks"][0], "released") < 1000, "the rest of the minute is not waited for");
}

#[test]
fn row_64_a_device_that_is_gone_is_to_be_waited_for_and_given_up_after_a_few_starts() {
    for code in [46, 999] {
        loses("row-64", code, &["wait a while", "RestartSec", "StartLimitBurst"]);
    }
    ends_with_it();
}

/// What needs a pool of which no stream is left is given up, and the run is to be started again.
fn all_streams_hang() {
    let path = workload("row-65-all", "");
    let text = std::fs::read_to_string(&path).expect("it was written");
    let one = file("row-65-one.toml", text.replace("lanes = 2", "lanes = 1").as_bytes());
    assert_ne!(std::fs::read_to_string(&one).expect("it was written"), text);
    let stand_in = StandIn::new(&format!("hang second {}", WARM_UPS / 2 + 6));
    let (status, summary, told) = run(&stand_in, one.to_str().expect("UTF-8"));
    let [[released, on_time, shed], steers] = jobs(&summary);
    assert_eq!((status, steers, released, on_time + shed), (3, [30, 30, 0], 30, 30), "{summary}: {told}");
    assert!(on_time < 10, "{summary}");
    assert_eq!((&summary["pools_lost"][0], &summary["device_lost"]), (&"gpu".into(), &Value::Null), "{told}");
    assert!(
        told.contains("no stream of pool `gpu` is left") && told.contains("start the process again"),
        "{told}"
    );
}

#[test]
fn row_65_a_stream_that_hangs_is_left_at_a_bound_and_the_other_goes_on() {
    let stand_in = StandIn::new(&format!("hang second {}", WARM_UPS + 6));
    let (status, summary, told) = run(&stand_in, &workload("row-65", ""));
    assert_eq!(status, 0, "{told}");
    let [[released, on_time, shed], steers] = jobs(&summary);
    assert_eq!((on_time, shed, steers), (released - 1, 1, [30, 30, 0]), "{summary}");
    assert_eq!((count(&summary, "lanes_lost"), &summary["device_lost"]), (1, &Value::Null));
    for words in ["node `sees.second` did not come to its end on its stream", "is left; mend the kernel"] {
        assert!(told.contains(words), "no `{words}` in: {told}");
    }
    assert!(!told.contains("ulimit") && !told.contains("mend the body"), "{told}");
    all_streams_hang();
    // On the stream that hangs nothing was submitted after that.
    let log = stand_in.log();
    let of = |line: &str| line.split(' ').nth(1).unwrap_or_default().to_owned();
    let (begins, ends): (Vec<&String>, Vec<&String>) = log
        .iter()
        .filter(|line| line.ends_with(" second") && !line.starts_with("call"))
        .partition(|line| line.starts_with("begin"));
    let hangs = begins.iter().map(|line| of(line)).find(|stream| {
        let count = |lines: &[&String]| lines.iter().filter(|line| of(line) == *stream).count();
        count(&begins) > count(&ends)
    });
    let hangs = hangs.expect("one did not end");
    let begin = log.iter().rposition(|line| *line == format!("begin {hangs} second")).expect("it began");
    let given = log[begin..].iter().find(|line| line.starts_with(&format!("call cuLaunchKernel {hangs} ")));
    assert_eq!(given, None);
}

/// A callback that does what none may.
struct Calls(Device, AtomicI32);

impl Called for Calls {
    fn called(&self) {
        let _entered = self.0.enter();
        self.1.store(self.0.memory().map_or_else(|error| error.code(), |_| 0), Ordering::Relaxed);
    }
}

#[test]
fn row_66_callbacks_only_ring_and_one_that_calls_cuda_is_seen() {
    let stand_in = StandIn::new("takes * 500");
    let (status, summary, told) = run(&stand_in, &workload("row-66", ""));
    assert_eq!(status, 0, "{told}");
    let log = stand_in.log();
    let is_called = log.iter().any(|line| line.starts_with("call cuLaunchHostFunc"));
    assert_eq!(summary["realtime"] == false, is_called, "lanes that share CPUs sleep meanwhile");
    assert!(!log.iter().any(|line| line.starts_with("forbidden")), "a callback called CUDA");
    let planted = with("", || {
        let device = Device::open(Driver::load().expect("the stand-in"), 0).expect("one device");
        let stream = device.stream(0).expect("a stream");
        let calls = Arc::new(Calls(device.clone(), AtomicI32::new(0)));
        stream.call(calls.clone()).expect("sound");
        device.synchronize().expect("sound");
        assert_ne!(calls.1.load(Ordering::Relaxed), 0);
        assert_ne!(device.memory().map_err(|error| error.kind()), Err(Kind::Poisoned));
    });
    assert!(planted.is_none_or(|log| log.iter().any(|line| line.starts_with("forbidden cuMemGetInfo"))));
}

#[test]
fn row_67_everything_is_used_once_before_the_start_and_what_comes_late_is_counted() {
    let stand_in = StandIn::new("");
    let (status, summary, told) = run(&stand_in, &workload("row-67", ""));
    assert_eq!(
        (status, count(&summary, "late_allocations"), count(&summary, "late_memory_bytes")),
        (0, 0, 0),
        "{told}"
    );
    let log = stand_in.log();
    // A stream that warms up is marked once.
    let marked = |line: &str| {
        line.strip_prefix("call cuEventRecord ").map(|rest| rest.split(' ').next().map(str::to_owned))
    };
    let of_lane = |line: &String| {
        marked(line).is_some_and(|stream| {
            log.iter().filter(|other| marked(other) == Some(stream.clone())).count() > 1
        })
    };
    let first = log.iter().position(of_lane).expect("a mark");
    let warm = |kernel: &str| {
        log[..first].iter().filter(|line| line.starts_with("end") && line.ends_with(kernel)).count() as u64
    };
    assert!(warm("first") >= WARM_UPS && warm("second") >= WARM_UPS, "{log:#?}");
    let makes = ["cuMemAlloc", "cuMemHostAlloc", "cuModuleLoad", "cuStreamCreate", "cuEventCreate"];
    let late = log[first..].iter().find(|line| makes.iter().any(|call| line.contains(call)));
    assert_eq!(late, None);
    // A body of somebody else's that allocates while it runs.
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let object = Path::new(env!("CARGO_TARGET_TMPDIR")).join("row-67.so");
    let mut cc = Command::new("cc");
    cc.args(["-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-I"]).arg(package.join("../bodies/include"));
    let built = cc.arg("-o").arg(&object).arg(package.join("tests/fault_table/gpu.c")).status();
    assert!(built.expect("no C compiler; install it with: apt-get install gcc libc6-dev").success());
    let once = "[[task]]\nname = 'late'\nonce = true\ndeadline = '2s'\n\
                node = [{ name = 'a', wcet = '2ms', body = { plugin = 'row-67.so', symbol = 'allocates' } }]\n";
    let (status, summary, told) = run(&StandIn::new(""), &workload("row-67", once));
    assert_eq!((status, count(&summary, "late_memory_bytes")), (0, 4096), "{told}");
    assert!(told.contains("4096 bytes less"), "{told}");
}

#[test]
fn row_68_a_node_that_takes_longer_and_longer_is_told_with_the_advice_to_measure_it_again() {
    let path = workload("row-68", "");
    let drifts = |script: &str| {
        let mut run = command(&["run", &path, "--best-effort", "--json", "--duration", "1500ms"]);
        let (status, out, told) = ended(&StandIn::new(script).give(&mut run).output().expect("it starts"));
        assert_eq!(status, 0, "{told}");
        let summary: Value = serde_json::from_str(&out).expect("a summary");
        (summary["cost_drift"].as_array().expect("a list").clone(), told)
    };
    let takes = "takes first 4000\ntakes second 4000\n";
    let (drifted, told) = drifts(&format!("{takes}slows second {} 9000\n", WARM_UPS + 20));
    let named = |drift: &Value| drift["task"] == "sees" && drift["node"] == "second";
    let drift = drifted.iter().find(|drift| named(drift)).unwrap_or_else(|| panic!("{drifted:?}: {told}"));
    assert!(count(drift, "after_ns") > count(drift, "before_ns") * 3 / 2, "{drift}");
    for words in ["cost drift", "`sees.second`", "nvidia-smi", "redrt profile"] {
        assert!(told.contains(words), "no `{words}` in: {told}");
    }
    // A gate that always speaks says nothing. Twice, for the host may be throttled itself.
    let is_steady = || drifts(takes).0.iter().all(|drift| !named(drift));
    assert!(is_steady() || is_steady(), "nothing became slower");
}
