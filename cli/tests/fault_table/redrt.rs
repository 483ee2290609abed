//! `redrt run` as the rows need it: one node with a body from `tests/plugin/faults.c`.

use crate::plugin;
use crate::process::{command, file};
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A workload whose task `t` has one node with the body `symbol`, one lane for each of the `lanes`, and `more`.
pub(crate) fn workload(row: &str, symbol: &str, lanes: u32, more: &str) -> PathBuf {
    let object = plugin::built("faults", row);
    let text = format!(
        "pool = [{{ name = \"cpu\", lanes = {lanes} }}]\n\
         [[task]]\nname = \"t\"\nperiod = \"50ms\"\ndeadline = \"20s\"\n\
         node = [{{ name = \"a\", wcet = \"1ms\", body = {{ plugin = {object:?}, symbol = {symbol:?} }} }}]\n{more}"
    );
    file(&format!("{row}.toml"), text.as_bytes())
}

/// `redrt run` of this file.
pub(crate) fn run(path: &std::path::Path, more: &[&str]) -> Command {
    command(&[&["run", path.to_str().unwrap(), "--json"], more].concat())
}

/// The summary of a run that ended with `status`, and what was told.
pub(crate) fn summary(output: &Output, status: i32) -> (Value, String) {
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(status), "{told}");
    let summary = serde_json::from_slice(&output.stdout);
    (summary.unwrap_or_else(|error| panic!("one JSON object: {error}\n{told}")), told)
}

pub(crate) fn count(of: &Value, key: &str) -> u64 {
    of[key].as_u64().unwrap_or_else(|| panic!("{key} of {of}"))
}

/// Jobs of the first task: released, completed and given up.
pub(crate) fn jobs(summary: &Value) -> [u64; 3] {
    ["released", "completed", "shed"].map(|key| count(&summary["tasks"][0], key))
}
