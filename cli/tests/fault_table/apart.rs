//! What would harm the other tests runs in a process of its own: this program again, with one test.

use std::any::type_name_of_val;
use std::env;
use std::ffi::OsStr;
use std::process::{Command, Output};

/// Set in the process that a test is alone in.
const APART: &str = "RED_FAULT_TABLE_APART";

/// Runs `body`, a closure of the calling test, in a process that `wrapper` starts; its output. In that process `None`,
/// after the body.
pub(crate) fn apart(wrapper: &[&str], body: impl FnOnce()) -> Option<Output> {
    let name = type_name_of_val(&body);
    let test = name.split_once("::").and_then(|(_, path)| path.strip_suffix("::{{closure}}"));
    let test = test.expect("a closure in a test").to_owned();
    if env::var_os(APART).is_some() {
        body();
        return None;
    }
    let program = env::current_exe().expect("this program");
    // What is tried here may stand still for ever.
    let bounded = ["timeout", "--signal=KILL", "300"];
    let mut words: Vec<&OsStr> = bounded.iter().chain(wrapper).map(OsStr::new).collect();
    words.push(program.as_os_str());
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).args(["--exact", &test, "--nocapture", "--test-threads=1"]).env(APART, "1");
    Some(command.output().unwrap_or_else(|error| panic!("{:?}: {error}", words[0])))
}

/// Asserts that the test ran there, and passed.
pub(crate) fn passed(output: &Output) {
    let (out, err) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("1 passed"), "{}\n{out}\n{err}", output.status);
}
