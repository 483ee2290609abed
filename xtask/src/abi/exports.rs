//! What the libraries show to others, and what they ask of them.

use std::path::Path;

use super::binutils::Target;
use super::build::{folder_at, read, unreadable, write};
use super::declared::Declared;
use super::elf::{self, Names};
use super::layer::{self, Layer, VERSION};
use crate::process::Failure;
use crate::symbols::{FORBIDDEN, OUTSIDE};
use crate::workspace::Workspace;

/// Libraries that the one with all functions may need: those of the system.
const SYSTEM: &[&str] =
    &["libc.so.", "libgcc_s.so.", "libm.so.", "libpthread.so.", "libdl.so.", "librt.so.", "ld-linux"];

/// A library that does everything wrong.
const PLANTED: &str = "#include <math.h>\n\
    double stray(double x) { return cos(x); }\n\
    int red_of_no_header(void) { return 1; }\n\
    void rust_begin_unwind(void) {}\n";
/// What has to be said about it, as a shared library and as a static one.
const SAID_OF_SHARED: &[&str] = &[
    "shows stray",
    "shows red_of_no_header",
    "lacks red_version",
    "has rust_begin_unwind",
    "needs libm.so",
    "is called",
    "has no symbol version",
];
const SAID_OF_STATIC: &[&str] =
    &["shows stray", "shows red_of_no_header", "lacks red_version", "has rust_begin_unwind", "asks for cos"];

/// Looks at the libraries below a prefix, after it has looked at a planted one. How many libraries were looked at.
///
/// # Errors
/// A library is not as it should be, or what is planted is not found.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let declared = Declared::of_workspace(workspace)?;
    planted(workspace, &declared)?;
    let lib = prefix.join("lib");
    for layer in Layer::ALL {
        let archive = lib.join(format!("lib{}.a", layer.library()));
        quiet_about(&archive, &of_static(&read(&archive)?, layer, &declared))?;
        let shared = lib.join(format!("lib{}.so.{VERSION}", layer.library()));
        quiet_about(&shared, &of_shared(&read(&shared)?, layer, &declared))?;
        // The look for panics by name sees them where they are.
        if layer == Layer::All && !has_forbidden(&elf::shared(&read(&shared)?).unwrap_or_default()) {
            return Err(Failure::Wrong("no panic is seen in libred.so, which has some".to_owned()));
        }
        let functions = declared.functions.iter().filter(|function| layer.has(&function.name)).count();
        for path in [&archive, &shared] {
            say!("{}: {functions} functions and nothing else, {} bytes", name(path), read(path)?.len());
        }
    }
    Ok(4)
}

/// Looks at the static library for firmware; how many libraries were looked at.
///
/// # Errors
/// It is not as it should be, or not alone with its header.
pub(crate) fn check_firmware(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let archive = prefix.join("lib/libred_core.a");
    let bytes = read(&archive)?;
    quiet_about(&archive, &of_static(&bytes, Layer::Core, &Declared::of_workspace(workspace)?))?;
    say!("{}, for firmware: nothing else, {} bytes", name(&archive), bytes.len());
    Ok(1)
}

/// What is wrong with a static library.
fn of_static(bytes: &[u8], layer: Layer, declared: &Declared) -> object::Result<Vec<String>> {
    let names = elf::archive(bytes)?;
    let mut found = of_any(&names, layer, declared);
    if layer == Layer::Core {
        let foreign = names.imports.iter().filter(|name| !OUTSIDE.contains(&name.as_str()));
        found.extend(foreign.map(|name| format!("asks for {name}")));
    }
    Ok(found)
}

/// What is wrong with a shared library.
fn of_shared(bytes: &[u8], layer: Layer, declared: &Declared) -> object::Result<Vec<String>> {
    let (mut names, loaded) = (elf::shared(bytes)?, elf::loaded(bytes)?);
    let version = format!("red_{}", declared.abi_version);
    let is_there = names.exports.remove(&version);
    let mut found = of_any(&names, layer, declared);
    if !is_there {
        found.push(format!("has no symbol version {version}"));
    }
    let soname = layer::soname(layer);
    if loaded.soname.as_ref() != Some(&soname) {
        found.push(format!("is called {:?} and not {soname}", loaded.soname));
    }
    let known = |library: &str| layer == Layer::All && SYSTEM.iter().any(|part| library.starts_with(part));
    let needed = loaded.needed.iter().filter(|library| !known(library));
    found.extend(needed.map(|library| format!("needs {library}")));
    if layer == Layer::Core {
        found.extend(names.imports.iter().map(|name| format!("asks for {name}")));
    }
    Ok(found)
}

/// What is wrong with any library: it has the functions of the header, and shows nothing else.
fn of_any(names: &Names, layer: Layer, declared: &Declared) -> Vec<String> {
    let wanted =
        |name: &str| declared.functions.iter().any(|function| function.name == name) && layer.has(name);
    let more = names.exports.iter().filter(|name| !wanted(name)).map(|name| format!("shows {name}"));
    let functions = declared.functions.iter().map(|function| &function.name);
    let less = functions.filter(|name| layer.has(name) && !names.exports.contains(*name));
    let mut found: Vec<String> = more.chain(less.map(|name| format!("lacks {name}"))).collect();
    if layer == Layer::Core {
        let forbidden = names.inside.iter().filter(|name| is_forbidden(name));
        found.extend(forbidden.map(|name| format!("has {name}")));
    }
    found
}

fn is_forbidden(name: &str) -> bool {
    FORBIDDEN.iter().any(|part| name.contains(part))
}

fn has_forbidden(names: &Names) -> bool {
    names.inside.iter().any(|name| is_forbidden(name))
}

fn quiet_about(path: &Path, found: &object::Result<Vec<String>>) -> Result<(), Failure> {
    match found {
        Err(reason) => Err(unreadable(path, *reason)),
        Ok(found) if found.is_empty() => Ok(()),
        Ok(found) => Err(Failure::Wrong(format!("{}:\n  {}", path.display(), found.join("\n  ")))),
    }
}

/// That a library which does everything wrong is told so.
fn planted(workspace: &Workspace, declared: &Declared) -> Result<(), Failure> {
    let folder = workspace.target.join("abi/planted");
    folder_at(&folder)?;
    let [source, object, archive, shared] =
        ["planted.c", "planted.o", "libplanted.a", "libplanted.so"].map(|name| folder.join(name));
    write(&source, PLANTED)?;
    let (here, flags) = (Target::here(), ["-fPIC", "-fno-builtin", "-o"]);
    here.tool(workspace, "cc")?.args(&["-c"]).args(&flags).args(&[&object, &source]).text()?;
    let _old = std::fs::remove_file(&archive);
    here.tool(workspace, "ar")?.args(&["rcs"]).args(&[&archive, &object]).text()?;
    let link = here.tool(workspace, "cc")?.args(&["-shared"]).args(&flags).args(&[&shared, &object]);
    link.args(&["-lm"]).text()?;
    for (path, found, said) in [
        (&shared, of_shared(&read(&shared)?, Layer::Core, declared), SAID_OF_SHARED),
        (&archive, of_static(&read(&archive)?, Layer::Core, declared), SAID_OF_STATIC),
    ] {
        let found = found.map_err(|reason| unreadable(path, reason))?;
        for said in said {
            let line = found.iter().find(|line| line.starts_with(said)).ok_or_else(|| {
                Failure::Wrong(format!(
                    "{}: not found that it {said}, so this check finds nothing",
                    name(path)
                ))
            })?;
            say!("{}: found, as it should be: {line}", name(path));
        }
    }
    Ok(())
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().display().to_string()
}
