//! Why a run cannot start.

use super::bodies::BodiesError;
use crate::denied::Denied;
use red_record::StartError;
use red_rt::cuda::CudaUnavailable;
use red_rt::setup::SetupError;
use red_workload::build::BuildError;
use std::fmt;

/// A run could not start.
#[derive(Debug)]
pub(crate) enum SessionError {
    /// The workload does not fit the executive.
    Build(BuildError),
    /// A body cannot run.
    Bodies(BodiesError),
    /// A body could not be made ready on a lane, in words.
    Instance(String),
    /// The machine lacks a right or a resource.
    Machine(Denied),
    /// The log cannot be written.
    Record(String),
    /// The system starts no thread that writes the log.
    Recorder(StartError),
    /// A pool of CUDA streams, and no CUDA device that works.
    Cuda {
        /// The pool.
        pool: String,
        /// What is missing.
        why: CudaUnavailable,
    },
    /// A pool of CUDA streams may use more of the device's memory than is free.
    DeviceMemory {
        /// The pool.
        pool: String,
        /// What it may use, what is free, and what the device has, in bytes.
        bytes: [u64; 3],
    },
}

impl SessionError {
    /// 2: the file is at fault, 3: the machine is.
    #[must_use]
    pub(crate) const fn exit_code(&self) -> u8 {
        match self {
            Self::Machine(_) | Self::Recorder(_) | Self::Cuda { .. } | Self::DeviceMemory { .. } => 3,
            Self::Bodies(error) if error.is_of_machine() => 3,
            Self::Build(_) | Self::Bodies(_) | Self::Instance(_) | Self::Record(_) => 2,
        }
    }
}

impl From<SetupError> for SessionError {
    fn from(error: SetupError) -> Self {
        Self::Machine(error.into())
    }
}

impl From<BodiesError> for SessionError {
    fn from(error: BodiesError) -> Self {
        Self::Bodies(error)
    }
}

impl fmt::Display for SessionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Build(e) => e.fmt(f),
            Self::Bodies(e) => e.fmt(f),
            Self::Instance(words) => write!(f, "a body could not be made ready {words}; nothing ran"),
            Self::Machine(e) => e.fmt(f),
            Self::Record(e) => f.write_str(e),
            Self::Recorder(e) => e.fmt(f),
            Self::DeviceMemory { pool, bytes: [budget, free, total] } => write!(
                f,
                "pool `{pool}` may use {budget} bytes of the device's memory, of which {free} are free of {total}; lower its \
                 `memory`, or end what else uses the device"
            ),
            Self::Cuda { pool, why } => write!(
                f,
                "pool `{pool}` is of kind cuda: {why}; to run it on the CPU, write kind = \"cpu\" and bodies for the CPU, \
                 such as {{ onnx = \"...\" }} or {{ spin = \"1ms\" }}"
            ),
        }
    }
}

impl std::error::Error for SessionError {}
