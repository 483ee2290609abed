//! A file that is there whole or not at all: written beside its place, and put there at the end.

use super::found::folder;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Names that are tried: what a process that was killed left behind keeps its own.
const NAMES: u32 = 100;

/// Sees that the folder of a path takes files, and leaves nothing there.
///
/// # Errors
/// It does not.
pub(super) fn probe(path: &Path) -> io::Result<()> {
    let (_, beside) = beside(path)?;
    fs::remove_file(beside)
}

/// Puts a file at a path. What was there stays if it is not to be replaced, or if the new one cannot be written.
///
/// # Errors
/// It cannot be written, or something is there and `replaces` is not set.
pub(super) fn put(
    path: &Path,
    replaces: bool,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let (file, beside) = beside(path)?;
    let written = filled(file, fill)
        .and_then(|file| file.sync_all())
        .and_then(|()| if replaces { fs::rename(&beside, path) } else { link(&beside, path) });
    if written.is_err() {
        let _none_left = fs::remove_file(&beside);
    }
    written
}

/// Fills a file to its last byte.
///
/// # Errors
/// It does not take all.
pub(super) fn filled(
    file: File,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<File> {
    let mut file = BufWriter::new(file);
    fill(&mut file)?;
    file.flush()?;
    file.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A new file in the folder of a path, and its name.
fn beside(path: &Path) -> io::Result<(File, PathBuf)> {
    let _has_a_name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let name = |nth| folder(path).join(format!(".redrt-{}-{nth}", std::process::id()));
    let mut made = Err(io::ErrorKind::AlreadyExists.into());
    for beside in (0..NAMES).map(name) {
        made = File::create_new(&beside).map(|file| (file, beside));
        if !matches!(&made, Err(error) if error.kind() == io::ErrorKind::AlreadyExists) {
            break;
        }
    }
    made
}

/// Gives a file its name, which nothing has: what appeared meanwhile is somebody's as well.
fn link(beside: &Path, path: &Path) -> io::Result<()> {
    match fs::hard_link(beside, path) {
        Ok(()) => fs::remove_file(beside),
        Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
        // Some file systems have no links.
        Err(_) if fs::symlink_metadata(path).is_ok() => Err(io::ErrorKind::AlreadyExists.into()),
        Err(_) => fs::rename(beside, path),
    }
}
