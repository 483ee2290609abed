//! Why a body could not be made, or failed.

use std::error::Error;
use std::fmt;
use std::io;
use std::path::PathBuf;

/// Why a body could not be made, or failed in a call.
///
/// Each message names the place and what to do about it. Only [`Self::Buffer`], [`Self::NotOnLane`],
/// [`Self::Inference`] and [`Self::Returned`] come out of a running body; of these only `Inference` holds memory.
#[derive(Debug)]
#[non_exhaustive]
pub enum BodyError {
    /// A model or a shared object cannot be read.
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: io::Error,
    },
    /// The engine does not accept a model.
    Model {
        /// The model file.
        path: PathBuf,
        /// What the engine said.
        reason: String,
    },
    /// An input or output of a model cannot be served from a buffer of `f32`.
    Port {
        /// The model file.
        path: PathBuf,
        /// Name of the input or output.
        port: String,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The onnxruntime library cannot be used.
    Library {
        /// The shared library.
        path: PathBuf,
        /// What the loader or the library said.
        reason: String,
    },
    /// No thread could be started for a lane.
    Thread,
    /// A plugin's shared object does not load.
    Plugin {
        /// The shared object.
        path: PathBuf,
        /// What the dynamic linker said.
        reason: String,
    },
    /// A plugin lacks its step function.
    Symbol {
        /// The shared object.
        path: PathBuf,
        /// The function looked for.
        symbol: String,
    },
    /// A plugin's `_open` function refused.
    Open {
        /// The shared object.
        path: PathBuf,
        /// The function that refused.
        symbol: String,
        /// What it returned.
        code: i32,
    },
    /// A caller passed a buffer of the wrong length.
    Buffer {
        /// Which buffer.
        buffer: &'static str,
        /// Number of values that it must hold.
        expected: usize,
        /// Number of values that it holds.
        found: usize,
    },
    /// A network was run by a thread that is not inside [`crate::onnx::on_lane`].
    NotOnLane,
    /// The engine gave up in the middle of an inference.
    Inference {
        /// What the engine said.
        reason: String,
    },
    /// A plugin's step function reported a failure.
    Returned {
        /// What it returned, never 0.
        code: i32,
    },
}

impl BodyError {
    /// Refuses a caller's buffer of the wrong length.
    pub(crate) const fn check_len(buffer: &'static str, expected: usize, found: usize) -> Result<(), Self> {
        if expected == found { Ok(()) } else { Err(Self::Buffer { buffer, expected, found }) }
    }
}

impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, reason } => {
                write!(f, "cannot read {path:?}: {reason}; paths of bodies are relative to the workload file")
            }
            Self::Model { path, reason } => {
                write!(
                    f,
                    "the model {path:?} does not load: {reason}; export it as ONNX with operators of opset 13 to 21"
                )
            }
            Self::Port { path, port, reason } => {
                write!(
                    f,
                    "the tensor {port:?} of the model {path:?} {reason}; export the model with 32-bit floats and fixed sizes"
                )
            }
            Self::Library { path, reason } => {
                write!(
                    f,
                    "onnxruntime does not load from {path:?}: {reason}; name a libonnxruntime.so of version 1.22 or newer"
                )
            }
            Self::Thread => {
                f.write_str("the system starts no more threads; raise `ulimit -u` or use fewer lanes")
            }
            Self::Plugin { path, reason } => {
                write!(
                    f,
                    "the plugin {path:?} does not load: {reason}; build it with `cc -shared -fPIC` for this machine"
                )
            }
            Self::Symbol { path, symbol } => {
                write!(
                    f,
                    "the plugin {path:?} has no function {symbol:?}; declare it as in red_plugin.h, in C++ with extern \"C\""
                )
            }
            Self::Open { path, symbol, code } => {
                write!(
                    f,
                    "{symbol:?} of the plugin {path:?} returned {code}; see the plugin's own documentation"
                )
            }
            Self::Buffer { buffer, expected, found } => {
                write!(
                    f,
                    "the {buffer} buffer holds {found} values, not {expected}; size it by the network's ports"
                )
            }
            Self::NotOnLane => {
                f.write_str("a network ran outside a lane; start the thread's work through onnx::on_lane")
            }
            Self::Inference { reason } => {
                write!(f, "the inference failed: {reason}; check the model with another engine")
            }
            Self::Returned { code } => {
                write!(
                    f,
                    "the plugin's step function returned {code}; 0 means done, see the plugin's own documentation"
                )
            }
        }
    }
}

impl Error for BodyError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::Read { reason, .. } => Some(reason),
            _ => None,
        }
    }
}
