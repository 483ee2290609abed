//! A device and its primary context.

use crate::error::CudaError;
use crate::{Buffer, Driver, Event, Module, ModuleError, Pinned, Stream, TimedEvent, result};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A GPU, with its primary context retained as long as anything of it lives.
#[derive(Clone, Debug)]
pub struct Device(Arc<Retained>);

#[derive(Debug)]
struct Retained {
    number: i32,
    context: result::Context,
    name: String,
    held: Held,
}

/// What was taken of the device's memory through it.
#[derive(Debug, Default)]
pub(crate) struct Held {
    bytes: AtomicU64,
    highest: AtomicU64,
    /// Whether what is taken from now on is late, and how much of it there was.
    sealed: AtomicBool,
    late: AtomicU64,
}

impl Held {
    pub(crate) fn take(&self, bytes: usize) {
        let now = self.bytes.fetch_add(bytes as u64, Ordering::Relaxed) + bytes as u64;
        self.highest.fetch_max(now, Ordering::Relaxed);
    }

    pub(crate) fn give_back(&self, bytes: usize) {
        self.bytes.fetch_sub(bytes as u64, Ordering::Relaxed);
    }

    /// Something that may make the whole device wait.
    fn note(&self) {
        self.late.fetch_add(self.sealed.load(Ordering::Relaxed).into(), Ordering::Relaxed);
    }
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
        let device = Self(Arc::new(Retained {
            number,
            context: result::context_retain(number)?,
            name,
            held: Held::default(),
        }));
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

    /// Bytes that [`Device::buffer`] has given and not got back, at their highest.
    #[must_use]
    pub fn highest_bytes(&self) -> u64 {
        self.0.held.highest.load(Ordering::Relaxed)
    }

    /// From now on, memory, streams, events, modules and graphs come late: the driver may make the whole device wait for
    /// them. They are counted.
    pub fn seal(&self) {
        self.0.held.sealed.store(true, Ordering::Relaxed);
    }

    /// How many came late.
    #[must_use]
    pub fn late(&self) -> u64 {
        self.0.held.late.load(Ordering::Relaxed)
    }

    pub(crate) fn held(&self) -> &Held {
        &self.0.held
    }

    /// Leaves everything to the driver that this process has of it, of every device, until the process ends: nothing is
    /// given back any more. To be called where a stream does not come to its end, because the driver would wait for that
    /// whatever it is given back, and where the context is spent.
    pub fn leave(&self) {
        result::leave();
    }

    /// Whether everything is left to the driver.
    #[must_use]
    pub fn is_left(&self) -> bool {
        result::is_left()
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
        self.0.held.note();
        Stream::new(self.clone(), priority)
    }

    /// An event that orders streams and tells when something is done. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn event(&self) -> Result<Event, CudaError> {
        self.0.held.note();
        Event::new(self.clone())
    }

    /// An event that knows when it was. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn timed_event(&self) -> Result<TimedEvent, CudaError> {
        self.0.held.note();
        TimedEvent::new(self.clone())
    }

    /// Loads kernels. Not for real time.
    ///
    /// # Errors
    /// As [`Module::load`].
    pub fn module(&self, image: &[u8]) -> Result<Module, ModuleError> {
        self.0.held.note();
        Module::load(self.clone(), image)
    }

    /// Memory of the device. Not for real time: the driver may wait for all streams.
    ///
    /// # Errors
    /// [`Kind::OutOfMemory`](crate::Kind::OutOfMemory), or another of the driver's.
    pub fn buffer(&self, bytes: usize) -> Result<Buffer, CudaError> {
        self.0.held.note();
        Buffer::new(self.clone(), bytes)
    }

    /// Pinned memory of the host, zeroed. Not for real time.
    ///
    /// # Errors
    /// [`Kind::OutOfMemory`](crate::Kind::OutOfMemory), or another of the driver's.
    pub fn pinned(&self, bytes: usize) -> Result<Pinned, CudaError> {
        self.0.held.note();
        Pinned::new(self.clone(), bytes)
    }
}
