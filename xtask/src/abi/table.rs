//! The table of symbols, sizes and offsets in the manual, as a C compiler sees the header.

use super::build::{folder_at, write};
use super::declared::{Declared, Struct};
use super::layer::{self, Layer};
use crate::process::Failure;
use crate::tools;
use crate::workspace::Workspace;

/// Where the table is.
pub(crate) const MANUAL: &str = "docs/c-abi.md";
const BEGIN: &str = "<!-- begin: made by cargo xtask header -->\n";
const END: &str = "<!-- end -->\n";

/// The table of the header in `ffi/include`.
///
/// # Errors
/// It does not compile, or there is no compiler.
pub(crate) fn of_header(workspace: &Workspace) -> Result<String, Failure> {
    let declared = Declared::of_workspace(workspace)?;
    let folder = workspace.target.join("abi");
    folder_at(&folder)?;
    let (source, program) = (folder.join("table.c"), folder.join("table"));
    write(&source, &program_of(&declared.structs))?;
    tools::present(workspace, "cc", &["gcc", "libc6-dev"])?;
    let include = format!("-I{}", layer::headers(workspace).display());
    let cc = workspace.command("cc").args(&["-std=c11", &include, "-o"]);
    cc.args(&[&program, &source]).text()?;
    let rows = workspace.command(program).capture()?;
    let mut table = format!("ABI version {}.\n\n", declared.abi_version);
    table += "| struct | bytes | aligned to | fields, and where they begin |\n|---|---|---|---|\n";
    table += &rows;
    table += "\n\n| function | `libred_core` |\n|---|---|\n";
    for function in &declared.functions {
        let core = if Layer::Core.has(&function.name) { "yes" } else { "no" };
        table += &format!("| `{}` | {core} |\n", function.name);
    }
    Ok(table)
}

/// A program that prints a row for each struct.
fn program_of(structs: &[Struct]) -> String {
    let mut text = "#include <red.h>\n#include <stdio.h>\nint main(void) {\n".to_owned();
    for Struct { name, fields } in structs {
        let places = vec!["%s %zu"; fields.len()].join(", ");
        let values = fields.iter().map(|field| format!(", \"{field}\", offsetof({name}, {field})"));
        let values: String = values.collect();
        text += &format!(
            "  printf(\"| `{name}` | %zu | %zu | {places} |\\n\", sizeof({name}), _Alignof({name}){values});\n"
        );
    }
    text + "  return 0;\n}\n"
}

/// A manual with this table in its place.
///
/// # Errors
/// It has no place for it.
pub(crate) fn inserted(manual: &str, table: &str) -> Result<String, String> {
    let parts = manual.split_once(BEGIN).and_then(|(before, rest)| Some((before, rest.split_once(END)?.1)));
    let (before, after) = parts
        .ok_or_else(|| format!("{MANUAL} has no place for the table: the lines {BEGIN:?} and {END:?}"))?;
    Ok(format!("{before}{BEGIN}\n{table}\n{END}{after}"))
}

#[cfg(test)]
mod tests;
