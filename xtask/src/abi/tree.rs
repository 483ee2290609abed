//! Whether two folders have the same in them.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use super::build::read;
use crate::process::Failure;
use crate::workspace::entries;

/// What lies in a folder: of files the bytes, of links where they point.
type Tree = BTreeMap<PathBuf, Vec<u8>>;

/// That two folders have the same in them; `another` has not, which has to be seen.
///
/// # Errors
/// They have not, or a file cannot be read.
pub(crate) fn same(one: &Path, two: &Path, another: &Path) -> Result<(), Failure> {
    let (one_tree, two_tree) = (of(one)?, of(two)?);
    let differences = differences(&one_tree, &two_tree);
    if !differences.is_empty() {
        let (one, two) = (one.display(), two.display());
        return Err(Failure::Wrong(format!("{one} and {two} differ in {}", differences.join(", "))));
    }
    if self::differences(&one_tree, &of(another)?).is_empty() {
        return Err(Failure::Wrong("all folders are the same, so this check finds nothing".to_owned()));
    }
    say!("CMake installs the same {} files", one_tree.len());
    Ok(())
}

fn of(folder: &Path) -> Result<Tree, Failure> {
    let mut tree = Tree::new();
    take(folder, folder, &mut tree)?;
    Ok(tree)
}

fn take(folder: &Path, root: &Path, tree: &mut Tree) -> Result<(), Failure> {
    for path in entries(folder)? {
        if let Ok(target) = fs::read_link(&path) {
            tree.insert(below(&path, root), target.into_os_string().into_encoded_bytes());
        } else if path.is_dir() {
            take(&path, root, tree)?;
        } else {
            tree.insert(below(&path, root), read(&path)?);
        }
    }
    Ok(())
}

fn below(path: &Path, root: &Path) -> PathBuf {
    path.strip_prefix(root).unwrap_or(path).to_path_buf()
}

fn differences(one: &Tree, two: &Tree) -> Vec<String> {
    let paths = one.keys().chain(two.keys().filter(|path| !one.contains_key(*path)));
    paths.filter(|path| one.get(*path) != two.get(*path)).map(|path| path.display().to_string()).collect()
}

#[cfg(test)]
mod tests;
