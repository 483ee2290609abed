//! How busy a device is, whoever keeps it so, as NVIDIA's management library says.

use crate::Device;
use crate::result::nvml;
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// A device, as the management library knows it. The library is loaded at run time; a Jetson has none.
#[derive(Debug)]
pub struct Nvml(nvml::Device);

/// The management library does not say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum NvmlError {
    /// There is no `libnvidia-ml.so.1`, or it lacks what is needed.
    NoLibrary,
    /// It refuses, with this number of its own: `nvmlReturn_t`.
    Refused(i32),
}

impl fmt::Display for NvmlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLibrary => f.write_str("no libnvidia-ml.so.1; install the driver's management library"),
            Self::Refused(error) => write!(f, "NVML error {error}; look at `nvidia-smi`"),
        }
    }
}

impl std::error::Error for NvmlError {}

impl NvmlError {
    pub(crate) const fn of(status: i32) -> Self {
        if status < 0 { Self::NoLibrary } else { Self::Refused(status) }
    }
}

impl Nvml {
    /// Loads the library and finds the device. Not for real time.
    ///
    /// # Errors
    /// [`NvmlError`].
    pub fn open(device: &Device) -> Result<Self, NvmlError> {
        static LOADING: Mutex<()> = Mutex::new(());
        let _alone = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
        let bus_id = device.bus_id().map_err(|_| NvmlError::NoLibrary)?;
        nvml::open(&bus_id).map(Self)
    }

    /// Percent of its last sampling period, of up to a second, in which a kernel ran.
    ///
    /// *Time bound.* About a millisecond, of the library.
    ///
    /// # Errors
    /// [`NvmlError::Refused`].
    pub fn utilisation_percent(&self) -> Result<u32, NvmlError> {
        nvml::utilisation(&self.0)
    }
}
