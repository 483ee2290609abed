//! What the driver answers when it does not do what was asked, and what that means for the caller.

use crate::result;
use std::fmt;

/// A call of the driver failed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct CudaError {
    pub(crate) call: &'static str,
    pub(crate) code: i32,
}

/// What to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Kind {
    /// No memory on the device, or no more pinned memory: nobody erred but the budget. Free some, or ask for less; the
    /// context goes on.
    OutOfMemory,
    /// A kernel did what none may, ran into the launch timeout or met an error of the hardware. The context is spent:
    /// each later call in it fails, and only another process gets a sound one. Never try again in it.
    Poisoned,
    /// The device is gone: fell off the bus, was reset, or its driver went away. As [`Kind::Poisoned`], and another
    /// process may have to wait.
    Lost,
    /// The call itself was wrong or came at a wrong time: its author erred. The context goes on.
    Refused,
}

/// `CUresult` by what it means for the context.
const OUT_OF_MEMORY: &[i32] = &[2];
/// ECC, NVLink, illegal address, launch timeout, destroyed context, assertion, and the faults of instructions and
/// addresses to launch failed.
const POISONED: &[i32] = &[214, 220, 700, 702, 709, 710, 714, 715, 716, 717, 718, 719];
/// Deinitialized, unavailable, no device, no such device, system not ready, unknown.
const LOST: &[i32] = &[4, 46, 100, 101, 802, 999];

impl CudaError {
    /// The number, as `CUresult` has it.
    #[must_use]
    pub const fn code(self) -> i32 {
        self.code
    }

    /// The call that answered it, by the name that CUDA documents it under. Errors of kernels come out of later calls.
    #[must_use]
    pub const fn call(self) -> &'static str {
        self.call
    }

    /// What to do about it.
    #[must_use]
    pub fn kind(self) -> Kind {
        let is_in = |codes: &[i32]| codes.contains(&self.code);
        match () {
            () if is_in(OUT_OF_MEMORY) => Kind::OutOfMemory,
            () if is_in(POISONED) => Kind::Poisoned,
            () if is_in(LOST) => Kind::Lost,
            () => Kind::Refused,
        }
    }

    /// Whether nothing works any more in this process on this device.
    #[must_use]
    pub fn is_sticky(self) -> bool {
        matches!(self.kind(), Kind::Poisoned | Kind::Lost)
    }
}

impl fmt::Display for CudaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, text) = result::error_words(self.code);
        write!(f, "{}: {} ({})", self.call, name.unwrap_or("an error without a name"), self.code)?;
        text.map_or(Ok(()), |text| write!(f, ": {text}"))
    }
}

impl fmt::Debug for CudaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for CudaError {}
