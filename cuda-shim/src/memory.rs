//! Memory of the device, and pinned memory of the host.

use crate::error::CudaError;
use crate::{Device, result};

/// Memory of the device. Kernels know it by its address.
#[derive(Debug)]
pub struct Buffer {
    memory: result::memory::DeviceMemory,
    device: Device,
}

impl Buffer {
    pub(crate) fn new(device: Device, bytes: usize) -> Result<Self, CudaError> {
        // None of zero bytes can be had.
        let memory = result::memory::memory_allocate(bytes.max(1))?;
        device.held().take(memory.bytes);
        Ok(Self { memory, device })
    }

    /// Where it is.
    #[must_use]
    pub const fn address(&self) -> u64 {
        self.memory.address
    }

    pub(crate) const fn memory(&self) -> &result::memory::DeviceMemory {
        &self.memory
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        self.device.held().give_back(self.memory.bytes);
    }
}

/// Pinned memory of the host: the device copies from and to it while the CPU does something else.
#[derive(Debug)]
pub struct Pinned {
    memory: result::memory::HostMemory,
    _device: Device,
}

impl Pinned {
    pub(crate) fn new(device: Device, bytes: usize) -> Result<Self, CudaError> {
        Ok(Self { memory: result::memory::host_allocate(bytes.max(1))?, _device: device })
    }

    /// What is in it: of a copy from the device, only once the stream has done that.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }

    /// What is in it. A copy to the device takes what is there when the stream comes to it.
    #[must_use]
    pub fn bytes_mut(&mut self) -> &mut [u8] {
        self.memory.bytes_mut()
    }

    /// Where it is, for the host and for kernels alike: every device of a 64-bit system has one address space with it.
    #[must_use]
    pub fn address(&self) -> u64 {
        self.memory.bytes().as_ptr() as u64
    }

    pub(crate) const fn memory(&self) -> &result::memory::HostMemory {
        &self.memory
    }

    pub(crate) const fn memory_mut(&mut self) -> &mut result::memory::HostMemory {
        &mut self.memory
    }
}
