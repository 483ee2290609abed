//! The management library.
#![allow(unsafe_code, reason = "calls of C")]

use crate::nvml::NvmlError;
use crate::sys;
use core::ffi::c_void;
use core::ptr;
use std::ffi::CString;

/// A device of the management library.
#[derive(Debug)]
pub(crate) struct Device(*mut c_void);

// SAFETY: the library may be called from any thread, with any device.
unsafe impl Send for Device {}

pub(crate) fn open(bus_id: &str) -> Result<Device, NvmlError> {
    let bus_id = CString::new(bus_id).map_err(|_| NvmlError::NoLibrary)?;
    let mut device = ptr::null_mut();
    // SAFETY: a text with its NUL, and a live place.
    match unsafe { sys::red_nvml_open(bus_id.as_ptr(), &raw mut device) } {
        sys::OK => Ok(Device(device)),
        status => Err(NvmlError::of(status)),
    }
}

pub(crate) fn utilisation(device: &Device) -> Result<u32, NvmlError> {
    let mut percent = 0;
    // SAFETY: the device is the library's own, which stays loaded, and the place is live.
    match unsafe { sys::red_nvml_utilisation(device.0, &raw mut percent) } {
        sys::OK => Ok(percent),
        status => Err(NvmlError::of(status)),
    }
}
