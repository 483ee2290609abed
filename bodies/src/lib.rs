//! What a node executes: it burns CPU, runs an ONNX network, or calls a C function of a shared object.
//!
//! Every body is made before real time starts: files are read, networks loaded, symbols looked up. What a lane then
//! calls is [`Body::run`], or [`onnx::Instance::run`] where the host owns the tensors of a frame.
//!
//! A node may run for two jobs at once on two lanes, so each (node, lane) has an instance of its own, and no lock of
//! ours lies between them.
//!
//! | module | body |
//! |---|---|
//! | [`spin`] | uses up CPU time of its thread |
//! | [`onnx`] | inference: the engines, and the threads on which they compute in place |
//! | [`plugin`] | a C function, declared in `include/red_plugin.h` |
//! | [`scene`] | not a body: the road frames that stand in for a camera |

mod body;
mod body_file;
mod clock;
mod error;
pub mod onnx;
pub mod plugin;
pub mod scene;
pub mod spin;

/// PTX of a kernel `red_spin` that keeps a CUDA device busy for as many nanoseconds as its one argument says.
pub const SPIN_PTX: &str = include_str!("../kernels/spin.ptx");

pub use body::{Body, Call};
pub use body_file::{contents, within};
pub use error::BodyError;
