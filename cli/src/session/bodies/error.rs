//! Why a body could not be made ready, and where in the file it stands.

use red_bodies::BodyError;
use red_workload::{Source, shown, shown_path};
use std::fmt;

/// A body could not be made ready.
#[derive(Debug)]
pub(crate) struct BodiesError {
    /// In the workload file.
    place: String,
    /// Task and node.
    node: String,
    why: Why,
}

/// What is wrong.
#[derive(Debug)]
pub(crate) enum Why {
    /// `run` has to execute it.
    NoBody,
    /// It runs on a CUDA device, and its pool is of the CPU.
    OfDevice,
    /// It runs on the CPU, and its pool is of a CUDA device.
    OfHost,
    /// It is to be captured as a CUDA graph, and its pool is of the CPU.
    Captured,
    /// Its encoder runs in a pool of another kind, whose results it cannot read.
    Apart,
    /// The driver does not take its module.
    Module(String),
    /// Its module has no kernel of this name.
    Kernel(String),
    /// The device refuses it: what to do, and where memory is short, how much is free, and of how much.
    Device { error: String, cure: &'static str, memory: Option<(usize, usize)> },
    /// Its kernel did not come to its end in the run before the start, within so many seconds or until a signal came.
    Endless { waited_s: u64 },
    /// It reads a result of so many bytes; its encoder writes another one, or none.
    Result { reads: u64, writes: Option<u64> },
    /// It has a result without being of a stage.
    NoStage,
    /// Its buffers, for one lane, take more bytes of the device than its `memory` says, in a pool with a budget.
    Footprint { takes: u64, says: u64 },
    /// Its file could not be used.
    Load(BodyError),
    /// A decoder reads another size than its encoder writes, in numbers of f32.
    Shape { reads: usize, written: usize },
}

impl BodiesError {
    /// What is wrong with a part of a task, both by number; `node` is its name in the task.
    pub(crate) fn of(source: &Source, task: usize, part: usize, node: &str, why: Why) -> Self {
        let node = format!("{}.{node}", source.workload.tasks[task].name);
        Self { place: source.body(task, part), node, why }
    }

    /// Whether the file is in order, and this machine cannot run it.
    pub(crate) const fn is_of_machine(&self) -> bool {
        matches!(self.why, Why::Device { .. })
    }
}

impl fmt::Display for BodiesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { place, node, why } = self;
        write!(f, "{place}: node `{node}`")?;
        match why {
            Why::NoBody => f.write_str(
                " has no body, so it can be planned and simulated but not run; expected a body such as { spin = \"1ms\" }",
            ),
            Why::OfDevice => f.write_str(
                " has a cuda body in a pool of the CPU; expected a body for the CPU, such as { onnx = \"...\" }, or \
                 kind = \"cuda\" for its pool",
            ),
            Why::OfHost => f.write_str(
                " has an onnx body, which runs on the CPU, in a pool of kind cuda; expected a cuda body, a plugin that \
                 submits to the stream that it is given, or another pool",
            ),
            Why::Captured => f.write_str(
                " has graph = true in a pool of the CPU; expected kind = \"cuda\" for its pool, or a body without `graph`",
            ),
            Why::Endless { waited_s } => write!(
                f,
                " did not come to its end on the device within {waited_s} s, when it was run once before the start; mend the \
                 kernel"
            ),
            Why::Result { reads, writes: Some(writes) } => write!(
                f,
                " reads a result of {reads} bytes, and its encoder writes {writes}; expected {{ result = \"{writes}B\" }}"
            ),
            Why::Result { reads, writes: None } => write!(
                f,
                " reads a result, and its encoder's kernel writes none; expected {{ result = \"{reads}B\" }} among the \
                 encoder's arguments"
            ),
            Why::NoStage => f.write_str(
                " has a result, which only an encoder writes and its decoders read; expected { output = \"...\" } or \
                 { scratch = \"...\" }, or a stage",
            ),
            Why::Apart => f.write_str(
                " is a decoder in a pool of another kind than its encoder's, whose result it cannot read; expected one \
                 kind for the stage",
            ),
            Why::Module(words) => write!(f, ": its module is no PTX or cubin that the driver takes: {words}"),
            Why::Kernel(kernel) => {
                write!(f, ": its module has no kernel `{}`; expected the name behind .entry", shown(kernel))
            }
            Why::Device { error, cure, memory: None } => write!(f, " does not run on the device: {error}; {cure}"),
            Why::Device { error, memory: Some((free, total)), .. } => write!(
                f,
                " needs more of the device's memory than is left: {error}; {free} of {total} bytes are free; use \
                 smaller arguments or fewer lanes, or end what else uses the device"
            ),
            Why::Footprint { takes, says } => write!(
                f,
                " takes {takes} bytes of the device's memory for each lane, and says {says}, by which its pool's budget would \
                 be kept; expected memory = \"{takes}B\" or more"
            ),
            Why::Load(error) => write!(f, ": {}", error.told(shown, shown_path)),
            Why::Shape { reads, written } => write!(
                f,
                " reads {reads} numbers, but its encoder writes {written}; expected the decoder of that encoder"
            ),
        }
    }
}

impl std::error::Error for BodiesError {}
