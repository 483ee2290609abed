//! Which entries there have to be: one for each public function, read off the sources.

use std::collections::BTreeSet;
use std::fmt;
use std::fs;
use std::path::{Path, PathBuf};

use crate::process::Failure;
use crate::workspace::{Workspace, entries};

/// Where public calls are. Left out are those that are `const` and that a macro writes for every kind of id or time: they
/// read a field, or do one operation on it.
const SOURCES: &[&str] = &["core-nostd/src", "sync/src"];

/// A public function: `Type_call`, or `call`.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Entry(String);

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl Entry {
    /// Whether one of the symbols, `red_<capacity>_<entry>`, is it.
    pub(crate) fn is_in(&self, symbols: &BTreeSet<String>) -> bool {
        let is_it = |symbol: &str| {
            let words = symbol.strip_prefix("red_").and_then(|rest| rest.split_once('_'));
            words.is_some_and(|(_, entry)| entry == self.0)
        };
        symbols.iter().any(|symbol| is_it(symbol))
    }
}

/// # Errors
/// A source cannot be read.
pub(crate) fn wanted(workspace: &Workspace) -> Result<BTreeSet<Entry>, Failure> {
    let mut found = BTreeSet::new();
    for folder in SOURCES {
        for file in sources(&workspace.root.join(folder))? {
            let text = fs::read_to_string(&file).map_err(Failure::of_file(&file))?;
            found.extend(public_functions(&text));
        }
    }
    Ok(found)
}

fn sources(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mut found = Vec::new();
    for path in entries(folder)? {
        if path.is_dir() {
            found.extend(sources(&path)?);
        } else if path.extension().is_some_and(|kind| kind == "rs") && !path.ends_with("tests.rs") {
            found.push(path);
        }
    }
    Ok(found)
}

/// Public functions of a formatted source: the `impl` that a function stands in is the last one that began.
fn public_functions(text: &str) -> Vec<Entry> {
    let mut of = String::new();
    let mut found = Vec::new();
    for line in text.lines() {
        if let Some(header) = line.strip_prefix("impl") {
            of = implemented(header);
        } else if line == "}" {
            of.clear();
        }
        let text = line.trim_start();
        // What a macro writes stands deeper than a method.
        let is_own = line.len() - text.len() <= 4;
        let constant = || text.strip_prefix("pub const fn ").filter(|_| is_own);
        let Some(name) = text.strip_prefix("pub fn ").or_else(constant).map(identifier) else { continue };
        found.push(Entry(if of.is_empty() { name } else { format!("{of}_{name}") }));
    }
    found
}

/// The type of `impl<C: Capacity> Scheduler<C> {` without its parameters.
fn implemented(header: &str) -> String {
    let mut depth = 0;
    let after = header.char_indices().find(|(_, c)| {
        depth += i32::from(*c == '<') - i32::from(*c == '>');
        depth == 0 && *c != '>'
    });
    identifier(header[after.map_or(0, |(at, _)| at)..].trim_start())
}

fn identifier(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

#[cfg(test)]
mod tests;
