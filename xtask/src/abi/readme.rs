//! The programs of the README, built from what stands there in an empty folder, in every way that is promised.

use std::fs;
use std::path::{Path, PathBuf};

use super::build::{folder_at, read, write};
use super::elf;
use crate::process::Failure;
use crate::workspace::Workspace;

const README: &str = "README.md";
const SECTION: &str = "## From C++";

/// A program of the section.
struct Program {
    /// What it is linked with, by CMake and by pkg-config.
    target: &'static str,
    packages: &'static [&'static str],
    /// What it prints begins so.
    said: &'static str,
    /// A number in it, and another one: then it has to print something else.
    planted: (&'static str, &'static str),
}

/// As they come.
const PROGRAMS: [Program; 2] = [
    // When the paper's worked example is due.
    Program {
        target: "red::core",
        packages: &["red_core", "red"],
        said: "30 60 120",
        planted: ("120", "240"),
    },
    // How many are on time is the machine's.
    Program {
        target: "red::runtime",
        packages: &["red"],
        said: "10 released, ",
        planted: ("0ms, 100ms", "0ms, 50ms"),
    },
];

/// All code of a language in the section.
fn code<'a>(readme: &'a str, language: &str) -> Vec<&'a str> {
    let begin = format!("```{language}\n");
    let section = readme.split_once(SECTION).map_or("", |(_, rest)| rest);
    let section = section.split("\n## ").next().unwrap_or_default();
    section.split(&begin).skip(1).filter_map(|rest| Some(rest.split_once("```")?.0)).collect()
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

/// Builds and runs the README's programs with what lies below a prefix; how many times.
///
/// # Errors
/// It does not build, prints something else, or is linked in another way than was asked for; or something planted is not
/// found.
pub(crate) fn check(workspace: &Workspace, prefix: &Path) -> Result<u32, Failure> {
    let path = workspace.root.join(README);
    let readme = fs::read_to_string(&path).map_err(Failure::of_file(&path))?;
    let none = |language| Failure::Wrong(format!("{README}, {SECTION:?}: no code of {language}"));
    let [cmake, ..] = code(&readme, "cmake")[..] else { return Err(none("cmake")) };
    let mains: [&str; PROGRAMS.len()] = code(&readme, "cpp").try_into().map_err(|_| none("cpp"))?;
    let mut tried = 0;
    for (program, main) in PROGRAMS.iter().zip(mains) {
        tried +=
            program.check(workspace, prefix, &cmake.replace(PROGRAMS[0].target, program.target), main)?;
    }

    let [main, _] = mains;
    let project = |name, cmake: &str| {
        Project::new(workspace, prefix, name, [("CMakeLists.txt", cmake), ("main.cpp", main)])
    };
    let two = project("planted-copies", &cmake.replace("red::core", "red::core red::runtime"))?;
    refused("two copies of the library", &two, "RED_LIBRARY")?;
    for version in ["0.0", "0.2", "1.0"] {
        let other = project("planted-version", &cmake.replace("red 0.1", &format!("red {version}")))?;
        refused(&format!("version {version}"), &other, "version")?;
    }
    Ok(tried)
}

impl Program {
    /// Builds and runs it in every way; how many there are.
    fn check(&self, workspace: &Workspace, prefix: &Path, cmake: &str, main: &str) -> Result<u32, Failure> {
        let project = |name, main: &str| {
            Project::new(workspace, prefix, name, [("CMakeLists.txt", cmake), ("main.cpp", main)])
        };
        let example = project("example", main)?;
        let mut tried = 0;
        for compiler in ["g++", "clang++"] {
            for shared in ["OFF", "ON"] {
                let built = example.built(compiler, shared)?;
                self.judge(&example, &built, shared == "ON", &format!("{compiler}, CMake"))?;
                tried += 1;
            }
        }
        for package in self.packages {
            for is_static in [false, true] {
                let built = example.by_pkg_config("g++", package, is_static)?;
                self.judge(&example, &built, !is_static, &format!("g++, pkg-config {package}"))?;
                tried += 1;
            }
        }
        let (number, other) = self.planted;
        let other = project("planted-number", &main.replace(number, other))?;
        let said = other.said_by(&other.built("g++", "OFF")?)?;
        found("another number", !said.starts_with(self.said), &said)?;
        Ok(tried)
    }

    /// That it says what it should, and is linked as it was asked for.
    fn judge(&self, project: &Project<'_>, built: &Path, shared: bool, how: &str) -> Result<(), Failure> {
        let said = project.said_by(built)?;
        let should = self.said;
        if !said.starts_with(should) {
            return Err(Failure::Wrong(format!(
                "{how}: the program of {README} says {said:?}, and not {should:?}"
            )));
        }
        let loaded = elf::loaded(&read(built)?).map_err(|reason| super::build::unreadable(built, reason))?;
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
