//! The CUDA driver, loaded at run time: device, streams, events, modules, graphs and memory, one type per file.
//!
//! Nothing of CUDA is needed to build, and a machine without a driver answers [`LoadError::NoLibrary`]. One binary serves
//! drivers from CUDA 10.2 (JetPack 4) on. The calls are those of `include/red_cuda.h`, a small library in C that other
//! languages may use as well; `result` and `sys` are its Rust side, and the only unsafe code here.
//!
//! # Contexts
//!
//! All of it works in the device's primary context, the one that the CUDA runtime uses too, so streams can be given to
//! PyTorch, TensorRT or cuDNN. A thread calls [`Device::enter`] before anything else.
//!
//! # What is trusted
//!
//! A kernel may write wherever the process may. Whoever loads a module ([`Module::load`]) vouches for its kernels and for
//! the arguments that they are given, as with any other code that is loaded.
//!
//! ```
//! use red_cuda::{Device, Driver, LoadError};
//! match Driver::load() {
//!     Ok(driver) if driver.devices()? > 0 => {
//!         let device = Device::open(driver, 0)?;
//!         let stream = device.stream(device.priorities()?.most_urgent)?;
//!         let done = device.event()?;
//!         stream.record(&done)?;
//!         while !done.is_done()? {}
//!     }
//!     Ok(_) | Err(LoadError::NoLibrary(_)) => println!("no GPU here"),
//!     Err(other) => println!("{other}"),
//! }
//! # Ok::<(), red_cuda::CudaError>(())
//! ```
#![deny(unsafe_code)]

mod device;
mod driver;
mod error;
mod event;
mod graph;
mod memory;
mod module;
mod nvml;
mod result;
mod stream;
mod sys;

pub use device::{Device, Priorities};
pub use driver::{Driver, LoadError, OLDEST};
pub use error::{CudaError, Kind};
pub use event::{Event, TimedEvent};
pub use graph::Graph;
pub use memory::{Buffer, Pinned};
pub use module::{Arguments, Kernel, Module, ModuleError};
pub use nvml::{Nvml, NvmlError};
pub use result::Called;
pub use stream::Stream;
