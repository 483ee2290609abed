//! Pools of kind `cuda` with a stand-in for the driver, and without any.

mod log;
#[path = "../process/mod.rs"]
mod process;

use log::Edges;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use process::{command, ended, file};
use red_core::Ppm;
use red_cuda_stand_in::StandIn;
use red_record::{Call, Reader};
use serde_json::Value;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::Duration;

const SCENE: &str = "examples/obstacle-cuda.toml";
/// As the scene's kernels take on a small board.
const TAKES: &str = "takes encode 3000\ntakes lane 1000\ntakes segment 2000\ntakes detect 2000\n";

fn run(stand_in: &StandIn, path: &str, more: &[&str]) -> (i32, String, String) {
    let mut command = command(&[&["run", path, "--best-effort", "--json"], more].concat());
    ended(&stand_in.give(&mut command).output().expect("the command starts"))
}

fn summary((status, out, told): (i32, String, String)) -> Value {
    assert_eq!(status, 0, "{told}");
    serde_json::from_str(&out).unwrap_or_else(|error| panic!("{error}: {out}"))
}

fn count(of: &Value, key: &str) -> u64 {
    of[key].as_u64().unwrap_or_else(|| panic!("{key} of {of}"))
}

/// The scene with so much time for each job that none is given up on a machine that is busy with something else.
fn patient() -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = fs::read_to_string(root.join(SCENE)).expect("the example");
    let kernels = fs::read(root.join("examples/kernels/road.ptx")).expect("its kernels");
    fs::create_dir_all(Path::new(env!("CARGO_TARGET_TMPDIR")).join("kernels")).expect("a folder for tests");
    file("kernels/road.ptx", &kernels);
    let patient = text.replace("deadline = \"60ms\"", "deadline = \"20s\"").replace("\"3s\"", "\"1s\"");
    assert_ne!(patient, text);
    file("patient.toml", patient.replace("\"6s\"", "\"2s\"").as_bytes()).display().to_string()
}

#[test]
fn the_obstacle_scene_runs_on_two_streams_and_waits_only_where_it_must() {
    let edges = Edges::from([("encode", "lane"), ("encode", "segment"), ("segment", "detect")]);
    let stand_in = StandIn::new(TAKES);
    let scene = patient();
    let ran = summary(run(&stand_in, &scene, &["--duration", "3s"]));
    let jobs = count(&ran["tasks"][0], "released");
    assert_eq!((jobs, count(&ran["tasks"][0], "on_time")), (60, 60), "{ran}");
    let log = stand_in.log();
    let runs = log::precedence(&log, &edges);
    // In the warm-up each lane runs everything once.
    assert_eq!((runs["encode"], runs["lane"], runs["segment"], runs["detect"]), (62, 62, 62, 22));
    let waits = log::waits(&log, &edges) as u64;
    assert_eq!(waits, count(&ran, "event_waits_issued"));
    // Of each job a decoder waits on the other stream, and one behind the encoder on its own.
    assert!(waits >= 50 && count(&ran, "event_waits_avoided") >= 50, "{ran}");
    assert!(count(&ran, "submissions_ahead") >= 110, "{ran}");
    assert!(count(&ran, "device_memory_bytes") > 2 * 184_320, "{ran}");
    assert_eq!((count(&ran, "late_allocations"), &ran["device_lost"]), (0, &Value::Null));
    assert!(!log.iter().any(|line| line.starts_with("forbidden")), "a callback called CUDA");
}

