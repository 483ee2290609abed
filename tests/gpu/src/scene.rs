//! Runs of the command on files of this crate's.

use crate::{Bench, Failure, Figures, KERNELS};
use serde_json::Value;
use std::path::PathBuf;
use std::process::{self, Command};
use std::{env, fs};

const SCENE: &str = include_str!("../obstacle.toml");
/// A kernel that goes wrong in its tenth run, the warm-up being one, beside a task of the CPU.
const WRONG: &str = "
[[pool]]
name  = 'gpu'
kind  = 'cuda'
lanes = 1
[[pool]]
name  = 'cpu'
lanes = 1
[[task]]
name     = 'sees'
deadline = '40ms'
period   = '50ms'
[[task.node]]
name = 'strikes'
pool = 'gpu'
wcet = '5ms'
body = { cuda = { module = 'kernels/checks.ptx', kernel = 'strike', grid = [1], block = [1], args = [{ scratch = '4B' }, 10] } }
[[task]]
name     = 'steers'
deadline = '40ms'
period   = '50ms'
[[task.node]]
name = 'control'
pool = 'cpu'
wcet = '1ms'
body = { spin = '100us' }
";

/// A folder that goes when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Result<Self, Failure> {
        let folder = Self(env::temp_dir().join(format!("red-gpu-tests-{}", process::id())));
        let kernels = folder.0.join("kernels");
        fs::create_dir_all(&kernels)?;
        fs::write(kernels.join("checks.ptx"), KERNELS)?;
        Ok(folder)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _left_there = fs::remove_dir_all(&self.0);
    }
}

/// Exit status, summary, and what was said.
fn run(bench: &Bench, workload: &str, more: &[&str]) -> Result<(Option<i32>, Value, String), Failure> {
    let folder = Folder::new()?;
    let path = folder.0.join("workload.toml");
    fs::write(&path, workload)?;
    let mut command = Command::new(&bench.redrt);
    command.arg("run").arg(&path).args(["--json", "--best-effort"]).args(more);
    let ended = command.output().map_err(|error| {
        format!(
            "{}: {error}; build it with `cargo build --release -p redrt`, or name it by --redrt",
            bench.redrt.display()
        )
    })?;
    let told = String::from_utf8_lossy(&ended.stderr).into_owned();
    let summary = serde_json::from_slice(&ended.stdout).unwrap_or_default();
    Ok((ended.status.code(), summary, told))
}

fn count(of: &Value, key: &str) -> Result<u64, Failure> {
    of[key].as_u64().ok_or_else(|| format!("no `{key}` in {of}").into())
}

pub(crate) fn compare(bench: &Bench) -> Result<Figures, Failure> {
    let mut figures = Vec::new();
    for policy in ["edf", "redrt"] {
        let (status, summary, told) = run(bench, SCENE, &["--duration", "4s", "--policy", policy])?;
        if status != Some(0) {
            return Err(format!("{policy}: exit status {status:?}: {told}").into());
        }
        let cruise = &summary["tasks"][0];
        let [released, on_time] = [count(cruise, "released")?, count(cruise, "on_time")?];
        let [issued, avoided, ahead, bytes] =
            ["event_waits_issued", "event_waits_avoided", "submissions_ahead", "device_memory_bytes"]
                .map(|key| count(&summary, key));
        let mode = if summary["realtime"] == true { "real time" } else { "best effort" };
        figures.push(format!(
            "{policy:<6} {on_time} of {released} jobs on time; {} event waits, {} avoided, {} submissions ahead, \
             {} bytes of the device; {}",
            issued?, avoided?, ahead?, bytes?, mode
        ));
    }
    Ok(figures)
}

pub(crate) fn illegal_access(bench: &Bench) -> Result<Figures, Failure> {
    let (status, summary, told) = run(bench, WRONG, &["--duration", "1500ms", "--policy", "edf"])?;
    let lost = summary["device_lost"].as_str().unwrap_or_default();
    if status != Some(3)
        || !lost.contains("CUDA_ERROR_ILLEGAL_ADDRESS")
        || !told.contains("start the process again")
    {
        return Err(format!("exit status {status:?}, device_lost \"{lost}\", and: {told}").into());
    }
    let [sees, steers] = [&summary["tasks"][0], &summary["tasks"][1]];
    let of = |task: &Value| Ok::<_, Failure>((count(task, "released")?, count(task, "on_time")?));
    let ((released, on_time), (steered, in_time)) = (of(sees)?, of(steers)?);
    if on_time >= released || in_time == 0 {
        return Err(
            format!("{on_time} of {released} jobs on the device, {in_time} of {steered} on the CPU").into()
        );
    }
    Ok(vec![
        format!("exit status 3, {lost}"),
        format!("{on_time} of {released} jobs on the device before it, {in_time} of {steered} on the CPU"),
    ])
}
