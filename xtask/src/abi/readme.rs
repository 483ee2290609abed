//! The program of the README, built from what stands there in an empty folder, in every way that is promised.

use std::fs;
use std::path::{Path, PathBuf};

use super::build::{folder_at, read, write};
use super::elf;
use crate::process::Failure;
use crate::workspace::Workspace;

const README: &str = "README.md";
const SECTION: &str = "## From C++";
/// What the program prints: when the paper's worked example is due.
const SAID: &str = "30 60 120";
/// A number of the program, and another one: then it has to print something else.
const PLANTED: (&str, &str) = ("120", "240");

/// The first code of a language in the section.
///
/// # Errors
/// There is none.
fn code<'a>(readme: &'a str, language: &str) -> Result<&'a str, String> {
    let begin = format!("```{language}\n");
    let section = readme.split_once(SECTION).map(|(_, rest)| rest.split("\n## ").next().unwrap_or(rest));
    let block =
        section.and_then(|section| section.split_once(&begin)).and_then(|(_, rest)| rest.split_once("```"));
    block.map(|(code, _)| code).ok_or_else(|| format!("{README}, {SECTION:?}: no code of {language}"))
}

/// An empty folder with the two files in it.
struct Project<'a> {
    workspace: &'a Workspace,
    folder: PathBuf,
    prefix: &'a Path,
}

impl<'a> Project<'a> {
    fn new(
        workspace: &'a Workspace,
        prefix: &'a Path,
        name: &str,
        files: [(&str, &str); 2],
    ) -> Result<Self, Failure> {
        let folder = workspace.target.join("abi").join(name);
        let _old = fs::remove_dir_all(&folder);
        folder_at(&folder)?;
        for (name, text) in files {
            write(&folder.join(name), text)?;
        }
        Ok(Self { workspace, folder, prefix })
    }

    /// Configured by CMake; what it said, and whether it is content.
    fn configure(&self, compiler: &str, shared: &str) -> Result<(String, bool), Failure> {
        let build = self.folder.join("build");
        let _old = fs::remove_dir_all(&build);
        let arguments = [
            "-S.".to_owned(),
            "-Bbuild".to_owned(),
            format!("-DCMAKE_CXX_COMPILER={compiler}"),
            format!("-DBUILD_SHARED_LIBS={shared}"),
            format!("-DCMAKE_PREFIX_PATH={}", self.prefix.display()),
            "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Wconversion -Werror".to_owned(),
        ];
        self.workspace.command("cmake").at(&self.folder).args(&arguments).all_text()
    }

    /// The program that CMake built.
    fn built(&self, compiler: &str, shared: &str) -> Result<PathBuf, Failure> {
        let (said, is_configured) = self.configure(compiler, shared)?;
        if !is_configured {
            return Err(Failure::Wrong(format!("{README}, {compiler}, shared {shared}:\n{said}")));
        }
        self.workspace.command("cmake").at(&self.folder).args(&["--build", "build"]).text()?;
        Ok(self.folder.join("build/example"))
    }

    /// The program that a compiler built with what pkg-config said.
    fn by_pkg_config(&self, compiler: &str, package: &str, is_static: bool) -> Result<PathBuf, Failure> {
        let ask = self.workspace.command("pkg-config").args(&["--cflags", "--libs"]);
        let ask = ask.args(if is_static { &["--static"] } else { &[] as &[&str] }).args(&[package]);
        let flags = ask.env("PKG_CONFIG_PATH", self.prefix.join("lib/pkgconfig")).capture()?;
        let flags: Vec<&str> = flags.split_whitespace().collect();
        let program = self.folder.join("example");
        let build = self.workspace.command(compiler).at(&self.folder).args(&["-std=c++17", "main.cpp"]);
        let build = build.args(if is_static { &["-static"] } else { &[] as &[&str] }).args(&flags);
        build.args(&["-o".as_ref(), program.as_path()]).text()?;
        Ok(program)
    }

    /// What a program prints, in one line; where it was not told, it finds the libraries here.
    fn said_by(&self, program: &Path) -> Result<String, Failure> {
        let said =
            self.workspace.command(program).env("LD_LIBRARY_PATH", self.prefix.join("lib")).capture()?;
        Ok(said.split_whitespace().collect::<Vec<_>>().join(" "))
    }
}

/// Builds and runs the README's program with what lies below a prefix; how many times.
///
/// # Errors
/// It does not build, prints something else, or is linked in another way than was asked for; or something planted is not
/// found.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let path = workspace.root.join(README);
    let readme = fs::read_to_string(&path).map_err(Failure::of_file(&path))?;
    let cmake = code(&readme, "cmake").map_err(Failure::Wrong)?;
    let main = code(&readme, "cpp").map_err(Failure::Wrong)?;
    let project = |name: &str, cmake: &str, main: &str| {
        Project::new(workspace, prefix, name, [("CMakeLists.txt", cmake), ("main.cpp", main)])
    };
    let example = project("example", cmake, main)?;
    let mut tried = 0;
    for compiler in ["g++", "clang++"] {
        for shared in ["OFF", "ON"] {
            judge(
                &example,
                &example.built(compiler, shared)?,
                shared == "ON",
                &format!("{compiler}, CMake"),
            )?;
            tried += 1;
        }
    }
    for package in ["red_core", "red"] {
        for is_static in [false, true] {
            let program = example.by_pkg_config("g++", package, is_static)?;
            judge(&example, &program, !is_static, &format!("g++, pkg-config {package}"))?;
            tried += 1;
        }
    }

    let other = project("planted-number", cmake, &main.replace(PLANTED.0, PLANTED.1))?;
    let said = other.said_by(&other.built("g++", "OFF")?)?;
    found("another deadline", said != SAID, &said)?;
    let two = project("planted-copies", &cmake.replace("red::core", "red::core red::runtime"), main)?;
    refused("two copies of the library", &two, "RED_LIBRARY")?;
    for version in ["0.0", "0.2", "1.0"] {
        let other = project("planted-version", &cmake.replace("red 0.1", &format!("red {version}")), main)?;
        refused(&format!("version {version}"), &other, "version")?;
    }
    Ok(tried)
}

/// That a program says what it should, and is linked as it was asked for.
fn judge(project: &Project<'_>, program: &Path, shared: bool, how: &str) -> Result<(), Failure> {
    let said = project.said_by(program)?;
    if said != SAID {
        return Err(Failure::Wrong(format!(
            "{how}: the program of {README} says {said:?}, and not {SAID:?}"
        )));
    }
    let loaded = elf::loaded(&read(program)?).map_err(|reason| super::build::unreadable(program, reason))?;
    let is_shared = loaded.needed.iter().any(|library| library.starts_with("libred"));
    if is_shared != shared {
        return Err(Failure::Wrong(format!(
            "{how}: shared is {is_shared}, asked for {shared}: {:?}",
            loaded.needed
        )));
    }
    say!("{how}, {}: {said}", if shared { "shared" } else { "static" });
    Ok(())
}

/// That CMake refuses a project, with these words.
fn refused(what: &str, project: &Project<'_>, words: &str) -> Result<(), Failure> {
    let (said, is_configured) = project.configure("g++", "OFF")?;
    let line = said.lines().find(|line| line.contains(words)).unwrap_or_default().trim();
    found(what, !is_configured && !line.is_empty(), line)
}

fn found(what: &str, is_found: bool, said: &str) -> Result<(), Failure> {
    if !is_found {
        return Err(Failure::Wrong(format!("{what} is not found, so this check finds nothing: {said}")));
    }
    say!("{what}: found, as it should be: {said}");
    Ok(())
}

#[cfg(test)]
mod tests;
