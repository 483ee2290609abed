//! A stream: what is submitted to it runs in that order.

use crate::error::CudaError;
use crate::result::{self, Arguments as Raw, Called};
use crate::{Arguments, Buffer, Device, Event, Graph, Kernel, Pinned, TimedEvent};
use core::ffi::c_void;
use std::sync::Arc;

/// A stream of a device. It waits for no other one unless it is told to ([`Stream::wait_for`]).
///
/// *Time bound.* Its calls submit and return: a few microseconds each, unless the driver's queue is full or something
/// is used for the first time. Errors of kernels come out of later calls, of any stream.
#[derive(Debug)]
pub struct Stream {
    handle: result::Stream,
    device: Device,
}

impl Stream {
    pub(crate) fn new(device: Device, priority: i32) -> Result<Self, CudaError> {
        Ok(Self { handle: result::stream_create(priority)?, device })
    }

    /// Its device.
    #[must_use]
    pub const fn device(&self) -> &Device {
        &self.device
    }

    /// The stream as C has it, `CUstream` or `cudaStream_t`: for libraries that submit to it. It lives as long as this.
    #[must_use]
    pub fn as_ptr(&self) -> *mut c_void {
        result::stream_as_ptr(&self.handle)
    }

    /// Runs a kernel.
    ///
    /// # Errors
    /// The driver's.
    pub fn launch(&self, kernel: &Kernel, arguments: &mut Arguments) -> Result<(), CudaError> {
        let raw: &mut Raw = &mut arguments.0;
        result::launch(kernel.function(), kernel.grid, kernel.block, &self.handle, raw)
    }

    /// Runs a graph.
    ///
    /// # Errors
    /// The driver's.
    pub fn launch_graph(&self, graph: &Graph) -> Result<(), CudaError> {
        result::graph_launch(graph.handle(), &self.handle)
    }

    /// Notes that all that was submitted so far is done.
    ///
    /// # Errors
    /// The driver's.
    pub fn record(&self, event: &Event) -> Result<(), CudaError> {
        result::event_record(event.handle(), &self.handle)
    }

    /// Notes when that is.
    ///
    /// # Errors
    /// The driver's.
    pub fn record_time(&self, event: &TimedEvent) -> Result<(), CudaError> {
        result::event_record(event.handle(), &self.handle)
    }

    /// What is submitted from now on starts after what `event` recorded last. No thread waits.
    ///
    /// # Errors
    /// The driver's.
    pub fn wait_for(&self, event: &Event) -> Result<(), CudaError> {
        result::stream_wait(&self.handle, event.handle())
    }

    /// Calls it once, on a thread of the driver's, when the stream comes to that; what is submitted afterwards waits for it.
    ///
    /// # Errors
    /// The driver's.
    pub fn call<T: Called>(&self, called: Arc<T>) -> Result<(), CudaError> {
        result::stream_call(&self.handle, called)
    }

    /// Copies to the device, as much as both have. Both have to live until the stream has done it.
    ///
    /// # Errors
    /// The driver's.
    pub fn upload(&self, from: &Pinned, to: &Buffer) -> Result<(), CudaError> {
        result::memory::copy_to_device(to.memory(), from.memory(), &self.handle)
    }

    /// Copies to the host, as much as both have. Both have to live until the stream has done it.
    ///
    /// # Errors
    /// The driver's.
    pub fn download(&self, from: &Buffer, to: &mut Pinned) -> Result<(), CudaError> {
        result::memory::copy_to_host(to.memory_mut(), from.memory(), &self.handle)
    }

    /// Sets all bytes to zero.
    ///
    /// # Errors
    /// The driver's.
    pub fn clear(&self, buffer: &Buffer) -> Result<(), CudaError> {
        result::memory::memory_clear(buffer.memory(), &self.handle)
    }

    /// Makes a graph of what `submit` submits to this stream, without running it. Not for real time.
    ///
    /// # Errors
    /// The driver's, also where something was submitted that cannot be captured; or that of `submit`.
    pub fn capture<E: From<CudaError>>(
        &self,
        submit: impl FnOnce(&Self) -> Result<(), E>,
    ) -> Result<Graph, E> {
        result::stream_begin_capture(&self.handle)?;
        let submitted = submit(self);
        // In either case, or the stream would capture for ever.
        let captured = result::stream_end_capture(&self.handle);
        submitted?;
        Ok(Graph::new(self.device.clone(), captured?)?)
    }
}
