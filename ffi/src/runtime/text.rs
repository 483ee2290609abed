#![allow(unsafe_code, reason = "text that C gives")]
//! Text from C, and for it.

use crate::status::red_status;
use core::ffi::c_char;

/// Longest text that is looked at, the byte that ends it included.
const LONGEST: usize = 4096;

/// A text that C gives: UTF-8, not empty, ended within [`LONGEST`] bytes. Nothing behind its end is read.
pub(crate) fn take(from: *const c_char) -> Result<String, red_status> {
    if from.is_null() {
        return Err(red_status::NullPointer);
    }
    // `c_char` has a sign on some processors, and none on others.
    let (from, mut bytes) = (from.cast::<u8>(), Vec::new());
    while bytes.len() < LONGEST {
        // SAFETY: C says that it is a text, so that it may be read up to the byte that ends it.
        let byte = unsafe { from.wrapping_add(bytes.len()).read() };
        if byte == 0 {
            return String::from_utf8(bytes).ok().filter(|text| !text.is_empty()).ok_or(red_status::Text);
        }
        bytes.push(byte);
    }
    Err(red_status::Text)
}

/// How a fix names the program where nothing is known about its place.
const COMMAND: &str = "$(which redrt)";

/// A message whose fixes go for the program that runs.
pub(crate) fn for_this_program(message: &str) -> String {
    let path = std::env::current_exe().ok().and_then(|path| path.into_os_string().into_string().ok());
    match path.filter(|path| !path.contains(char::is_control)) {
        // As a shell takes it. A new file has none of the rights of the old one.
        Some(path) => {
            message.replace(COMMAND, &format!("'{}' (a rebuild loses it)", path.replace('\'', r"'\''")))
        }
        None => message.replace(COMMAND, "PROGRAM"),
    }
}

#[cfg(test)]
mod tests;
