//! `cargo xtask install`: headers and libraries where other build systems find them.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};

use super::binutils::Target;
use super::build::{self, folder_at, read};
use super::layer::{self, Layer, VERSION};
use super::package;
use crate::process::Failure;
use crate::workspace::{Workspace, entries};

/// Where to, and for which target.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Wish {
    pub(crate) prefix: PathBuf,
    pub(crate) target: Target,
}

impl Wish {
    /// # Errors
    /// The words make no sense: what to write instead.
    pub(crate) fn of(words: &[&str]) -> Result<Self, String> {
        let (mut prefix, mut triple, mut binutils) = (None, None, None);
        for pair in words.chunks(2) {
            let place = match pair[0] {
                "--prefix" => &mut prefix,
                "--target" => &mut triple,
                "--binutils" => &mut binutils,
                other => {
                    return Err(format!("install takes --prefix, --target and --binutils, not {other:?}"));
                }
            };
            match pair {
                [_, value] => *place = Some(*value),
                _ => return Err(format!("{} wants a value after it", pair[0])),
            }
        }
        let prefix =
            prefix.ok_or("install where to? Say --prefix and a folder, as in --prefix \"$HOME/.local\"")?;
        let target = match (triple, binutils) {
            (None, None) => Target::here(),
            (None, Some(_)) => return Err("--binutils is for another --target".to_owned()),
            (Some(triple), binutils) => Target::of(triple, binutils)?,
        };
        let prefix =
            std::path::absolute(prefix).map_err(|reason| format!("--prefix {prefix:?}: {reason}"))?;
        Ok(Self { prefix, target })
    }
}

/// What goes into one place below the prefix.
enum Piece {
    Copy(PathBuf),
    Text(String),
    /// Another name of a file beside it.
    Link(String),
}

/// Builds and installs, and prints what is where.
///
/// # Errors
/// The folder may not be written, a tool is missing, or the build fails.
pub(crate) fn run(workspace: &Workspace, wish: &Wish) -> Result<(), Failure> {
    let Wish { prefix, target } = wish;
    writable(prefix)?;
    target.prepare(workspace)?;
    let pieces = pieces(workspace, target)?;
    let mut rows = Vec::new();
    for (path, piece) in &pieces {
        rows.push(put(&prefix.join(path), piece).map(|what| format!("{path:<42} {what:>10}"))?);
    }
    say!("\nbelow {}:\n{:<42} {:>10}", prefix.display(), "file", "bytes");
    rows.iter().for_each(|row| say!("{row}"));
    say!("\n{}", next(prefix, target));
    Ok(())
}

/// What a user types next.
fn next(prefix: &Path, target: &Target) -> String {
    let prefix = prefix.display();
    if target.has_system() {
        format!(
            "next, where your CMakeLists.txt says find_package(red), or without CMake:\n  \
             cmake -S . -B build -DCMAKE_PREFIX_PATH={prefix}\n  \
             c++ -std=c++17 main.cpp $(PKG_CONFIG_PATH={prefix}/lib/pkgconfig pkg-config --cflags --libs red) \
             -Wl,-rpath,{prefix}/lib"
        )
    } else {
        format!(
            "next, with the compiler of your board:\n  cc main.c -I{prefix}/include -L{prefix}/lib -lred_core"
        )
    }
}

/// Builds what is to be installed: where it goes below the prefix, and what it is.
fn pieces(workspace: &Workspace, target: &Target) -> Result<Vec<(String, Piece)>, Failure> {
    let headers = layer::headers(workspace);
    let build = |layer: Layer, step: usize, steps: usize| {
        say!("[{step}/{steps}] lib{}", layer.library());
        build::library(workspace, layer, target)
    };
    if !target.has_system() {
        let core = build(Layer::Core, 1, 1)?;
        let header = ("include/red.h".to_owned(), Piece::Copy(headers.join("red.h")));
        return Ok(vec![header, ("lib/libred_core.a".to_owned(), Piece::Copy(core.archive))]);
    }
    let mut pieces = Vec::new();
    files_below(&headers, "include", &mut pieces)?;
    for (i, layer) in Layer::ALL.into_iter().enumerate() {
        let built = build(layer, i + 1, Layer::ALL.len())?;
        let (name, soname) = (format!("lib{}", layer.library()), layer::soname(layer));
        pieces.push((format!("lib/{name}.a"), Piece::Copy(built.archive)));
        if let Some(shared) = built.shared {
            let whole = format!("{name}.so.{VERSION}");
            pieces.push((format!("lib/{whole}"), Piece::Copy(shared)));
            pieces.push((format!("lib/{soname}"), Piece::Link(whole)));
            pieces.push((format!("lib/{name}.so"), Piece::Link(soname)));
        }
        let (file, text) = package::pkg_config(layer, &built.besides);
        pieces.push((format!("lib/pkgconfig/{file}"), Piece::Text(text)));
        if layer == Layer::All {
            let files = package::cmake(&built.besides);
            pieces.extend(files.map(|(file, text)| (format!("lib/cmake/red/{file}"), Piece::Text(text))));
        }
    }
    Ok(pieces)
}

/// All headers, where they lie.
fn files_below(folder: &Path, to: &str, pieces: &mut Vec<(String, Piece)>) -> Result<(), Failure> {
    let mut paths = entries(folder)?;
    paths.sort();
    for path in paths {
        let name = path.file_name().unwrap_or_default().display();
        let to = format!("{to}/{name}");
        if path.is_dir() {
            files_below(&path, &to, pieces)?;
        } else {
            pieces.push((to, Piece::Copy(path)));
        }
    }
    Ok(())
}

/// Makes the folder and sees that files can be made in it, before anything is built.
fn writable(prefix: &Path) -> Result<(), Failure> {
    let refused = |reason| Failure::Unwritable { path: prefix.display().to_string(), reason };
    let probe = prefix.join(".red-install");
    fs::create_dir_all(prefix).and_then(|()| fs::write(&probe, "")).map_err(refused)?;
    fs::remove_file(&probe).map_err(refused)
}

/// Puts a file in its place: beside it first, so that who has the old one open keeps it whole. What it is, for people.
fn put(to: &Path, piece: &Piece) -> Result<String, Failure> {
    folder_at(to.parent().unwrap_or(to))?;
    let mut beside = to.as_os_str().to_owned();
    beside.push(".new");
    let beside = PathBuf::from(beside);
    let _old = fs::remove_file(&beside);
    let (made, what) = match piece {
        Piece::Copy(from) => {
            let bytes = read(from)?;
            (fs::write(&beside, &bytes), bytes.len().to_string())
        }
        Piece::Text(text) => (fs::write(&beside, text), text.len().to_string()),
        Piece::Link(target) => (symlink(target, &beside), format!("-> {target}")),
    };
    made.and_then(|()| fs::rename(&beside, to)).map_err(Failure::of_file(to))?;
    Ok(what)
}

#[cfg(test)]
mod tests;