#[test]
fn captured_graphs_keep_the_same_order_in_one_launch_each() {
    let edges = Edges::from([("encode", "lane"), ("encode", "segment"), ("segment", "detect")]);
    let text = fs::read_to_string(patient()).expect("it was written");
    let captured = ["encoder", "decoders"].iter().fold(text, |text, part| {
        let body = format!("[task.node.mimonet.{part}.body");
        text.replace(&format!("{body}.cuda]"), &format!("{body}]\ngraph = true\n{body}.cuda]"))
    });
    let path = file("captured.toml", captured.as_bytes());
    for policy in ["redrt", "edf"] {
        let stand_in = StandIn::new(TAKES);
        let more = ["--duration", "900ms", "--policy", policy];
        let ran = summary(run(&stand_in, path.to_str().expect("UTF-8"), &more));
        assert_eq!(count(&ran["tasks"][0], "on_time"), 18, "{ran}");
        let log = stand_in.log();
        let warm = log::warm(&log);
        let runs = log::precedence(&log[warm..], &edges);
        assert_eq!((runs["encode"], runs["lane"], runs["segment"]), (18, 18, 18), "{policy}");
        let calls = |name: &str| log[warm..].iter().filter(|line| line.contains(name)).count();
        assert_eq!(calls("cuGraphLaunch"), 3 * 18);
        assert_eq!(calls("cuGraphInstantiate"), 0, "before the start");
        // The obstacle's detector is none.
        assert_eq!(calls("cuLaunchKernel"), runs.get("detect").copied().unwrap_or_default());
    }
    let spin = captured.replace("body = { spin = \"500us\" }", "body = { spin = \"500us\", graph = true }");
    let on_cpu = captured
        .replace("body = { spin = \"500us\" }", "body = { plugin = \"p.so\", symbol = \"s\", graph = true }");
    for (text, words) in
        [(spin, "a `graph` only beside `plugin` or `cuda`"), (on_cpu, "in a pool of the CPU")]
    {
        let path = file("captured-wrong.toml", text.as_bytes());
        let (status, _, told) = run(&StandIn::new(""), path.to_str().expect("UTF-8"), &[]);
        assert!(status == 2 && told.contains(words), "{status}: {told}");
    }
}

#[test]
fn under_edf_a_stage_is_one_unit_and_nothing_waits() {
    let edges = Edges::from([("encode", "lane"), ("encode", "segment"), ("lane", "segment")]);
    let stand_in = StandIn::new(TAKES);
    let ran = summary(run(&stand_in, &patient(), &["--duration", "900ms", "--policy", "edf"]));
    assert_eq!(count(&ran["tasks"][0], "on_time"), 18, "{ran}");
    let log = stand_in.log();
    assert_eq!(log::precedence(&log, &edges)["segment"], 20);
    assert_eq!((log::waits(&log, &edges), count(&ran, "submissions_ahead")), (0, 0));
}

#[test]
fn the_summary_has_the_keys_of_a_run_on_the_cpu_and_those_of_the_device() {
    let keys = |summary: &Value| -> Vec<String> {
        summary.as_object().expect("an object").keys().cloned().collect()
    };
    let on_device = summary(run(&StandIn::new(TAKES), SCENE, &["--duration", "200ms"]));
    let on_cpu = summary(run(&StandIn::new(""), "examples/cruise.toml", &["--duration", "200ms"]));
    let own = [
        "event_waits_issued",
        "event_waits_avoided",
        "submissions_ahead",
        "device_memory_bytes",
        "late_allocations",
        "late_memory_bytes",
        "utilisation_source",
        "utilisation_max_ppm",
        "device_lost",
        "pools_lost",
    ];
    let (mut all, mut expected) = (keys(&on_device), keys(&on_cpu));
    assert!(!own.iter().any(|key| expected.iter().any(|other| other == key)));
    expected.extend(own.map(str::to_owned));
    all.sort_unstable();
    expected.sort_unstable();
    assert_eq!(all, expected);
}

#[test]
fn what_others_use_of_the_device_is_told_to_the_scheduler() {
    let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join("used.redlog").display().to_string();
    let more = ["--duration", "400ms", "--force", "--record", &log];
    let ran = summary(run(&StandIn::new(&format!("{TAKES}load 97\n")), &patient(), &more));
    assert_eq!(
        (&ran["utilisation_source"], count(&ran, "utilisation_max_ppm")),
        (&"nvml".into(), 970_000),
        "{ran}"
    );
    let (status, out, told) = process::run(&["replay", &log]);
    assert_eq!((status, out.contains("no difference")), (0, true), "{out}{told}");
    let bytes = fs::read(&log).expect("it was recorded");
    let mut reader = Reader::new(&*bytes).expect("a log");
    let mut told = 0;
    while let Some(entry) = reader.next_entry().expect("it is whole") {
        told += u32::from(matches!(entry.call, Call::ObserveUse(_, Ppm(970_000))));
    }
    assert!(told > 0, "the scheduler was told");
    let ran = summary(run(&StandIn::new(TAKES), &patient(), &["--duration", "200ms"]));
    assert_eq!((&ran["utilisation_source"], &ran["utilisation_max_ppm"]), (&"own".into(), &Value::Null));
}

