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
pub(super) enum Why {
    /// `run` has to execute it.
    NoBody,
    /// CUDA bodies need a driver and a version with CUDA lanes.
    Cuda,
    /// Its file could not be used.
    Load(BodyError),
    /// A decoder reads another size than its encoder writes, in numbers of f32.
    Shape { reads: usize, written: usize },
}

impl BodiesError {
    /// What is wrong with a part of a task, both by number; `node` is its name in the task.
    pub(super) fn of(source: &Source, task: usize, part: usize, node: &str, why: Why) -> Self {
        let node = format!("{}.{node}", source.workload.tasks[task].name);
        Self { place: source.body(task, part), node, why }
    }

    /// Whether the file is in order, and this version cannot run it.
    pub(crate) const fn is_of_machine(&self) -> bool {
        matches!(self.why, Why::Cuda)
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
            Why::Cuda => f.write_str(
                " has a cuda body, and this version has no CUDA lanes; expected a body for the CPU, such as { onnx = \"...\" }",
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
