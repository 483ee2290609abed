//! Files that are committed although they are made: written, or compared with what makes them.

use std::fs;
use std::path::Path;

use crate::process::Failure;

/// Makes a file what it should be, or says that it is not. `task` is what writes it.
///
/// # Errors
/// It cannot be written; with `check`, it is something else.
pub(crate) fn keep(path: &Path, text: &str, task: &str, check: bool) -> Result<(), Failure> {
    let there = fs::read_to_string(path).unwrap_or_default();
    if there == text {
        return Ok(());
    }
    if !check {
        say!("wrote {}", path.display());
        return fs::write(path, text).map_err(Failure::of_file(path));
    }
    let line = 1 + there.lines().zip(text.lines()).take_while(|(there, made)| there == made).count();
    Err(Failure::Wrong(format!("{}:{line}: not what `cargo xtask {task}` makes: run it", path.display())))
}
