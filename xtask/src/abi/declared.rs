//! What a header declares: its functions with their documentation, and its structs.

use std::fs;

use super::layer;
use crate::process::Failure;
use crate::workspace::Workspace;

/// A function and what is said about it.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Function {
    pub(crate) name: String,
    pub(crate) doc: String,
}

/// A struct and its fields in their order.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Struct {
    pub(crate) name: String,
    pub(crate) fields: Vec<String>,
}

/// What is read off the header.
#[derive(Debug, Default)]
pub(crate) struct Declared {
    pub(crate) abi_version: String,
    pub(crate) functions: Vec<Function>,
    pub(crate) structs: Vec<Struct>,
    /// Structs that a macro `<NAME>_INIT` sets up, in its letters.
    pub(crate) set_up: Vec<String>,
}

impl Declared {
    /// What `ffi/include/red.h` declares.
    ///
    /// # Errors
    /// It cannot be read.
    pub(crate) fn of_workspace(workspace: &Workspace) -> Result<Self, Failure> {
        let path = layer::headers(workspace).join("red.h");
        let text = fs::read_to_string(&path).map_err(Failure::of_file(&path))?;
        Ok(Self::of(&text))
    }

    /// What a header declares that is written as cbindgen writes.
    pub(crate) fn of(text: &str) -> Self {
        let mut found = Self::default();
        let (mut doc, mut code) = (String::new(), String::new());
        let mut in_comment = false;
        for line in text.lines() {
            let word = line.trim();
            if in_comment || word.starts_with("/*") {
                if word.starts_with("/**") {
                    doc.clear();
                }
                doc.push_str(word.trim_start_matches(['/', '*']));
                doc.push(' ');
                in_comment = !word.ends_with("*/");
            } else if word.starts_with('#') {
                found.take_macro(word);
            } else if word != "extern \"C\" {" && !word.starts_with("}  //") {
                code.push_str(word);
                code.push(' ');
                let is_whole = code.matches('{').count() == code.matches('}').count();
                if is_whole && word.ends_with(';') {
                    found.take(code.trim(), &doc);
                    doc.clear();
                    code.clear();
                }
            }
        }
        found
    }

    /// A macro: the version, or what sets a struct up.
    fn take_macro(&mut self, line: &str) {
        let Some((name, value)) = line.strip_prefix("#define ").and_then(|rest| rest.split_once(' ')) else {
            return;
        };
        if name == "RED_ABI_VERSION" {
            self.abi_version = value.to_owned();
        }
        if let Some(name) = name.strip_suffix("_INIT") {
            self.set_up.push(name.to_lowercase());
        }
    }

    /// A declaration without its comments, and the last comment before its end.
    fn take(&mut self, code: &str, doc: &str) {
        if let Some((head, rest)) = code.split_once('{') {
            let (true, Some((body, name))) = (head.starts_with("typedef struct"), rest.rsplit_once('}'))
            else {
                return;
            };
            let name = name.trim_end_matches(';').trim().to_owned();
            self.structs.push(Struct { name, fields: body.split(';').filter_map(field).collect() });
        } else if !code.starts_with("typedef") {
            let Some((head, _)) = code.split_once('(') else { return };
            let name = head.rsplit(|c: char| !is_word(c)).next().unwrap_or_default();
            self.functions.push(Function { name: name.to_owned(), doc: doc.to_owned() });
        }
    }
}

/// The name of a field; of one that points to a function it stands in brackets.
fn field(text: &str) -> Option<String> {
    let text = text.split('[').next()?;
    let name = match text.split_once("(*") {
        Some((_, rest)) => rest.split(')').next()?,
        None => text.rsplit(|c: char| !is_word(c)).find(|word| !word.is_empty())?,
    };
    Some(name.to_owned())
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

#[cfg(test)]
mod tests;
