//! Texts for tests: the manual's example in both formats, and a way to break a small valid file in one place.

use crate::model::Workload;
use crate::{Format, LoadError, parse};

/// The example of the manual.
pub(crate) const EXAMPLE_TOML: &str = r#"
[[pool]]                 # execution resources; the first is the default pool
name   = "gpu"
kind   = "cpu"           # or "cuda": where `run` executes the bodies; default cpu
lanes  = 2               # effective parallelism rho, integer
memory = "512MiB"        # budget for the nodes' memory; absent = unlimited
cpus   = [1]             # for `run`: where the lanes' threads are pinned

[[sensor]]               # optional: when frames of a sensor are captured
name   = "front"
period = "33ms"          # capture instants are j * period

[[task]]                 # one DAG tau = (V, E, D)
name     = "cruise"
deadline = "120ms"       # end to end, relative
period   = "100ms"       # or: min_interarrival = "100ms" (sporadic), or: once = true
offset   = "0ms"
value    = 10            # static criticality for shedding; higher survives longer; default 1
floor    = [3, 4]        # at least 3 of any 4 consecutive jobs are never shed by choice

[[task.node]]
name   = "camera"
wcet   = "2ms"
bcet   = "1ms"           # optional best case; default 0
body   = { spin = "1500us" }

[[task.node]]            # a MIMONet stage: refined into one encoder and its decoders
name    = "perception"  # pool, memory, atomic and contention may stand here too
after   = ["camera"]
mimonet = { weights = "mimo-v1", frame = "front", encoder = { wcet = "12ms", body = { onnx = "models/encoder.onnx" } }, decoders = [
  { name = "lane",    wcet = "4ms", body = { onnx = "models/lane.onnx" } },
  { name = "segment", wcet = "6ms", body = { onnx = "models/segment.onnx" } } ] }

[[task.node]]
name   = "control"
after  = ["perception"]  # after a refined stage = after all of its decoders
wcet   = "3ms"
atomic = true            # indivisible
contention = "1ms"       # Delta_cont, atomic nodes only
pool   = "gpu"
memory = "8MiB"
body   = { plugin = "libcontrol.so", symbol = "control_step" }

[[event]]                # environmental dynamics
at   = "3s"
task = "cruise"
add  = [ { name = "detect", wcet = "9ms", after = ["camera"], before = ["control"], body = { onnx = "models/detect.onnx" } } ]
[[event]]
at = "6s"
task = "cruise"
remove = ["detect"]
"#;

/// The same workload in YAML.
pub(crate) const EXAMPLE_YAML: &str = r#"
# block and flow style, quoted and plain
pool:
  - {name: gpu, kind: cpu, lanes: 2, memory: 512MiB, cpus: [1]}
sensor:
  - name: front
    period: 33ms
task:
  - name: cruise
    deadline: 120ms
    period: "100ms"
    offset: 0ms
    value: 10
    floor: [3, 4]
    node:
      - name: camera
        wcet: 2ms
        bcet: 1ms
        body: {spin: 1500us}
      - name: perception
        after: [camera]
        mimonet:
          weights: mimo-v1
          frame: 'front'
          encoder: {wcet: 12ms, body: {onnx: models/encoder.onnx}}
          decoders:
            - {name: lane, wcet: 4ms, body: {onnx: models/lane.onnx}}
            - {name: segment, wcet: 6ms, body: {onnx: models/segment.onnx}}
      - name: control
        after: [perception]
        wcet: 3ms
        atomic: true
        contention: 1ms
        pool: gpu
        memory: 8MiB
        body: {plugin: libcontrol.so, symbol: control_step}
event:
  - at: 3s
    task: cruise
    add:
      - name: detect
        wcet: 9ms
        after: [camera]
        before: [control]
        body: {onnx: models/detect.onnx}
  - {at: 6s, task: cruise, remove: [detect]}
"#;

/// A pool and the head of a task, for nodes to follow.
pub(crate) const HEAD: &str = r#"
pool = [{ name = "cpu", lanes = 1, memory = "1KiB" }, { name = "gpu", lanes = 1 }]
[[task]]
name = "t"
deadline = "9ms"
period = "10ms"
"#;

/// [`HEAD`], nodes as inline tables, and whatever else follows.
pub(crate) fn with_nodes(nodes: &str, rest: &str) -> String {
    format!("{HEAD}node = [{nodes}]\n{rest}")
}

/// The workload of a TOML text that must be accepted.
pub(crate) fn accepted(text: &str) -> Workload {
    parse(text.as_bytes(), Format::Toml, "w").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The refusal of a TOML text that must be refused. Its message must keep the promises that all messages make.
pub(crate) fn refused(text: &str) -> LoadError {
    refused_as(text.as_bytes(), Format::Toml)
}

/// As [`refused`], in any format.
pub(crate) fn refused_as(text: &[u8], format: Format) -> LoadError {
    let error = match parse(text, format, "w.toml") {
        Err(error) => error,
        Ok(workload) => panic!("accepted: {}\n{workload:?}", String::from_utf8_lossy(text)),
    };
    let message = error.to_string();
    assert!(message.chars().count() <= 2000, "{message}");
    assert!(
        !message
            .chars()
            .any(|c| c.is_control() || matches!(c, '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}')),
        "{message:?}"
    );
    assert!(message.contains("w.toml:"), "{message}");
    error
}
