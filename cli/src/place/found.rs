//! What is at a path, and whether two paths lead to one file.

use std::fs::{self, File};
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Links followed before a path counts as a ring of them, as the kernel has it.
const LINKS: usize = 40;

/// What an output finds at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// Nothing.
    Nothing,
    /// A file, or a link that leads to one or nowhere.
    File,
    /// Something that takes what comes, and keeps no file that could be lost.
    Stream(Stream),
}

/// Where what comes goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stream {
    /// To standard output.
    Out,
    /// To standard error.
    Err,
    /// To a device, a pipe, or a descriptor that is open.
    Other,
}

impl Found {
    /// Whether it takes what comes.
    pub(super) const fn is_stream(self) -> bool {
        matches!(self, Self::Stream(_))
    }
}

impl Stream {
    /// Opens it for writing behind what was written before.
    ///
    /// # Errors
    /// It cannot be opened.
    pub(super) fn open(self, path: &Path) -> io::Result<File> {
        // The same open file as that of the answers: one of its own would begin at the start, and write over them.
        let again = |fd: BorrowedFd<'_>| fd.try_clone_to_owned().map(File::from);
        match self {
            Self::Out => again(io::stdout().as_fd()),
            Self::Err => again(io::stderr().as_fd()),
            Self::Other => File::options().append(true).open(path),
        }
    }
}

/// What is at a path.
///
/// # Errors
/// No file can be there, or nobody may look.
pub(super) fn at(path: &Path) -> io::Result<Found> {
    if path.as_os_str().as_bytes().ends_with(b"/") {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    match fs::symlink_metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Found::Nothing),
        Err(error) => return Err(error),
        Ok(_) => {}
    }
    let Ok(there) = fs::metadata(path) else { return Ok(Found::File) };
    if there.is_dir() {
        return Err(io::ErrorKind::IsADirectory.into());
    }
    if is_descriptor(path) {
        let is = |fd: BorrowedFd<'_>| {
            let open = fd.try_clone_to_owned().and_then(|fd| File::from(fd).metadata());
            open.is_ok_and(|open| (open.dev(), open.ino()) == (there.dev(), there.ino()))
        };
        return Ok(Found::Stream(match () {
            () if is(io::stdout().as_fd()) => Stream::Out,
            () if is(io::stderr().as_fd()) => Stream::Err,
            () => Stream::Other,
        }));
    }
    Ok(if there.is_file() { Found::File } else { Found::Stream(Stream::Other) })
}

/// Whether a path is one of those of `/proc` that stand for what a process has open, as `/dev/stdout` does.
fn is_descriptor(path: &Path) -> bool {
    let mut path = path.to_owned();
    for _ in 0..LINKS {
        let folder = folder(&path);
        if fs::canonicalize(&folder).is_ok_and(|folder| folder.starts_with("/proc")) {
            return true;
        }
        match fs::read_link(&path) {
            Ok(target) => path = folder.join(target),
            Err(_) => return false,
        }
    }
    false
}

/// Whether two paths lead to one file, by whatever links; or would, if there was one.
pub(super) fn is_same(one: &Path, other: &Path) -> bool {
    let file = |path| fs::metadata(path).map(|found| (found.dev(), found.ino())).ok();
    let place = |path: &Path| Some(fs::canonicalize(folder(path)).ok()?.join(path.file_name()?));
    let same = |one: Option<_>, other| one.is_some() && one == other;
    same(file(one), file(other)) || place(one).is_some_and(|one| place(other) == Some(one))
}

/// The folder that a path is in.
pub(super) fn folder(path: &Path) -> PathBuf {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
    folder.unwrap_or(Path::new(".")).to_owned()
}
