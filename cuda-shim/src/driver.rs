//! The driver of this machine, or why there is none.

use crate::error::CudaError;
use crate::{result, sys};
use std::fmt;
use std::sync::{Mutex, PoisonError};

/// The oldest driver that will do, by the CUDA that it supports: 10.2, of JetPack 4.
pub const OLDEST: i32 = 10_020;

/// The driver, loaded and initialised. It stays so until the process ends.
#[derive(Clone, Copy, Debug)]
pub struct Driver {
    version: i32,
}

/// There is no driver to work with.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum LoadError {
    /// `libcuda.so.1` does not open: the loader's words. Nobody erred, or it is not installed.
    NoLibrary(String),
    /// It lacks these entry points: something else has its name.
    NoEntry(String),
    /// It supports CUDA up to this version only, as in [`Driver::version`]. Install a newer one.
    TooOld(i32),
    /// It is there and does not work, such as without a device.
    Failed(CudaError),
}

impl fmt::Display for LoadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoLibrary(words) => write!(
                f,
                "no CUDA driver: {words}; install the driver's user libraries (libcuda1), or add their folder to LD_LIBRARY_PATH"
            ),
            Self::NoEntry(names) => {
                write!(f, "the CUDA driver lacks {names}; install NVIDIA's driver, of CUDA 10.2 or later")
            }
            Self::TooOld(version) => write!(
                f,
                "the CUDA driver supports CUDA {}.{}; install one of CUDA 10.2 or later",
                version / 1000,
                version % 1000 / 10
            ),
            Self::Failed(error) => write!(
                f,
                "the CUDA driver does not work: {error}; look whether `nvidia-smi` sees a GPU, and in a container for \
                 `docker run --gpus all` (Jetson: `--runtime nvidia`)"
            ),
        }
    }
}

impl std::error::Error for LoadError {}

impl Driver {
    /// Loads and initialises the driver: milliseconds, and not for real time. Once it has succeeded it is quick.
    ///
    /// # Errors
    /// [`LoadError`]; it can be tried again.
    pub fn load() -> Result<Self, LoadError> {
        static LOADING: Mutex<()> = Mutex::new(());
        let _alone = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
        result::load().map_err(|(status, words)| match status {
            sys::NO_LIBRARY => LoadError::NoLibrary(words),
            _ => LoadError::NoEntry(words),
        })?;
        let version = result::driver_version().map_err(LoadError::Failed)?;
        if version < OLDEST {
            return Err(LoadError::TooOld(version));
        }
        result::init().map_err(LoadError::Failed)?;
        Ok(Self { version })
    }

    /// The newest CUDA that it supports: 1000 times the major and 10 times the minor version.
    #[must_use]
    pub const fn version(self) -> i32 {
        self.version
    }

    /// How many devices there are.
    ///
    /// # Errors
    /// The driver's.
    pub fn devices(self) -> Result<i32, CudaError> {
        result::device_count()
    }
}
