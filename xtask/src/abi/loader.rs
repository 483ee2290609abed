//! A program and a shared library of two versions: the loader refuses them before the first call.

use std::fs;
use std::path::{Path, PathBuf};

use super::binutils::Target;
use super::build::{folder_at, write};
use super::declared::Declared;
use super::layer::{self, Layer};
use crate::process::Failure;
use crate::workspace::Workspace;

/// Says which library it got.
const MAIN: &str = "#include <red.h>\n#include <stdio.h>\n\
    int main(void) { printf(\"%u\\n\", (unsigned)red_abi_version()); return 0; }\n";
/// A library with all that the program calls, and what the program says then.
const OTHER: &str = "unsigned red_abi_version(void) { return 77; }\n";
const SAID_WITH_OTHER: &str = "77";

/// Runs a program with the library that it was linked with, and with others in its place; how many times.
///
/// # Errors
/// It does not run with the right one, or with one that cannot be told from it; or it runs with another one.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let version = Declared::of_workspace(workspace)?.abi_version;
    let lib = prefix.join("lib");
    let mut tried = 0;
    for layer in Layer::ALL {
        let folder = workspace.target.join("abi/loader").join(layer.library());
        let _old = fs::remove_dir_all(&folder);
        folder_at(&folder)?;
        let [source, program] = ["main.c", "main"].map(|name| folder.join(name));
        write(&source, MAIN)?;
        let link = Target::here().tool(workspace, "cc")?.args(&["-o"]).args(&[&program, &source]);
        let link = link.args(&["-I"]).args(&[prefix.join("include")]).args(&["-L"]).args(&[&lib]);
        link.args(&[format!("-l{}", layer.library())]).text()?;

        let soname = layer::soname(layer);
        let other = |soname: &str, version: &str| other(workspace, &folder, soname, version);
        let (renamed, newer) = (format!("{soname}7"), format!("{version}7"));
        let refused = format!("version `red_{version}' not found");
        for (library, place, runs, words) in [
            ("the library", lib.clone(), true, &*version),
            // So it is not for anything else that the others are refused.
            ("of its name and version", other(&soname, &version)?, true, SAID_WITH_OTHER),
            ("of another version", other(&soname, &newer)?, false, &*refused),
            ("of another name", other(&renamed, &version)?, false, "cannot open shared object file"),
        ] {
            let (said, ended_well) = workspace.command(&program).env("LD_LIBRARY_PATH", &place).all_text()?;
            if ended_well != runs || !said.contains(words) {
                return Err(Failure::Wrong(format!("a program with {soname}, {library}:\n{said}")));
            }
            say!("a program with {soname}, {library}: {}", said.trim());
            tried += 1;
        }
    }
    Ok(tried)
}

/// A library whose symbols have a version; the folder where it is alone.
fn other(workspace: &Workspace, folder: &Path, soname: &str, version: &str) -> Result<PathBuf, Failure> {
    let place = folder.join(format!("{soname}-{version}"));
    folder_at(&place)?;
    let [source, map, library] = ["other.c", "map", soname].map(|name| place.join(name));
    write(&source, OTHER)?;
    write(&map, &format!("red_{version} {{ global: red_*; local: *; }};\n"))?;
    let names = [format!("-Wl,-soname,{soname}"), format!("-Wl,--version-script={}", map.display())];
    let link = Target::here().tool(workspace, "cc")?.args(&["-shared", "-fPIC"]).args(&names);
    link.args(&["-o"]).args(&[&library, &source]).text()?;
    Ok(place)
}
