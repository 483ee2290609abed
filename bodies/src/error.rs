//! Why a body could not be made, or failed.

use std::error::Error;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

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
    /// A model or a shared object is a directory, a FIFO, a device or a socket.
    NotAFile {
        /// The file.
        path: PathBuf,
    },
    /// A model or a shared object has more bytes than one may have.
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Bytes that it may have.
        most: u64,
    },
    /// A path leads out of the folder that it has to stay in.
    Outside {
        /// The path.
        path: PathBuf,
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

impl BodyError {
    /// What is wrong and what would be right, in one line, with foreign text and paths as the caller shows these.
    #[must_use]
    pub fn told(&self, text: fn(&str) -> String, path: fn(&Path) -> String) -> String {
        let shown = path;
        match self {
            Self::Read { path, reason } => format!(
                "cannot read `{}`: {reason}; expected a file in the folder of the workload file or below",
                shown(path)
            ),
            Self::NotAFile { path } => format!(
                "`{}` is a directory, a FIFO, a device or a socket; expected a regular file",
                shown(path)
            ),
            Self::TooLarge { path, most } => {
                format!("`{}` is too large; expected at most {} GiB", shown(path), most >> 30)
            }
            Self::Outside { path } => format!(
                "`{}` leads out of the folder of the workload file; expected a file in it or below, also through links",
                shown(path)
            ),
            Self::Model { path, reason } => format!(
                "the model `{}` does not load: {}; expected ONNX with operators of opset 13 to 21",
                shown(path),
                text(reason)
            ),
            Self::Port { path, port, reason } => format!(
                "the tensor `{}` of the model `{}` {reason}; expected 32-bit floats and fixed sizes",
                text(port),
                shown(path)
            ),
            Self::Library { path, reason } => format!(
                "onnxruntime does not load from `{}`: {}; expected a libonnxruntime.so of version 1.22 or newer",
                shown(path),
                text(reason)
            ),
            Self::Thread => {
                "the system starts no more threads; raise `ulimit -u` or use fewer lanes".to_owned()
            }
            Self::Plugin { path, reason } => format!(
                "the plugin `{}` does not load: {}; expected what `cc -shared -fPIC` builds for this machine",
                shown(path),
                text(reason)
            ),
            Self::Symbol { path, symbol } => format!(
                "the plugin `{}` has no function `{}`; expected one as red_plugin.h declares it, in C++ extern \"C\"",
                shown(path),
                text(symbol)
            ),
            Self::Open { path, symbol, code } => format!(
                "`{}` of the plugin `{}` returned {code}; expected 0: see the plugin's own documentation",
                text(symbol),
                shown(path)
            ),
            Self::Buffer { buffer, expected, found } => format!(
                "the {buffer} buffer holds {found} values, not {expected}; size it by the network's ports"
            ),
            Self::NotOnLane => {
                "a network ran outside a lane; start the thread's work through onnx::on_lane".to_owned()
            }
            Self::Inference { reason } => {
                format!("the inference failed: {}; check the model with another engine", text(reason))
            }
            Self::Returned { code } => format!(
                "the plugin's step function returned {code}; 0 means done, see the plugin's own documentation"
            ),
        }
    }
}

/// Foreign text is escaped, and as long as it is: who prints to people cuts it, by [`BodyError::told`].
impl fmt::Display for BodyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let escaped = |text: &str| text.escape_debug().to_string();
        f.write_str(&self.told(escaped, |path| path.to_string_lossy().escape_debug().to_string()))
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
