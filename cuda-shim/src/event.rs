//! Events: marks in a stream.

use crate::error::CudaError;
use crate::{Device, result};
use std::time::Duration;

/// A mark in a stream that orders others behind it and tells when it was reached.
#[derive(Debug)]
pub struct Event {
    handle: result::Event,
    _device: Device,
}

impl Event {
    pub(crate) fn new(device: Device) -> Result<Self, CudaError> {
        Ok(Self { handle: result::event_create(false)?, _device: device })
    }

    /// Whether what was recorded last is done; so is what was never recorded.
    ///
    /// *Time bound.* One call of the driver, about a microsecond.
    ///
    /// # Errors
    /// The driver's, also of kernels before the mark.
    pub fn is_done(&self) -> Result<bool, CudaError> {
        result::event_query(&self.handle)
    }

    pub(crate) const fn handle(&self) -> &result::Event {
        &self.handle
    }
}

/// A mark in a stream that knows when it was reached.
#[derive(Debug)]
pub struct TimedEvent(Event);

impl TimedEvent {
    pub(crate) fn new(device: Device) -> Result<Self, CudaError> {
        Ok(Self(Event { handle: result::event_create(true)?, _device: device }))
    }

    /// As [`Event::is_done`].
    ///
    /// # Errors
    /// As there.
    pub fn is_done(&self) -> Result<bool, CudaError> {
        self.0.is_done()
    }

    /// How long after `earlier` it was reached, to half a microsecond; zero where it was not after it.
    ///
    /// # Errors
    /// The driver's: not ready, where one of them is not reached yet.
    pub fn since(&self, earlier: &Self) -> Result<Duration, CudaError> {
        let milliseconds = result::event_elapsed(earlier.handle(), self.handle())?;
        Ok(Duration::try_from_secs_f32(milliseconds / 1e3).unwrap_or_default())
    }

    pub(crate) const fn handle(&self) -> &result::Event {
        self.0.handle()
    }
}
