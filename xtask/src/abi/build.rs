//! The libraries, out of what cargo makes: everything that a function of the header reaches becomes one object, in which
//! only these functions have names for others. So a program may link them beside other libraries written in Rust, each of
//! which brings a standard library of its own, under the same names.

use std::fs;
use std::path::{Path, PathBuf};

use super::binutils::Target;
use super::declared::Declared;
use super::elf;
use super::layer::{self, Layer, VERSION};
use crate::process::Failure;
use crate::workspace::Workspace;

/// One object of what is reached, and no groups in it: the linker keeps one of the groups of a name, and drops ours if
/// another library's comes first, with our tables of unwinding.
const ONE_OBJECT: &[&str] = &["-r", "--gc-sections", "--force-group-allocation"];
/// Names that others see, those of our C files apart; no bitcode, for which some tools take the whole object; no lines of our sources.
const ONLY_OURS: &[&str] = &[
    "--wildcard",
    "--keep-global-symbol=red_*",
    "--localize-hidden",
    "--remove-section=.llvmbc",
    "--remove-section=.llvmcmd",
    "--strip-debug",
];
/// A shared library that has everything it needs, bound when it is loaded and not in the middle of a cycle.
const SHARED: &[&str] = &["-shared", "-Wl,--gc-sections", "-Wl,--as-needed", "-Wl,-z,defs,-z,relro,-z,now"];
/// Our own memcpy: no loop in it may become a call of it.
const MEMORY: &[&str] =
    &["-O2", "-fPIC", "-ffreestanding", "-fno-builtin", "-fno-tree-loop-distribute-patterns", "-c"];
/// What compilers add themselves, as far as a program of this kind has it.
const ADDED_BY_COMPILERS: &[&str] = &["-lgcc_s", "-lc"];

/// What building the object may leave out, to show what it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Care {
    All,
    /// Groups stay groups.
    NoGroups,
    /// Names stay that nothing uses.
    NoLeftovers,
}

/// A library.
pub(crate) struct Built {
    pub(crate) archive: PathBuf,
    /// Where there is an operating system.
    pub(crate) shared: Option<PathBuf>,
    /// What a program that links the archive has to link besides.
    pub(crate) besides: Vec<String>,
}

/// Builds a library for a target.
///
/// # Errors
/// A tool is missing, or fails.
pub(crate) fn library(workspace: &Workspace, layer: Layer, target: &Target) -> Result<Built, Failure> {
    let (made, besides) = compile(workspace, layer, target)?;
    let folder = workspace.target.join("abi").join(target.triple.as_deref().unwrap_or("here"));
    folder_at(&folder)?;
    let name = format!("lib{}", layer.library());
    let archive = folder.join(format!("{name}.a"));
    one_object(workspace, target, &made, &archive, Care::All)?;
    let shared = match target.has_system() {
        true => Some(link_shared(workspace, layer, target, &archive, &besides)?),
        false => None,
    };
    Ok(Built { archive, shared, besides })
}

/// What cargo makes, and what rustc says that it needs.
pub(crate) fn compile(
    workspace: &Workspace,
    layer: Layer,
    target: &Target,
) -> Result<(PathBuf, Vec<String>), Failure> {
    let build = ["rustc", "--package", "red-ffi", "--crate-type", "staticlib", "--profile", layer.profile()];
    let mut cargo = workspace.cargo(&build).args(layer.features());
    let mut folder = workspace.target.clone();
    if let Some(triple) = &target.triple {
        cargo = cargo.args(&["--target", triple]);
        folder.push(triple);
    }
    for (variable, value) in target.environment() {
        cargo = cargo.env(&variable, value);
    }
    let flags = if layer == Layer::Core { target.flags() } else { &[] };
    let said = cargo.args(&["--", "--print", "native-static-libs"]).args(flags).text()?;
    Ok((folder.join(layer.profile()).join("libred_ffi.a"), needed(&said)))
}

/// The libraries that rustc names in what it said.
fn needed(said: &str) -> Vec<String> {
    let line = said.lines().find_map(|line| line.split_once("native-static-libs:"));
    let mut found = Vec::new();
    for library in line.map_or("", |(_, list)| list).split_whitespace() {
        if !ADDED_BY_COMPILERS.contains(&library) && !found.iter().any(|known| known == library) {
            found.push(library.to_owned());
        }
    }
    found
}

