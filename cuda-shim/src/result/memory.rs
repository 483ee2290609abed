//! Memory of device and host, and copies between them.
#![allow(unsafe_code, reason = "calls of C, and memory that it gives")]

use super::{Result, Stream, done, handle, is_left, made};
use crate::sys;
use core::ptr::NonNull;

/// Bytes of the device's memory: free, total.
pub(crate) fn memory_info() -> Result<(usize, usize)> {
    let mut total = 0;
    // SAFETY: both places are live.
    let free = |out| unsafe { sys::red_cuda_memory_info(out, &raw mut total) };
    Ok((made("cuMemGetInfo", free)?, total))
}

/// The device's memory: where it is and how long.
#[derive(Debug)]
pub(crate) struct DeviceMemory {
    pub(crate) address: u64,
    pub(crate) bytes: usize,
}

impl Drop for DeviceMemory {
    fn drop(&mut self) {
        if !is_left() {
            // SAFETY: live memory, which ends here; kernels that use it still are the driver's to wait for.
            let _unheard = unsafe { sys::red_cuda_memory_free(self.address) };
        }
    }
}

pub(crate) fn memory_allocate(bytes: usize) -> Result<DeviceMemory> {
    // SAFETY: the place is live.
    let address = made("cuMemAlloc", |out| unsafe { sys::red_cuda_memory_allocate(bytes, out) })?;
    Ok(DeviceMemory { address, bytes })
}

pub(crate) fn memory_clear(memory: &DeviceMemory, stream: &Stream) -> Result<()> {
    let DeviceMemory { address, bytes } = *memory;
    // SAFETY: live memory of this length, and a live handle.
    done("cuMemsetD8Async", unsafe { sys::red_cuda_memory_set(address, 0, bytes, stream.0.as_ptr()) })
}

/// Pinned memory of the host, of bytes that are always set.
#[derive(Debug)]
pub(crate) struct HostMemory {
    address: NonNull<u8>,
    bytes: usize,
}

impl Drop for HostMemory {
    fn drop(&mut self) {
        if !is_left() {
            // SAFETY: live memory, which ends here; copies that use it still are the driver's to wait for.
            let _unheard = unsafe { sys::red_cuda_host_free(self.address.as_ptr().cast()) };
        }
    }
}

// SAFETY: it is memory, and belongs to who has it.
unsafe impl Send for HostMemory {}
// SAFETY: shared, it is only read.
unsafe impl Sync for HostMemory {}

impl HostMemory {
    pub(crate) fn bytes(&self) -> &[u8] {
        // SAFETY: allocated of this length, and set at first.
        unsafe { core::slice::from_raw_parts(self.address.as_ptr(), self.bytes) }
    }

    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: allocated of this length, and set at first.
        unsafe { core::slice::from_raw_parts_mut(self.address.as_ptr(), self.bytes) }
    }
}

pub(crate) fn host_allocate(bytes: usize) -> Result<HostMemory> {
    // SAFETY: the place is live.
    let allocate = |out| unsafe { sys::red_cuda_host_allocate(bytes, out) };
    let address = handle("cuMemHostAlloc", allocate)?.cast::<u8>();
    // SAFETY: allocated of this length.
    unsafe { address.as_ptr().write_bytes(0, bytes) };
    Ok(HostMemory { address, bytes })
}

/// Copies as much as both have; neither may end before the stream has done it.
pub(crate) fn copy_to_device(to: &DeviceMemory, from: &HostMemory, stream: &Stream) -> Result<()> {
    let (bytes, from) = (to.bytes.min(from.bytes), from.address.as_ptr().cast());
    // SAFETY: live memory of at least this length, and a live handle; the caller keeps it.
    let code = unsafe { sys::red_cuda_copy_to_device(to.address, from, bytes, stream.0.as_ptr()) };
    done("cuMemcpyHtoDAsync", code)
}

/// Copies as much as both have; neither may end before the stream has done it.
pub(crate) fn copy_to_host(to: &mut HostMemory, from: &DeviceMemory, stream: &Stream) -> Result<()> {
    let (bytes, to) = (from.bytes.min(to.bytes), to.address.as_ptr().cast());
    // SAFETY: live memory of at least this length, and a live handle; the caller keeps it.
    let code = unsafe { sys::red_cuda_copy_to_host(to, from.address, bytes, stream.0.as_ptr()) };
    done("cuMemcpyDtoHAsync", code)
}
