//! Lanes that are streams of a CUDA device.
//!
//! *Rule.* A unit is submitted to its lane's stream, and then a mark. What it waits for on other streams of the device it
//! waits for by their marks (`cuStreamWaitEvent`), as far as an earlier wait does not imply it ([`order`]); on its own
//! stream the order is enough. No thread waits for another, and none waits in the driver: the lane looks at the mark for
//! a while and then sleeps until a thread of the driver's rings.
//! *Faults.* An error that spoils the context is kept as the device's ([`Cuda::lost`]), and nothing is submitted any more.
//!
//! All of the lanes' streams have the most urgent priority: the order among them is the scheduler's, and other work of the
//! process, of PyTorch's own streams say, comes after.

mod handlers;
mod lane;
pub mod order;

pub use order::LANES;

use crate::handler::Handler;
use crate::stream_seat::StreamSeat;
use core::sync::atomic::{AtomicU64, Ordering};
use order::Order;
use red_cuda::{Called, Driver, Event, Kind, LoadError};
use std::fmt;
use std::sync::{Arc, OnceLock};

pub use handlers::Handlers;
pub use lane::{Bodies, NotSubmitted};
pub use red_cuda::{CudaError, Device, Stream};

/// A device whose streams are lanes.
#[derive(Clone, Debug)]
pub struct Cuda(Arc<Shared>);

#[derive(Debug)]
pub(crate) struct Shared {
    device: Device,
    order: Order<Event>,
    /// The error that ended the context.
    lost: OnceLock<CudaError>,
    /// Bytes of the device that were free when the lanes began.
    free_bytes: OnceLock<usize>,
    issued: AtomicU64,
    avoided: AtomicU64,
}

/// What the lanes of a device did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CudaFigures {
    /// Waits of a stream for an event of another.
    pub event_waits_issued: u64,
    /// Predecessors that a unit did not need to wait for by an event: its stream's order or an earlier wait implied it.
    pub event_waits_avoided: u64,
    /// Bytes of the device's memory that were taken for buffers, at their highest.
    pub device_memory_bytes: u64,
    /// Buffers, streams, events, modules and graphs that were made after the start: the device may have waited for them.
    pub late_allocations: u64,
    /// How much less of the device's memory is free than when the lanes began; other processes and what bodies took.
    pub late_memory_bytes: u64,
}

/// There are no CUDA lanes on this machine.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum CudaUnavailable {
    /// No driver that will do.
    Driver(LoadError),
    /// The driver refuses the device, or streams or events of it.
    Device(CudaError),
}

impl fmt::Display for CudaUnavailable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Driver(error) => error.fmt(f),
            Self::Device(error) if error.kind() == Kind::OutOfMemory => {
                write!(
                    f,
                    "the CUDA device has too little memory left: {error}; use fewer lanes, or end what else uses it"
                )
            }
            Self::Device(error) => write!(f, "the CUDA device does not work: {error}; look at `nvidia-smi`"),
        }
    }
}

impl std::error::Error for CudaUnavailable {}

impl From<CudaError> for CudaUnavailable {
    fn from(error: CudaError) -> Self {
        Self::Device(error)
    }
}

/// Loads the driver and opens a device by its number from 0. Not for real time.
///
/// # Errors
/// [`CudaUnavailable`].
pub fn open(ordinal: i32) -> Result<Device, CudaUnavailable> {
    let driver = Driver::load().map_err(CudaUnavailable::Driver)?;
    Ok(Device::open(driver, ordinal)?)
}

impl Cuda {
    /// For these lanes of a run, a bit each. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn new(device: Device, lanes: u32) -> Result<Self, CudaError> {
        let order = Order::new(lanes, || device.event())?;
        let (issued, avoided) = (AtomicU64::new(0), AtomicU64::new(0));
        let (lost, free_bytes) = (OnceLock::new(), OnceLock::new());
        Ok(Self(Arc::new(Shared { device, order, lost, free_bytes, issued, avoided })))
    }

    /// The device: for what bodies need.
    #[must_use]
    pub fn device(&self) -> &Device {
        &self.0.device
    }

    /// A stream for bodies that warm up before there are lanes, as those of the lanes are.
    ///
    /// # Errors
    /// The driver's.
    pub fn stream(&self) -> Result<Stream, CudaError> {
        self.0.device.stream(self.0.device.priorities()?.most_urgent)
    }

    /// The handlers of lanes, each with its own stream. Not for real time.
    ///
    /// # Errors
    /// The driver's.
    pub fn handlers(
        &self,
        bodies: impl Iterator<Item = (usize, Box<dyn Bodies>)>,
    ) -> Result<Handlers, CudaError> {
        let handler = |(lane, bodies)| {
            let (stream, calls) = (self.stream()?, self.stream()?);
            let on_device = lane::OnDevice::new(self.0.clone(), lane, stream, calls, bodies);
            Ok((lane, Box::new(on_device) as Box<dyn Handler>))
        };
        bodies.map(handler).collect::<Result<_, _>>().map(Handlers::new)
    }

    /// The error that ended the context, if one did: nothing works on the device any more in this process.
    #[must_use]
    pub fn lost(&self) -> Option<CudaError> {
        self.0.lost.get().copied()
    }

    fn late_memory_bytes(&self) -> Option<u64> {
        let before = *self.0.free_bytes.get()?;
        self.0.device.enter().ok()?;
        let (now, _) = self.0.device.memory().ok()?;
        Some(before.saturating_sub(now) as u64)
    }

    /// What its lanes did, after the run.
    #[must_use]
    pub fn figures(&self) -> CudaFigures {
        CudaFigures {
            event_waits_issued: self.0.issued.load(Ordering::Relaxed),
            event_waits_avoided: self.0.avoided.load(Ordering::Relaxed),
            device_memory_bytes: self.0.device.highest_bytes(),
            late_allocations: self.0.device.late(),
            late_memory_bytes: self.late_memory_bytes().unwrap_or(0),
        }
    }
}

impl Called for StreamSeat {
    fn called(&self) {
        self.bell.ring();
    }
}