/// An archive of one object, with what the functions of an archive of cargo's reach.
///
/// # Errors
/// A tool is missing, or fails; or there is no function.
pub(crate) fn one_object(
    workspace: &Workspace,
    target: &Target,
    from: &Path,
    to: &Path,
    care: Care,
) -> Result<(), Failure> {
    let names = elf::archive(&read(from)?).map_err(|reason| unreadable(from, reason))?;
    let functions: Vec<&String> = names.exports.iter().filter(|name| name.starts_with("red_")).collect();
    if functions.is_empty() {
        return Err(Failure::Wrong(format!("{} has no function red_*", from.display())));
    }
    let whole = to.with_extension("whole.o");
    let object = to.with_extension("o");
    let roots = to.with_extension("roots");
    write(&roots, &functions.iter().map(|name| format!("--undefined={name}\n")).collect::<String>())?;
    let link = ONE_OBJECT.iter().filter(|flag| care != Care::NoGroups || !flag.contains("group"));
    let link = target
        .tool(workspace, "ld.bfd")?
        .args(&link.collect::<Vec<_>>())
        .args(&[format!("@{}", roots.display())]);
    link.args(&["-o".as_ref(), whole.as_path(), from]).text()?;
    let unused = match care {
        Care::NoLeftovers => Vec::new(),
        _ => elf::unused_imports(&read(&whole)?).map_err(|reason| unreadable(&whole, reason))?,
    };
    let leftovers = to.with_extension("leftovers");
    // The comment is for objcopy, which refuses an empty file.
    let names: String = unused.iter().map(|name| format!("{name}\n")).collect();
    write(&leftovers, &format!("# used by nothing\n{names}"))?;
    let copy = target
        .tool(workspace, "objcopy")?
        .args(ONLY_OURS)
        .args(&[format!("--strip-symbols={}", leftovers.display())]);
    copy.args(&[&whole, &object]).text()?;
    if to.exists() {
        fs::remove_file(to).map_err(Failure::of_file(to))?;
    }
    // D: the same bytes whenever it is made.
    target.tool(workspace, "ar")?.args(&["rcsD".as_ref(), to, object.as_path()]).text().map(drop)
}

fn link_shared(
    workspace: &Workspace,
    layer: Layer,
    target: &Target,
    archive: &Path,
    besides: &[String],
) -> Result<PathBuf, Failure> {
    let to = archive.with_extension(format!("so.{VERSION}"));
    let version = Declared::of_workspace(workspace)?.abi_version;
    let map = archive.with_extension("map");
    write(&map, &format!("red_{version} {{ global: red_*; local: *; }};\n"))?;
    let cc = || target.tool(workspace, "cc");
    let mut link = cc()?
        .args(SHARED)
        .args(&[format!("-Wl,-soname,{}", layer::soname(layer))])
        .args(&[format!("-Wl,--version-script={}", map.display())])
        .args(&["-o".as_ref(), to.as_path()])
        .args(&["-Wl,--whole-archive".as_ref(), archive, "-Wl,--no-whole-archive".as_ref()]);
    link = match layer {
        Layer::Core => {
            let memory = archive.with_extension("memory.o");
            let source = workspace.root.join("ffi/src/memory.c");
            cc()?.args(MEMORY).args(&["-o".as_ref(), memory.as_path(), source.as_path()]).text()?;
            link.args(&["-nostdlib".as_ref(), memory.as_path()])
        }
        Layer::All => link.args(besides),
    };
    link.text()?;
    Ok(to)
}

pub(crate) fn folder_at(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(Failure::of_file(path))
}

pub(crate) fn read(path: &Path) -> Result<Vec<u8>, Failure> {
    fs::read(path).map_err(Failure::of_file(path))
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), Failure> {
    fs::write(path, text).map_err(Failure::of_file(path))
}

pub(crate) fn unreadable(path: &Path, reason: object::Error) -> Failure {
    Failure::Wrong(format!("{}: {reason}", path.display()))
}

#[cfg(test)]
mod tests;
