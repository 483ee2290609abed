//! Bodies that cannot be made ready: refused with their place, before anything of them runs.

#[path = "process/plugin.rs"]
mod plugin;
#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;
#[path = "process/refused.rs"]
mod refusal;

use process::{command, ended};
use refusal::refused;
use std::fs::{self, File};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const HEAD: &str =
    "pool = [{ name = 'p', lanes = 1 }]\n[[task]]\nname = 't'\nperiod = '5ms'\ndeadline = '1s'\n";

/// A folder of this test, with files and links of all kinds.
fn folder() -> PathBuf {
    let root = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let folder = root.join("bodies");
    let _none_there = fs::remove_dir_all(&folder);
    fs::create_dir_all(folder.join("folder")).unwrap();
    let object = root.join(plugin::built("faults", "bodies"));
    let whole = fs::read(&object).unwrap();
    fs::write(folder.join("good.so"), &whole).unwrap();
    fs::write(folder.join("cut.so"), &whole[..whole.len() / 3]).unwrap();
    fs::write(folder.join("text.so"), "not an object").unwrap();
    for (name, size) in [("zeros.onnx", 3 << 29), ("huge.onnx", 1 << 40), ("huge.so", 1 << 40)] {
        File::create(folder.join(name)).and_then(|file| file.set_len(size)).unwrap();
    }
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models/control.onnx");
    for (to, link) in [(object.as_path(), "out.so"), (&model, "out.onnx"), (Path::new("loop"), "loop")] {
        symlink(to, folder.join(link)).unwrap();
    }
    symlink("/dev/zero", folder.join("device")).unwrap();
    symlink("good.so", folder.join("link.so")).unwrap();
    assert!(Command::new("mkfifo").arg(folder.join("fifo")).status().expect("coreutils").success());
    folder
}

/// Runs a workload file that must end by itself within seconds.
fn run(path: &Path, policy: &str) -> (i32, String, String) {
    let arguments = ["run", path.to_str().unwrap(), "--policy", policy, "--duration", "10ms", "--json"];
    let bare = command(&[&arguments[..], &["--best-effort"]].concat());
    let mut bounded = Command::new("timeout");
    bounded.args(["--signal=KILL", "30"]).arg(bare.get_program()).args(bare.get_args());
    bounded.stdin(Stdio::null()).current_dir(bare.get_current_dir().expect("the root of the repository"));
    ended(&bounded.output().expect("no timeout; install it with: apt-get install coreutils"))
}

/// One message of one line.
fn assert_refused(path: &Path, policy: &str, status: i32, words: &[&str]) {
    let err = refused(run(path, policy), status, words);
    assert_eq!(err.lines().count(), 1, "{err}");
}

#[test]
fn files_that_are_no_bodies_are_refused_at_their_place() {
    let folder = folder();
    let path = folder.join("w.toml");
    let (symbol, long) = ("s".repeat(300), "d/".repeat(100));
    let cases = [
        ("onnx = 'absent.onnx'", "cannot read `", "/absent.onnx`: No such file"),
        ("onnx = 'loop'", "cannot read", "/loop`"),
        ("onnx = 'fifo'", "a FIFO", "/fifo`"),
        ("onnx = 'folder'", "is a directory", "expected a regular file"),
        ("onnx = 'device'", "leads out of the folder", "/device`"),
        ("onnx = 'out.onnx'", "leads out of the folder", "/out.onnx`"),
        ("onnx = 'zeros.onnx'", "not an ONNX file", "/zeros.onnx`"),
        ("onnx = 'huge.onnx'", "too large", "at most 2 GiB"),
        ("onnx = 'good.so'", "not an ONNX file", "expected ONNX"),
        ("onnx = \"\\u001b[31m.onnx\"", "cannot read", "\\u{1b}[31m.onnx`"),
        (&format!("onnx = '{long}m.onnx'"), "`…", "d/m.onnx`"),
        ("plugin = 'absent.so', symbol = 'good'", "cannot read", "/absent.so`"),
        ("plugin = 'fifo', symbol = 'good'", "a FIFO", "/fifo`"),
        ("plugin = 'out.so', symbol = 'good'", "leads out of the folder", "/out.so`"),
        ("plugin = 'huge.so', symbol = 'good'", "too large", "at most 1 GiB"),
        ("plugin = 'cut.so', symbol = 'good'", "cut short", "cc -shared -fPIC"),
        ("plugin = 'text.so', symbol = 'good'", "cut short", "cc -shared -fPIC"),
        ("plugin = 'good.so', symbol = 'nope'", "no function `nope`", "red_plugin.h"),
        (&format!("plugin = 'good.so', symbol = '{symbol}'"), "no function `sss", "s…`"),
    ];
    for (body, problem, words) in cases {
        let node = format!("node = [{{ name = 'a', wcet = '1ms', body = {{ {body} }} }}]\n");
        fs::write(&path, format!("{HEAD}{node}")).unwrap();
        assert_refused(&path, "redrt", 2, &["bodies/w.toml:6:44: node `t.a`", "expected", problem, words]);
    }
    let node = "node = [{ name = 'a', wcet = '1ms', body = { plugin = 'link.so', symbol = 'good' } }]\n";
    fs::write(&path, format!("{HEAD}{node}")).unwrap();
    let (status, _, err) = run(&path, "redrt");
    assert_eq!(status, 0, "{err}");
}

