//! The files that describe a machine, below a root that tests replace.

use core::fmt;
use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::Command;

/// A file system to read settings from. Paths are given without the leading slash.
pub(super) struct Tree<'a> {
    root: &'a Path,
}

/// Why a file could not be read.
#[derive(Debug)]
pub(super) struct Unreadable {
    path: String,
    reason: String,
    pub(super) absent: bool,
}

impl Unreadable {
    pub(super) fn new(path: &str, reason: impl Into<String>) -> Self {
        Self { path: path.into(), reason: reason.into(), absent: false }
    }
}

impl From<(&str, io::Error)> for Unreadable {
    fn from((path, error): (&str, io::Error)) -> Self {
        let absent = error.kind() == io::ErrorKind::NotFound;
        Self { path: path.into(), reason: error.to_string(), absent }
    }
}

impl fmt::Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "cannot read /{}: {}", self.path, self.reason)
    }
}

impl<'a> Tree<'a> {
    pub(super) const fn new(root: &'a Path) -> Self {
        Self { root }
    }

    /// The text of a file, without blanks, line ends and NULs around it.
    pub(super) fn read(&self, path: &str) -> Result<String, Unreadable> {
        let bytes = fs::read(self.root.join(path)).map_err(|error| Unreadable::from((path, error)))?;
        let text = String::from_utf8_lossy(&bytes);
        Ok(text.trim_matches(|c: char| c.is_whitespace() || c == '\0').to_owned())
    }

    /// The names in a directory, sorted.
    pub(super) fn names(&self, path: &str) -> Result<Vec<String>, Unreadable> {
        let entries = fs::read_dir(self.root.join(path)).map_err(|error| Unreadable::from((path, error)))?;
        let mut names: Vec<_> =
            entries.flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
        names.sort_unstable();
        Ok(names)
    }

    pub(super) fn exists(&self, path: &str) -> bool {
        self.root.join(path).exists()
    }

    /// Opens a device for writing, without writing.
    pub(super) fn open_for_writing(&self, path: &str) -> Result<File, Unreadable> {
        File::options()
            .write(true)
            .open(self.root.join(path))
            .map_err(|error| Unreadable::from((path, error)))
    }

    /// The value of `name` in a file of `name: value` lines.
    pub(super) fn field(&self, path: &str, name: &str) -> Result<String, Unreadable> {
        let text = self.read(path)?;
        let value = text.lines().find_map(|line| line.strip_prefix(name)?.strip_prefix(':'));
        value
            .map(|value| value.trim().to_owned())
            .ok_or_else(|| Unreadable::new(path, format!("no line {name}:")))
    }

    /// Whether a process runs whose name begins with `name`; the kernel keeps 15 letters.
    pub(super) fn runs(&self, name: &str) -> Result<bool, Unreadable> {
        let processes = self.names("proc")?;
        let mut processes = processes.iter().filter(|entry| entry.bytes().all(|byte| byte.is_ascii_digit()));
        // A process may end between the two reads; then it does not run.
        Ok(processes.any(|id| self.read(&format!("proc/{id}/comm")).is_ok_and(|comm| comm.starts_with(name))))
    }

    /// The configuration with which the running kernel was built.
    pub(super) fn kernel_config(&self) -> Result<String, Unreadable> {
        const COMPRESSED: &str = "proc/config.gz";
        let release = self.read("proc/sys/kernel/osrelease")?;
        for path in [format!("boot/config-{release}"), format!("lib/modules/{release}/config")] {
            if let Ok(config) = self.read(&path) {
                return Ok(config);
            }
        }
        let unpack = || -> io::Result<String> {
            let packed = File::open(self.root.join(COMPRESSED))?;
            let unpacked = Command::new("gzip").arg("-dc").stdin(packed).output()?;
            Ok(String::from_utf8_lossy(&unpacked.stdout).into_owned())
        };
        unpack().map_err(|error| Unreadable::from((COMPRESSED, error)))
    }
}
