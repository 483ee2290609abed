//! Inference of ONNX networks on the CPU, in place on the calling lane.
//!
//! An [`Engine`] loads a file into a [`Network`], which the lanes share; each lane has its own [`Instance`]. The
//! caller owns every tensor that goes in or comes out: an instance reads one flat buffer, the network's inputs one
//! after the other, and fills another with its outputs. So an encoder's output buffer is a decoder's input buffer,
//! with no copy between.
//!
//! The intermediate tensors are the engine's, and engines allocate them anew in each run. The heap serves those calls
//! without the kernel once it has grown to what a run needs and keeps it: run each instance a few times on its lane
//! before real time starts, after `mallopt(M_MMAP_MAX, 0)` and `mallopt(M_TRIM_THRESHOLD, i32::MAX)`.

mod inference;
mod lane;
#[cfg(feature = "ort")]
mod ort;
mod rten;
mod wire;

use std::io::{Read, Seek};
use std::path::Path;

#[cfg(feature = "ort")]
pub use self::ort::Ort;
pub use self::rten::Rten;
pub use inference::Inference;
pub use lane::on_lane;

use crate::{Body, BodyError, Call, body_file};

/// An inference engine.
pub trait Engine: Send + Sync {
    /// Reads a model, prepares it and runs it once. Not for real time: takes milliseconds to seconds.
    ///
    /// # Errors
    /// The file cannot be read, is not a regular one of at most 2 GiB, the engine does not accept it, it fails on an input of zeros, or it has inputs or
    /// outputs that are not `f32` of fixed size.
    fn load(&self, path: &Path) -> Result<Box<dyn Network>, BodyError>;
}

/// A loaded network, shared by the lanes.
pub trait Network: Send + Sync {
    /// The inputs, in the order in which they lie in the input buffer.
    fn inputs(&self) -> &[Port];

    /// The outputs, in the order in which they lie in the output buffer.
    fn outputs(&self) -> &[Port];

    /// Makes what one lane runs. Not for real time.
    ///
    /// # Errors
    /// The engine has no more memory, or refuses.
    fn instance(&self) -> Result<Box<dyn Instance>, BodyError>;

    /// Number of values in the input buffer.
    fn input_len(&self) -> usize {
        self.inputs().iter().map(Port::len).sum()
    }

    /// Number of values in the output buffer.
    fn output_len(&self) -> usize {
        self.outputs().iter().map(Port::len).sum()
    }
}

/// A network as one lane runs it.
pub trait Instance: Send {
    /// Runs the network once on the calling thread, which must be inside [`on_lane`].
    ///
    /// # Errors
    /// A buffer has the wrong length, the thread is not a lane, or the engine failed; `output` is then unspecified.
    fn run(&mut self, input: &[f32], output: &mut [f32]) -> Result<(), BodyError>;
}

/// An input or output of a network: a dense tensor of `f32` in row-major order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Name in the model.
    pub name: String,
    /// Sizes of the dimensions.
    pub shape: Vec<usize>,
}

/// Values in one tensor at most: 1 GiB.
const MAX_LEN: usize = 1 << 28;

impl Port {
    /// A port of the model at `path`; a size that the model leaves open is `None`.
    fn new(
        path: &Path,
        name: &str,
        sizes: impl IntoIterator<Item = Option<usize>>,
    ) -> Result<Self, BodyError> {
        let refuse = |reason| BodyError::Port { path: path.into(), port: name.into(), reason };
        let shape: Option<Vec<usize>> = sizes.into_iter().collect();
        let shape = shape.ok_or_else(|| refuse("has a size that is left open"))?;
        let len = shape.iter().try_fold(1_usize, |len, &size| len.checked_mul(size));
        if len.is_none_or(|len| len > MAX_LEN) {
            return Err(refuse("is larger than 1 GiB"));
        }
        Ok(Self { name: name.into(), shape })
    }

    /// Number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether there are no values at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The error for an output that an engine produced in another size.
    fn changed(&self) -> BodyError {
        BodyError::Inference {
            reason: format!("the output `{}` is not of the size that the model declares", self.name),
        }
    }
}

/// Size of the largest model, in bytes: what protobuf, in which models are written, allows.
const MAX_BYTES: u64 = 2 << 30;

/// Reads a model's file. What does not begin like one, such as a sparse file of zeros, is not read further.
fn read(path: &Path) -> Result<Vec<u8>, BodyError> {
    let unreadable = |reason| BodyError::Read { path: path.into(), reason };
    let (mut file, size) = body_file::open(path, MAX_BYTES)?;
    let mut first = [0];
    let begins = file.read(&mut first).map_err(unreadable)?;
    if begins == 0 || !wire::begins(first[0]) {
        return Err(BodyError::Model { path: path.into(), reason: wire::NO_MODEL.into() });
    }
    file.rewind().and_then(|()| body_file::read(file, size)).map_err(unreadable)
}

/// Runs a loaded network once, on zeros, so that what it gets wrong comes out before real time starts.
fn tried(path: &Path, network: Box<dyn Network>) -> Result<Box<dyn Network>, BodyError> {
    let mut body = Inference::new(&*network)?;
    match on_lane(|| body.run(&Call::default()))? {
        Ok(()) => Ok(network),
        Err(BodyError::Inference { reason }) => Err(BodyError::Model { path: path.into(), reason }),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests;
