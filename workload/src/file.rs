//! Reading a file without trusting it: a regular file of bounded size, or a refusal.

use std::fs::OpenOptions;
use std::io::{self, Read};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use crate::error::{Fault, LoadError, Place, Refusal, shown_path};
use crate::model::Workload;
use crate::read::{self, BodiesAt};
use crate::text;
use crate::tree::Tree;

/// Size of the largest workload file, in bytes.
pub const MAX_FILE_BYTES: u64 = 4 << 20;

/// The language of a workload file. Keys and values are the same in both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// TOML.
    Toml,
    /// YAML: one document, without tags, anchors and aliases.
    Yaml,
}

impl Format {
    /// The format that the file name's ending tells: YAML for `.yaml` and `.yml`, else TOML.
    #[must_use]
    pub fn of(path: &Path) -> Self {
        let is_yaml = path
            .extension()
            .is_some_and(|ending| ending.eq_ignore_ascii_case("yaml") || ending.eq_ignore_ascii_case("yml"));
        if is_yaml { Self::Yaml } else { Self::Toml }
    }
}

/// Reads and checks the workload file at `path`, in the format that its ending tells.
///
/// # Errors
///
/// A file that cannot be read, is not a regular file or is larger than [`MAX_FILE_BYTES`], and whatever [`parse`]
/// refuses. Never waits for another process, whatever the path leads to.
pub fn load(path: &Path) -> Result<Workload, LoadError> {
    Source::load(path).map(|source| source.workload)
}

/// Reads and checks a workload. `name` names it in messages.
///
/// # Errors
///
/// The first thing that makes the text no valid workload, with its place.
pub fn parse(text: &[u8], format: Format, name: &str) -> Result<Workload, LoadError> {
    Source::parse(text, format, Path::new(name)).map(|source| source.workload)
}

/// A workload and the text that it was read from, for who refuses a part of it later on.
#[derive(Clone, Debug)]
pub struct Source {
    /// What the text says.
    pub workload: Workload,
    /// The language of the text.
    pub format: Format,
    path: PathBuf,
    text: Vec<u8>,
    bodies_at: BodiesAt,
}

impl Source {
    /// As [`load`].
    ///
    /// # Errors
    ///
    /// As for [`load`].
    pub fn load(path: &Path) -> Result<Self, LoadError> {
        let bytes = read_regular(path, &path.to_string_lossy())?;
        Self::parse(&bytes, Format::of(path), path)
    }

    /// As [`parse`], with the name as the path that bodies are relative to.
    ///
    /// # Errors
    ///
    /// As for [`parse`].
    pub fn parse(text: &[u8], format: Format, path: &Path) -> Result<Self, LoadError> {
        let name = path.to_string_lossy();
        if text.len() as u64 > MAX_FILE_BYTES {
            return Err(too_large(&name));
        }
        let text = text::after_mark(text);
        let (workload, bodies_at) =
            workload(text, format).map_err(|fault| LoadError::inside(&name, text, fault))?;
        Ok(Self { workload, format, path: path.to_owned(), text: text.to_owned(), bodies_at })
    }

    /// The path that it was read from, or the name that stands for one.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The text.
    #[must_use]
    pub fn text(&self) -> &str {
        // It was read as text before.
        str::from_utf8(&self.text).unwrap_or_default()
    }

    /// The folder of the file, in which the files of bodies are.
    #[must_use]
    pub fn folder(&self) -> &Path {
        let folder = self.path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder.unwrap_or(Path::new("."))
    }

    /// `FILE:LINE:COLUMN` of a body of a task, or of the part that has none. Parts count in the order in which
    /// [`build`](crate::build) numbers nodes where stages are refined.
    #[must_use]
    pub fn body(&self, task: usize, part: usize) -> String {
        let file = shown_path(&self.path);
        match self.bodies_at.get(task).and_then(|parts| parts.get(part)) {
            Some(at) => format!("{file}:{}", Place::of(&self.text, *at)),
            None => file,
        }
    }
}

fn workload(bytes: &[u8], format: Format) -> Result<(Workload, BodiesAt), Fault> {
    let text = text::decode(bytes)?;
    let tree = match format {
        Format::Toml => Tree::from_toml(text, read::OWNER, &read::KEYS)?,
        Format::Yaml => Tree::from_yaml(text)?,
    };
    read::workload(&tree)
}

fn read_regular(path: &Path, name: &str) -> Result<Vec<u8>, LoadError> {
    let unreadable = |error: io::Error| {
        let expected = "a workload file that can be read: check the path and its permissions".to_owned();
        LoadError::whole(name, Refusal::Unreadable, format!("cannot read this file: {error}"), expected)
    };
    // Without O_NONBLOCK, opening a FIFO would wait for its writer; without O_NOCTTY, a terminal could become ours.
    let file = OpenOptions::new()
        .read(true)
        .custom_flags(libc::O_NONBLOCK | libc::O_NOCTTY)
        .open(path)
        .map_err(unreadable)?;
    // Asked of the open file, not of the path: the path may lead elsewhere by now.
    let metadata = file.metadata().map_err(unreadable)?;
    if !metadata.is_file() {
        let problem = "this is a directory, a FIFO, a device or a socket".to_owned();
        return Err(LoadError::whole(name, Refusal::NotAFile, problem, "a regular file".to_owned()));
    }
    if metadata.len() > MAX_FILE_BYTES {
        return Err(too_large(name));
    }
    // The file may grow while it is read; one byte more than allowed is enough to see that.
    let mut bytes = Vec::new();
    file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

fn too_large(name: &str) -> LoadError {
    let expected = format!("at most {} MiB", MAX_FILE_BYTES >> 20);
    LoadError::whole(name, Refusal::TooLarge, "the file is too large".to_owned(), expected)
}

#[cfg(test)]
mod tests;
