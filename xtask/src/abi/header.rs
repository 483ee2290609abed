//! `cargo xtask header`: the header, made of the sources of the C ABI, and the table in its manual, made of the header.

use std::fs;
use std::path::{Path, PathBuf};

use super::build::folder_at;
use super::declared::Declared;
use super::{layer, table};
use crate::kept::keep;
use crate::process::Failure;
use crate::tools;
use crate::workspace::Workspace;

/// What writes header and table.
const TASK: &str = "header";
/// The version of cbindgen that `ffi/cbindgen.toml` is written for.
const CBINDGEN: &str = "0.29.2";
/// What is said about every function.
const SAID: [&str; 4] = ["Threads:", "Real time:", "Time:", "Errors:"];

/// Writes header and table, or compares them with what is there.
///
/// # Errors
/// A tool is missing or fails; with `check`, something is not up to date. In either case, a function whose documentation
/// is not complete.
pub(crate) fn run(workspace: &Workspace, check: bool) -> Result<(), Failure> {
    let header = layer::headers(workspace).join("red.h");
    let made = made(workspace)?;
    let text = text_of(&made)?;
    let missing = unsaid(&Declared::of(&text));
    if !missing.is_empty() {
        return Err(Failure::Wrong(format!(
            "what a function's documentation lacks:\n  {}",
            missing.join("\n  ")
        )));
    }
    if check {
        planted(&header, &text)?;
    }
    keep(&header, &text, TASK, check)?;
    let manual = workspace.root.join(table::MANUAL);
    let table = table::inserted(&text_of(&manual)?, &table::of_header(workspace)?).map_err(Failure::Wrong)?;
    keep(&manual, &table, TASK, check)
}

/// The header as cbindgen makes it now.
fn made(workspace: &Workspace) -> Result<PathBuf, Failure> {
    let folder = workspace.target.join("abi");
    folder_at(&folder)?;
    let made = folder.join("red.h");
    let cbindgen = tools::built(workspace, "cbindgen", CBINDGEN, &["--version"])?;
    let arguments = ["--quiet", "--config", "cbindgen.toml", "--output"];
    cbindgen.at(&workspace.root.join("ffi")).args(&arguments).args(&[&made]).args(&["."]).text()?;
    Ok(made)
}

/// That the checks see a header without a word about time.
fn planted(header: &Path, text: &str) -> Result<(), Failure> {
    let planted = text.replacen(" Time: ", " ", 1);
    let found = unsaid(&Declared::of(&planted));
    let [said] = &found[..] else {
        return Err(Failure::Wrong(format!("a function without a word about time is not found: {found:?}")));
    };
    match keep(header, &planted, TASK, true) {
        Err(differs) => say!("found, as it should be: {said} is missing; {differs}"),
        Ok(()) => return Err(Failure::Wrong("a changed header is not found".to_owned())),
    }
    Ok(())
}

/// What functions do not say about themselves.
pub(crate) fn unsaid(declared: &Declared) -> Vec<String> {
    let functions = declared.functions.iter();
    let lacks = |doc: &str| SAID.into_iter().filter(|word| !doc.contains(word)).collect::<Vec<_>>();
    functions
        .flat_map(|function| {
            lacks(&function.doc).into_iter().map(|word| format!("{}: {word}", function.name))
        })
        .collect()
}

fn text_of(path: &PathBuf) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(Failure::of_file(path))
}

#[cfg(test)]
mod tests;
