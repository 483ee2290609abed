//! The workspace once more, below the target folder, for changed sources: always in the same place, so that of what
//! was built only that is built anew whose source is another.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::Failure;
use crate::workspace::{Workspace, entries};

/// Makes `target/<name>/tree` the same as the workspace, without what is built and what is hidden.
///
/// # Errors
/// A file cannot be read or written.
pub(crate) fn of(workspace: &Workspace, name: &str) -> Result<PathBuf, Failure> {
    let tree = workspace.target.join(name).join("tree");
    let is_source = |path: &Path| {
        let name = path.file_name().unwrap_or_default();
        path != workspace.target && name != "target" && !name.to_string_lossy().starts_with('.')
    };
    mirror(&workspace.root, &tree, &is_source)?;
    Ok(tree)
}

/// Makes `to` what `from` is. A file that is the same keeps its time.
fn mirror(from: &Path, to: &Path, is_source: &dyn Fn(&Path) -> bool) -> Result<(), Failure> {
    let failure = Failure::of_file(to);
    if from.is_file() {
        return match fs::read(from).ok() == fs::read(to).ok() {
            true => Ok(()),
            false => fs::copy(from, to).map(drop).map_err(failure),
        };
    }
    fs::create_dir_all(to).map_err(failure)?;
    for old in entries(to)? {
        let new = from.join(old.file_name().unwrap_or_default());
        if !new.exists() || new.is_dir() != old.is_dir() {
            let gone = if old.is_dir() { fs::remove_dir_all(&old) } else { fs::remove_file(&old) };
            gone.map_err(failure)?;
        }
    }
    for path in entries(from)?.iter().filter(|path| is_source(path)) {
        mirror(path, &to.join(path.file_name().unwrap_or_default()), is_source)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
