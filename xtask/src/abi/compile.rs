//! Each header alone, in every language that it is for, by two compilers, without a warning.

use std::path::{Path, PathBuf};

use super::build::{folder_at, write};
use super::declared::Declared;
use crate::process::Failure;
use crate::workspace::{Workspace, entries};

const WARNINGS: &[&str] =
    &["-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Werror", "-I"];

/// A compiler, the standard that it is asked for, and whether that is one of C.
type Language = (&'static str, &'static str, bool);
/// C11 and C++17, 20 and 23; by the names that Debian's oldest supported compilers know.
const LANGUAGES: &[Language] = &[
    ("gcc", "-std=c11", true),
    ("clang", "-std=c11", true),
    ("g++", "-std=c++17", false),
    ("clang++", "-std=c++17", false),
    ("g++", "-std=c++20", false),
    ("clang++", "-std=c++20", false),
    ("g++", "-std=c++2b", false),
    ("clang++", "-std=c++2b", false),
];

/// What each of them has to refuse: an implicit conversion that loses bits.
const PLANTED: &str = "static inline unsigned char planted(int wide) { return wide; }\n";

/// Compiles the headers below a prefix; how many times.
///
/// # Errors
/// A header does not compile without a warning, or the planted one does.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let include = prefix.join("include");
    let mut headers = Vec::new();
    headers_below(&include, &include, &mut headers)?;
    let folder = workspace.target.join("abi/compile");
    folder_at(&folder)?;
    let mut tried = 0;
    for language in LANGUAGES {
        let (compiler, standard, is_c) = *language;
        let planted = format!(
            "#include <red.h>\n{PLANTED}unsigned char use(void); unsigned char use(void) {{ return planted(1); }}\n"
        );
        let refused = compile(workspace, &folder, &include, *language, &planted)?;
        if !refused.contains("conversion") {
            return Err(Failure::Wrong(format!(
                "{compiler} {standard}: the planted conversion is not refused"
            )));
        }
        for header in headers.iter().filter(|header| !is_c || is_of_c(header)) {
            let text = alone(workspace, header)?;
            let said = compile(workspace, &folder, &include, *language, &text)?;
            if !said.is_empty() {
                return Err(Failure::Wrong(format!("{compiler} {standard} {}:\n{said}", header.display())));
            }
            tried += 1;
        }
        say!("{compiler} {standard}: no warning; the planted conversion is refused");
    }
    Ok(tried)
}

/// A source with nothing but a header, twice; and each struct that the header sets up.
fn alone(workspace: &Workspace, header: &Path) -> Result<String, Failure> {
    let line = format!("#include <{}>\n", header.display());
    let mut text = line.repeat(2);
    if is_of_c(header) {
        for name in Declared::of_workspace(workspace)?.set_up {
            let sets_up = name.to_uppercase();
            text += &format!("extern const {name} {name}_;\nconst {name} {name}_ = {sets_up}_INIT;\n");
        }
    }
    Ok(text)
}

/// What a compiler says; nothing, if it is content.
fn compile(
    workspace: &Workspace,
    folder: &Path,
    include: &Path,
    (compiler, standard, is_c): Language,
    text: &str,
) -> Result<String, Failure> {
    let source = folder.join(if is_c { "alone.c" } else { "alone.cpp" });
    write(&source, text)?;
    let run = workspace.command(compiler).args(&[standard]).args(WARNINGS).args(&[include, &source]);
    let command = run.line();
    match run.all_text()? {
        (said, true) => Ok(said),
        (said, false) if said.is_empty() => Err(Failure::Wrong(format!("`{command}` failed"))),
        (said, false) => Ok(said),
    }
}

fn is_of_c(header: &Path) -> bool {
    header.extension().is_some_and(|kind| kind == "h")
}

/// All headers, as a program includes them.
fn headers_below(folder: &Path, root: &Path, found: &mut Vec<PathBuf>) -> Result<(), Failure> {
    for path in entries(folder)? {
        if path.is_dir() {
            headers_below(&path, root, found)?;
        } else {
            found.push(path.strip_prefix(root).unwrap_or(&path).to_path_buf());
        }
    }
    found.sort();
    Ok(())
}
