//! A page that is there whole or not at all.

use crate::outcome::Failure;
use red_rt::stop::StopSignals;
use red_workload::shown_path;
use std::fs;
use std::io::{self, Write};
use std::path::Path;

/// Writes a page to a file beside its place, and puts it there.
///
/// # Errors
/// [`Failure::Machine`] with a cure; what was there before is as it was.
pub(crate) fn write(path: &Path, page: &str, option: &str) -> Result<(), Failure> {
    // Ctrl-C comes before or after.
    let _held = StopSignals::install().ok();
    put(path, page).map_err(|e| {
        Failure::Machine(format!(
            "cannot write the page to `{}`: {e}; choose a file in a folder that takes it with {option}",
            shown_path(path)
        ))
    })
}

fn put(path: &Path, page: &str) -> io::Result<()> {
    if path.is_dir() {
        return Err(io::Error::from(io::ErrorKind::IsADirectory));
    }
    // What is no file, such as a pipe, takes it as it comes: putting a file in its place would be the wrong thing.
    if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return fs::OpenOptions::new().write(true).open(path)?.write_all(page.as_bytes());
    }
    let name = path.file_name().ok_or(io::ErrorKind::InvalidInput)?;
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}", std::process::id()));
    let beside = path.with_file_name(beside);
    let written = fs::File::create_new(&beside)
        .and_then(|mut file| file.write_all(page.as_bytes()).and_then(|()| file.sync_all()))
        .and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        let _none_left = fs::remove_file(&beside);
    }
    written
}
