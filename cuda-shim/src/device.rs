//! A device and its primary context.

use crate::error::CudaError;
use crate::{Buffer, Driver, Event, Module, ModuleError, Pinned, Stream, TimedEvent, result};
use std::sync::Arc;

/// A GPU, with its primary context retained as long as anything of it lives.
#[derive(Clone, Debug)]
pub struct Device(Arc<Retained>);

#[derive(Debug)]
struct Retained {
    number: i32,
    context: result::Context,
    name: String,
}

/// Priorities that the device's streams may have. A smaller number is more urgent; with one priority only both are 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Priorities {
    /// The number of the most urgent.
    pub most_urgent: i32,
    /// The number of the least urgent.
    pub least_urgent: i32,
}

impl Device {
    /// Opens a device by its number from 0, and enters its context: hundreds of milliseconds, not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn open(_: Driver, ordinal: i32) -> Result<Self, CudaError> {
        let number = result::device_get(ordinal)?;
        let name = result::device_name(number)?;
        let device = Self(Arc::new(Retained { number, context: result::context_retain(number)?, name }));
        device.enter()?;
        Ok(device)
    }

    /// Makes its context the calling thread's. Each thread that calls anything else does so first.
    ///
    /// # Errors
    /// The driver's.
    pub fn enter(&self) -> Result<(), CudaError> {
        result::context_enter(&self.0.context)
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// Where it is, as domain:bus:device.function.
    ///
    /// # Errors
    /// The driver's.
    pub fn bus_id(&self) -> Result<String, CudaError> {
        result::device_bus_id(self.0.number)
    }

    /// Its compute capability: major, minor.
    ///
    /// # Errors
    /// The driver's.
    pub fn capability(&self) -> Result<(i32, i32), CudaError> {
        /// `CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR`, and after it minor.
        const MAJOR: u32 = 75;
        Ok((
            result::device_attribute(self.0.number, MAJOR)?,
            result::device_attribute(self.0.number, MAJOR + 1)?,
        ))
    }

    /// Bytes of its memory, of all processes together: free, total. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn memory(&self) -> Result<(usize, usize), CudaError> {
        result::memory::memory_info()
    }

    /// Waits until all that was submitted in its context is done, by whomever. Not for real time.
    ///
    /// # Errors
    /// The driver's, also of what went wrong meanwhile.
    pub fn synchronize(&self) -> Result<(), CudaError> {
        result::context_synchronize()
    }

    /// Priorities of its streams.
    ///
    /// # Errors
    /// The driver's.
    pub fn priorities(&self) -> Result<Priorities, CudaError> {
        let (least_urgent, most_urgent) = result::context_priorities()?;
        Ok(Priorities { most_urgent, least_urgent })
    }

    /// A stream of this priority; the nearest there is. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn stream(&self, priority: i32) -> Result<Stream, CudaError> {
        Stream::new(self.clone(), priority)
    }

    /// An event that orders streams and tells when something is done. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn event(&self) -> Result<Event, CudaError> {
        Event::new(self.clone())
    }

    /// An event that knows when it was. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn timed_event(&self) -> Result<TimedEvent, CudaError> {
        TimedEvent::new(self.clone())
    }

    /// Loads kernels. Not for real time.
    ///
    /// # Errors
    /// As [`Module::load`].
    pub fn module(&self, image: &[u8]) -> Result<Module, ModuleError> {
        Module::load(self.clone(), image)
    }

    /// Memory of the device. Not for real time: the driver may wait for all streams.
    ///
    /// # Errors
    /// [`Kind::OutOfMemory`](crate::Kind::OutOfMemory), or another of the driver's.
    pub fn buffer(&self, bytes: usize) -> Result<Buffer, CudaError> {
        Buffer::new(self.clone(), bytes)
    }

    /// Pinned memory of the host, zeroed. Not for real time.
    ///
    /// # Errors
    /// [`Kind::OutOfMemory`](crate::Kind::OutOfMemory), or another of the driver's.
    pub fn pinned(&self, bytes: usize) -> Result<Pinned, CudaError> {
        Pinned::new(self.clone(), bytes)
    }
}