/// NVIDIA's library for the device's use took 17 ms to open, and cost the first jobs of every run their deadlines.
#[test]
fn no_job_waits_for_what_is_opened_at_the_start() {
    let stand_in = StandIn::new(&format!("{TAKES}load 10\ndelay nvmlInit_v2 3000000\n"));
    let ran = summary(run(&stand_in, &patient(), &["--duration", "200ms"]));
    assert_eq!(ran["utilisation_source"], "nvml", "{ran}");
    let longest = count(&ran["tasks"][0]["response_ns"], "max");
    assert!(longest < 2_000_000_000, "the first job waited: {longest} ns");
}

/// The driver's thread is an ordinary one: what it says comes late, and its stack is mapped while the lane waits.
#[test]
fn a_lane_in_real_time_has_the_driver_call_nobody() {
    file("one.ptx", &fs::read("../examples/kernels/road.ptx").expect("the example's"));
    let text = "pool = [{ name = 'gpu', kind = 'cuda', lanes = 1 }]\n\
        task = [{ name = 'sees', deadline = '2s', period = '10ms', node = [{ name = 'look', wcet = '5ms', body = { cuda = \
        { module = 'one.ptx', kernel = 'encode', grid = [1], block = [1], args = [{ input = '4B' }, \
        { output = '4B' }, 1, 1] } } }] }]";
    let path = file("one.toml", text.as_bytes()).display().to_string();
    let stand_in = StandIn::new(TAKES);
    let ran = summary(run(&stand_in, &path, &["--duration", "200ms"]));
    let is_called = stand_in.log().iter().any(|line| line.starts_with("call cuLaunchHostFunc"));
    assert_eq!(ran["realtime"] == false, is_called, "{ran}");
}

#[test]
fn a_run_of_streams_is_replayed_without_a_difference() {
    let log = Path::new(env!("CARGO_TARGET_TMPDIR")).join("streams.redlog").display().to_string();
    let ran =
        summary(run(&StandIn::new(TAKES), &patient(), &["--duration", "500ms", "--force", "--record", &log]));
    assert!(count(&ran, "submissions_ahead") > 0, "{ran}");
    let (status, out, told) = process::run(&["replay", &log]);
    assert_eq!((status, out.contains("no difference")), (0, true), "{out}{told}");
}

#[test]
fn a_profile_of_streams_has_what_events_say_and_writes_it_back() {
    let scene = patient();
    let copy = Path::new(&scene).with_extension("profiled.toml");
    let _none_there = fs::remove_file(&copy);
    let stand_in = StandIn::new(TAKES);
    let mut profile =
        command(&["profile", &scene, "--best-effort", "--json", "--runs", "20", "--budget", "200ms"]);
    let (status, out, told) = ended(&stand_in.give(&mut profile).output().expect("the command starts"));
    assert_eq!(status, 0, "{told}");
    let report: Value = serde_json::from_str(&out).expect("one JSON object");
    let least = [("perception.encoder", 3), ("perception.lane", 1), ("perception.segment", 2), ("detect", 2)];
    for (name, takes_ms) in least {
        let nodes = report["nodes"].as_array().expect("a list");
        let node =
            nodes.iter().find(|node| node["node"] == name).unwrap_or_else(|| panic!("{name}: {report}"));
        let [min, wcet] = ["min_ns", "wcet_ns"].map(|key| count(node, key));
        assert!(min >= takes_ms * 1_000_000 && wcet >= min, "{node}");
        assert!(node["contention_ns"].is_u64(), "{node}");
    }
    // The stand-in's streams sleep beside each other.
    let pools = report["pools"].as_array().expect("a list");
    let [gpu, cpu] = &pools[..] else { panic!("{report}") };
    assert!(gpu["rho"].as_f64().expect("measured") > 1.5 && count(gpu, "lanes") <= 4, "{gpu}");
    assert!(cpu["rho"].is_number());
    let text = fs::read_to_string(&copy).expect("the copy");
    assert!(text.contains("# CUDA device: stand-in 0") && text.contains("Pool gpu: rho = "), "{text}");
    // What was written runs.
    let ran = summary(run(&stand_in, copy.to_str().expect("UTF-8"), &["--duration", "500ms"]));
    assert!(count(&ran["tasks"][0], "on_time") > 0, "{ran}");
    for (script, words) in [("fault lane 9 700", "CUDA_ERROR_ILLEGAL_ADDRESS"), ("devices 0", "nvidia-smi")] {
        let mut profile = command(&["profile", &scene, "--best-effort", "--force", "--runs", "20"]);
        let (status, _, told) = ended(&StandIn::new(script).give(&mut profile).output().expect("it starts"));
        let expected = if words == "nvidia-smi" { 3 } else { 2 };
        assert!(status == expected && told.contains(words), "{status}: {told}");
    }
}

