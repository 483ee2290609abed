//! Where things are.

use std::env;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{Failure, Run};

/// The workspace's root folder, and the folder for everything built.
pub(crate) struct Workspace {
    pub(crate) root: PathBuf,
    pub(crate) target: PathBuf,
}

impl Workspace {
    /// The workspace that this program was built in.
    pub(crate) fn here() -> Self {
        let root =
            Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the root").to_path_buf();
        let target = root.join(env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into()));
        Self { root, target }
    }

    /// The examples of all packages, relative to the root.
    ///
    /// # Errors
    /// A folder cannot be read.
    pub(crate) fn examples(&self) -> Result<Vec<PathBuf>, Failure> {
        let mut found = Vec::new();
        for package in entries(&self.root)?.iter().filter(|folder| folder.join("examples").is_dir()) {
            let sources = entries(&package.join("examples"))?;
            found
                .extend(sources.into_iter().filter(|file| file.extension().is_some_and(|kind| kind == "rs")));
        }
        found.sort();
        Ok(found.iter().filter_map(|file| file.strip_prefix(&self.root).ok()).map(PathBuf::from).collect())
    }

    /// `program`, in the root folder.
    pub(crate) fn command(&self, program: impl AsRef<OsStr>) -> Run {
        Run::new(program.as_ref(), &self.root)
    }

    /// The cargo that started this program, so that both are of one toolchain.
    pub(crate) fn cargo(&self, arguments: &[&str]) -> Run {
        self.command(env::var_os("CARGO").unwrap_or_else(|| "cargo".into())).args(arguments)
    }
}

/// What lies in a folder.
///
/// # Errors
/// It cannot be read.
pub(crate) fn entries(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failure = Failure::of_file(folder);
    fs::read_dir(folder).map_err(failure)?.map(|entry| Ok(entry.map_err(failure)?.path())).collect()
}
