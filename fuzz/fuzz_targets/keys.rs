#![allow(unsafe_code, reason = "a name of C's library")]
//! Hash tables with the same order in every process: which code an input reaches, and so what a seed leads to, is not for
//! the system's random numbers to say.

use std::ffi::{c_uint, c_void};

/// In the place of the system's own, of which the standard library has the keys of its hash tables.
///
/// # Safety
/// `to` has room for so many bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn getrandom(to: *mut c_void, bytes: usize, _flags: c_uint) -> isize {
    // SAFETY: the caller's word.
    unsafe { to.cast::<u8>().write_bytes(0x5A, bytes) };
    bytes.cast_signed()
}