/// A pool of one stream with a stage of these arguments, and a node of its own behind it.
fn stage(encoder: &str, decoder: &str, alone: &str) -> String {
    let cuda = |args: &str| {
        format!("cuda = {{ module = 'stage.ptx', kernel = 'k', grid = [1], block = [32], args = [{args}] }}")
    };
    file("stage.ptx", b".version 6.0\n.visible .entry k() { ret; }\n");
    format!(
        "pool = [{{ name = 'gpu', kind = 'cuda', lanes = 1 }}]
[[task]]
name = 't'
deadline = '50ms'
period = '50ms'
[[task.node]]
name = 's'
mimonet = {{ weights = 'w', frame = 'f', encoder = {{ wcet = '5ms', body = {{ {} }} }}, decoders = [{{ name = 'd', wcet = '5ms', body = {{ {} }} }}] }}
[[task.node]]
name = 'n'
after = ['s']
wcet = '5ms'
body = {{ {} }}
",
        cuda(encoder),
        cuda(decoder),
        cuda(alone)
    )
}

#[test]
fn results_are_of_a_stage_and_of_one_size() {
    let (four, eight) = ("{ result = '4KiB' }", "{ result = '8KiB' }");
    let cases = [
        (four, four, "", 0, ""),
        (four, "1", "", 0, ""),
        (
            four,
            eight,
            "",
            2,
            "reads a result of 8192 bytes, and its encoder writes 4096; expected { result = \"4096B\" }",
        ),
        ("", eight, "", 2, "its encoder's kernel writes none; expected { result = \"8192B\" } among"),
        (four, four, four, 2, "which only an encoder writes"),
        (&format!("{four}, {four}"), four, "", 2, "one `result` at most"),
    ];
    for (encoder, decoder, alone, expected, words) in cases {
        for policy in ["redrt", "edf"] {
            let path = file("stage.toml", stage(encoder, decoder, alone).as_bytes());
            let more = ["--duration", "100ms", "--policy", policy];
            let (status, _, told) = run(&StandIn::new(""), path.to_str().expect("UTF-8"), &more);
            assert!(
                status == expected && told.contains(words),
                "{encoder} {decoder} {policy}: {status}: {told}"
            );
        }
    }
}

#[test]
fn a_kernel_that_never_ends_before_the_start_keeps_nobody_who_wants_to_stop() {
    let path = file("endless.toml", stage("", "", "").as_bytes());
    let stand_in = StandIn::new("hang k 2");
    let mut command = command(&["run", path.to_str().expect("UTF-8"), "--best-effort"]);
    let run =
        stand_in.give(&mut command).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("it starts");
    while !stand_in.log().iter().any(|line| line.starts_with("begin 2 k") || line.starts_with("begin 3 k")) {
        thread::sleep(Duration::from_millis(10));
    }
    kill(Pid::from_raw(run.id() as i32), Signal::SIGINT).expect("it is there");
    let (status, _, told) = ended(&run.wait_with_output().expect("it ends"));
    let words = "did not come to its end on the device within 1 s, when it was run once before the start; mend the kernel";
    assert!(status == 2 && told.contains("`t.s.d`") && told.contains(words), "{status}: {told}");
}

