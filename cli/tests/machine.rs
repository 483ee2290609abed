//! What the machine does not grant: exit status 3 with the cure, and nothing on standard output.

#[expect(dead_code, reason = "this file needs only a part of it")]
mod process;

use process::{command, ended, file};
use serde_json::Value;
use std::fs;
use std::process::Command;

/// The command without real-time rights: through `prlimit`, and as root without the capabilities either.
fn without_rights(arguments: &[&str]) -> (i32, String, String) {
    let is_root = fs::read_to_string("/proc/self/status")
        .unwrap()
        .lines()
        .any(|line| line.strip_prefix("Uid:").is_some_and(|ids| ids.split_whitespace().nth(1) == Some("0")));
    let mut wrapped = Command::new("prlimit");
    wrapped.args(["--rtprio=0:0", "--nice=0:0", "--memlock=65536:65536", "--"]);
    if is_root {
        let none = "-sys_nice,-ipc_lock,-sys_resource";
        wrapped.args(["setpriv", "--bounding-set", none, "--inh-caps", none, "--"]);
    }
    let bare = command(arguments);
    wrapped.arg(bare.get_program()).args(bare.get_args());
    wrapped.current_dir(bare.get_current_dir().expect("the root of the repository"));
    let output =
        wrapped.output().expect("no prlimit or setpriv; install them with: apt-get install util-linux");
    let (status, out, err) = ended(&output);
    assert!(
        !err.contains("setpriv:") && !err.contains("prlimit:"),
        "the rights cannot be dropped here: {err}"
    );
    (status, out, err)
}

/// The command on one CPU.
fn on_one_cpu(arguments: &[&str]) -> (i32, String, String) {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let list = status.lines().find_map(|line| line.strip_prefix("Cpus_allowed_list:")).expect("Linux has it");
    let first = list.trim().split([',', '-']).next().expect("there is a CPU");
    let bare = command(arguments);
    let mut wrapped = Command::new("taskset");
    wrapped.args(["-c", first]).arg(bare.get_program()).args(bare.get_args());
    wrapped.current_dir(bare.get_current_dir().expect("the root of the repository"));
    ended(&wrapped.output().expect("no taskset; install it with: apt-get install util-linux"))
}

fn workload(name: &str, pool: &str) -> String {
    let text = format!(
        "pool = [{{ name = \"cpu\", {pool} }}]\n\
         [[task]]\nname = \"t\"\nperiod = \"50ms\"\ndeadline = \"20s\"\n\
         node = [{{ name = \"a\", wcet = \"1ms\", body = {{ spin = \"10us\" }} }}]\n"
    );
    file(name, text.as_bytes()).to_str().unwrap().to_owned()
}

#[test]
fn without_rights_nothing_runs_and_the_fix_is_told() {
    let path = workload("rights.toml", "lanes = 1");
    for arguments in [&["run", &path, "--json"][..], &["profile", &path, "--force", "--json"]] {
        let (status, out, err) = without_rights(arguments);
        assert_eq!((status, &*out), (3, ""), "{arguments:?}: {err}");
        assert!(err.contains("fix:") && err.contains("rtprio") && err.contains("--best-effort"), "{err}");
        assert!(
            err.contains(concat!("'", env!("CARGO_BIN_EXE_redrt"), "'")) && err.contains("rebuild"),
            "{err}"
        );
    }
}

#[test]
fn without_rights_best_effort_runs_and_says_so_everywhere() {
    let path = workload("best-effort.toml", "lanes = 1");
    let run = ["run", &path, "--duration", "200ms", "--best-effort"];
    let (status, out, err) = without_rights(&run);
    assert_eq!(status, 0, "{err}");
    assert!(err.contains("BEST EFFORT") && err.contains("fix:"), "{err}");
    assert!(out.contains("BEST EFFORT"), "{out}");
    let (status, out, err) = without_rights(&[&run[..], &["--json"]].concat());
    assert_eq!(status, 0, "{err}");
    let summary: Value = serde_json::from_str(&out).expect("one JSON object");
    assert_eq!(summary["realtime"], false);
}

#[test]
fn lanes_without_a_cpu_each_are_refused() {
    let path = workload("lanes.toml", "lanes = 2");
    let (status, out, err) = on_one_cpu(&["run", &path, "--json"]);
    assert_eq!((status, &*out), (3, ""), "{err}");
    assert!(err.contains("2 lanes") && err.contains("at most 1 lanes"), "{err}");
    let (status, _, err) = on_one_cpu(&["run", &path, "--best-effort", "--duration", "200ms", "--json"]);
    assert_eq!(status, 0, "ordinary threads share CPUs: {err}");
}

#[test]
fn a_cpu_that_is_not_there_is_named() {
    let path = workload("cpus.toml", "lanes = 1, cpus = [1023]");
    let (status, out, err) = ended(&command(&["run", &path, "--json"]).output().unwrap());
    assert_eq!((status, &*out), (3, ""), "{err}");
    assert!(err.contains("CPU 1023") && err.contains("fix:"), "{err}");
}
