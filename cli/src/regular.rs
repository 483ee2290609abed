//! Files that a log may be in: opening a FIFO would wait for its other end, and a device cannot be closed as a log is.

use std::fs;
use std::io;
use std::path::Path;

/// Whether the path leads to a regular file; it may be missing.
///
/// # Errors
/// What it is instead, or why nobody can say.
pub(crate) fn exists(path: &Path) -> io::Result<bool> {
    match fs::metadata(path) {
        Ok(there) if there.is_file() => Ok(true),
        Ok(_) => Err(io::Error::other("it is a directory, a FIFO, a device or a socket")),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}