#[test]
fn the_doctor_opens_the_device_and_says_what_it_has() {
    let cases = [
        (
            "memory 67108864",
            "PASS measure.cuda: stand-in 0, compute capability 5.3, CUDA 12.2, 64 of 64 MiB free",
        ),
        ("devices 0", "WARN measure.cuda: the CUDA driver"),
        (
            "version 9020",
            "WARN measure.cuda: the CUDA driver supports CUDA 9.2; install one of CUDA 10.2 or later",
        ),
        (
            "refuse cuDevicePrimaryCtxRetain 1 2",
            "WARN measure.cuda: the CUDA device has too little memory left",
        ),
    ];
    let examine = |(script, words): (&str, &str)| {
        let mut doctor = command(&["doctor"]);
        let (_, out, _) = ended(&StandIn::new(script).give(&mut doctor).output().expect("it starts"));
        assert!(out.contains(words), "no `{words}` in: {out}");
    };
    // Each of them measures for seconds.
    thread::scope(|scope| cases.map(|case| scope.spawn(move || examine(case))).map(|one| one.join()))
        .into_iter()
        .for_each(|ended| ended.expect("it found what it should"));
}

/// Graphs of a file, each the only job of its task; one after the other, so that streams are idle now and then.
const GRAPHS: u64 = 16;

/// A file of random graphs with a kernel of its own for each node, on two to four streams and a lane of the CPU, and its
/// edges between kernels.
fn random(seed: u64) -> (String, String, Vec<(String, String)>) {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut below = move |n: u64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) % n
    };
    let (mut toml, mut ptx, mut edges) =
        (String::new(), ".version 6.0\n.target sm_53\n".to_owned(), Vec::new());
    let lanes = 2 + below(3);
    let _infallible = write!(
        toml,
        "[[pool]]\nname = 'gpu'\nkind = 'cuda'\nlanes = {lanes}\n[[pool]]\nname = 'cpu'\nlanes = 1\n"
    );
    for task in 0..GRAPHS {
        let _infallible = write!(
            toml,
            "[[task]]\nname = 't{task}'\ndeadline = '60s'\nonce = true\noffset = '{}ms'\n",
            task * 4
        );
        let nodes = 2 + below(9);
        let on_cpu: Vec<bool> = (0..nodes).map(|_| below(8) == 0).collect();
        for node in 0..nodes {
            let after: Vec<u64> = (0..node).filter(|_| below(3) == 0).collect();
            let names: Vec<String> = after.iter().map(|n| format!("'n{n}'")).collect();
            let _infallible = write!(
                toml,
                "[[task.node]]\nname = 'n{node}'\nwcet = '{}ms'\nafter = [{}]\n",
                1 + below(9),
                names.join(", ")
            );
            let name = format!("t{task}n{node}");
            if on_cpu[node as usize] {
                toml += "pool = 'cpu'\nbody = { spin = '20us' }\n";
                continue;
            }
            let _infallible = writeln!(
                toml,
                "body = {{ cuda = {{ module = 'random-{seed}.ptx', kernel = '{name}', grid = [1], block = [32] }} }}"
            );
            let _infallible = writeln!(ptx, ".visible .entry {name}() {{ ret; }}");
            edges.extend(
                after
                    .iter()
                    .filter(|n| !on_cpu[**n as usize])
                    .map(|n| (format!("t{task}n{n}"), name.clone())),
            );
        }
    }
    (toml, ptx, edges)
}

#[test]
fn a_thousand_random_graphs_keep_precedence_and_wait_for_nothing_else() {
    let (mut graphs, mut waits, mut ahead) = (0, 0, 0);
    for seed in 1..=63 {
        let (toml, ptx, edges) = random(seed);
        file(&format!("random-{seed}.ptx"), ptx.as_bytes());
        let path = file(&format!("random-{seed}.toml"), toml.as_bytes());
        let stand_in = StandIn::new(&format!("takes * {}\n", 20 + seed * 5));
        let ran = summary(run(&stand_in, path.to_str().expect("UTF-8"), &["--duration", "70ms"]));
        for task in ran["tasks"].as_array().expect("a list") {
            assert_eq!(count(task, "on_time"), 1, "seed {seed}: {ran}");
        }
        let log = stand_in.log();
        let edges: Edges<'_> = edges.iter().map(|(from, to)| (from.as_str(), to.as_str())).collect();
        let warm = log::warm(&log);
        log::precedence(&log[warm..], &edges);
        assert_eq!(log::waits(&log, &edges) as u64, count(&ran, "event_waits_issued"), "seed {seed}");
        graphs += GRAPHS;
        waits += count(&ran, "event_waits_issued");
        ahead += count(&ran, "submissions_ahead");
    }
    assert!(graphs >= 1000 && waits >= 100 && ahead >= 1000, "{graphs} graphs, {waits} waits, {ahead} ahead");
}