#[test]
fn nodes_without_a_body_for_their_pool_are_refused_at_their_place() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("no-body.toml");
    let spin = "body = { spin = '1us' }";
    let stage = |encoder: &str, decoder: &str| {
        format!(
            "{{ name = 's', mimonet = {{ weights = 'w', frame = 'f', encoder = {{ wcet = '1ms', {encoder} }},\n\
             decoders = [{{ name = 'd', wcet = '1ms', {decoder} }}] }} }}"
        )
    };
    let node = |body: &str| format!("{{ name = 'a', wcet = '1ms', {body} }}");
    let event = "[[event]]\nat = '9s'\ntask = 't'\nadd = [{ name = 'z', wcet = '1ms' }]\n";
    let cuda = "body = { cuda = { module = 'k.ptx', kernel = 'k', grid = [1], block = [1] } }";
    let cases = [
        (node(""), "", 2, ["6:9: node `t.a` has no body", "expected a body"]),
        (stage("", spin), "", 2, ["6:73: node `t.s.encoder` has no body", "expected a body"]),
        (stage(spin, ""), "", 2, ["7:13: node `t.s.d` has no body", "expected a body"]),
        (node(spin), event, 2, ["10:8: node `t.z` has no body", "expected a body"]),
        (node(cuda), "", 2, ["6:44: node `t.a` has a cuda body", "expected a body for the CPU"]),
    ];
    for (node, event, status, words) in cases {
        fs::write(&path, format!("{HEAD}node = [{node}]\n{event}")).unwrap();
        for policy in ["redrt", "edf"] {
            assert_refused(&path, policy, status, &[&format!("no-body.toml:{}", words[0]), words[1]]);
            assert!(!run(&path, policy).2.contains("--best-effort"), "which does not help");
        }
    }
}

#[test]
fn a_plugin_that_refuses_a_lane_stops_the_start() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let object = plugin::built("faults", "refuses");
    let node = format!(
        "node = [{{ name = 'a', wcet = '1ms', body = {{ plugin = '{object}', symbol = 'refuses' }} }}]\n"
    );
    let path = folder.join("refuses.toml");
    fs::write(&path, format!("{HEAD}{node}")).unwrap();
    let words = ["on lane 0", "`refuses_open`", "returned 9", "nothing ran"];
    let told = refused(run(&path, "redrt"), 2, &words);
    assert!(!told.contains("mend the body"), "{told}");
}

#[test]
fn nothing_of_a_refused_workload_is_loaded() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("loaded");
    fs::create_dir_all(&folder).unwrap();
    let (code, object, path) = (folder.join("p.c"), folder.join("p.so"), folder.join("w.toml"));
    let source = "#include <stdio.h>\n__attribute__((constructor)) static void start(void) { puts(\"loaded\"); }\n\
                  int good(void) { return 0; }\n";
    fs::write(&code, source).unwrap();
    let built = Command::new("cc").args(["-shared", "-fPIC", "-o"]).args([&object, &code]).status();
    assert!(built.expect("no C compiler; install it with: apt-get install gcc libc6-dev").success());
    let nodes = "node = [{ name = 'a', wcet = '1ms', body = { plugin = 'p.so', symbol = 'good' } },\n\
                 { name = 'b', wcet = '1ms' }]\n";
    fs::write(&path, format!("{HEAD}{nodes}")).unwrap();
    assert_refused(&path, "redrt", 2, &["w.toml:7:1: node `t.b` has no body"]);
}

#[test]
fn sensors_that_nobody_reads_are_no_matter_of_the_scheduler() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sensors.toml");
    let sensors: String =
        (1..=300).map(|n| format!("[[sensor]]\nname = 's{n}'\nperiod = '{n}ms'\n")).collect();
    let node = "node = [{ name = 'a', wcet = '1ms', body = { spin = '1us' } }]\n";
    fs::write(&path, format!("{HEAD}{node}{sensors}")).unwrap();
    let (status, _, err) = run(&path, "redrt");
    assert_eq!(status, 0, "{err}");
    for subcommand in ["plan", "sim"] {
        let output = command(&[subcommand, path.to_str().unwrap()]).output().unwrap();
        assert_eq!(ended(&output).0, 0, "{subcommand}");
    }
}
