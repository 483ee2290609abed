//! Files that bodies come from. Who writes a workload file names them, and may name anything: what is read here is a
//! regular file of bounded size below the folder that was trusted, or nothing.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use crate::BodyError;

/// The full path of the file at `path`, relative to `folder`, without symbolic links.
///
/// # Errors
/// There is no such file, or it is not below `folder`, where links may lead.
pub fn within(folder: &Path, path: &Path) -> Result<PathBuf, BodyError> {
    let path = folder.join(path);
    let full = |path: &Path| {
        fs::canonicalize(path).map_err(|reason| BodyError::Read { path: path.to_owned(), reason })
    };
    let file = full(&path)?;
    if file.starts_with(full(folder)?) { Ok(file) } else { Err(BodyError::Outside { path }) }
}

/// What is in a file of at most `most` bytes that [`within`] has found.
///
/// # Errors
/// It cannot be read, is no regular file, or is larger.
pub fn contents(path: &Path, most: u64) -> Result<Vec<u8>, BodyError> {
    let (file, size) = open(path, most)?;
    read(file, size).map_err(|reason| BodyError::Read { path: path.into(), reason })
}

/// Opens a regular file of at most `most` bytes, and tells its size. Never waits for another process.
pub(crate) fn open(path: &Path, most: u64) -> Result<(File, u64), BodyError> {
    // Without O_NONBLOCK, opening a FIFO would wait for its writer; without O_NOCTTY, a terminal could become ours.
    let file = OpenOptions::new().read(true).custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY).open(path);
    // Asked of the open file, not of the path: the path may lead elsewhere by now.
    let opened = file.and_then(|file| file.metadata().map(|metadata| (file, metadata)));
    let (file, metadata) = opened.map_err(|reason| BodyError::Read { path: path.into(), reason })?;
    if !metadata.is_file() {
        return Err(BodyError::NotAFile { path: path.into() });
    }
    if metadata.len() > most {
        return Err(BodyError::TooLarge { path: path.into(), most });
    }
    Ok((file, metadata.len()))
}

/// The first `size` bytes of a file, or fewer if it has become shorter. Takes memory for `size` bytes first.
pub(crate) fn read(file: File, size: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let room = usize::try_from(size).ok().filter(|room| bytes.try_reserve_exact(*room).is_ok());
    room.ok_or(io::ErrorKind::OutOfMemory)?;
    file.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
