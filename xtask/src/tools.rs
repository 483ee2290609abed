//! Tools that the steps need and a fresh machine lacks: installed where that needs no question.

use std::fs;
use std::path::{Path, PathBuf};

use crate::process::{Failure, Run};
use crate::report::Tally;
use crate::workspace::{Workspace, entries};

/// The version of cargo-deny that `deny.toml` is written for.
const CARGO_DENY: &str = "0.20.2";

/// Python with what `models/reference-requirements.txt` names, in a folder of its own.
pub(crate) struct Python<'a> {
    workspace: &'a Workspace,
    folder: PathBuf,
}

impl Python<'_> {
    /// Runs the generator of the models.
    ///
    /// # Errors
    /// It fails, or finds a difference.
    pub(crate) fn generate(&self, arguments: &[&str]) -> Result<Tally, Failure> {
        self.workspace
            .command(self.folder.join("bin/python"))
            .args(&["models/generate.py"])
            .args(arguments)
            .stream()
    }

    /// The packages that a file names, in a folder of this name, which is not Python's own.
    ///
    /// # Errors
    /// They cannot be had.
    pub(crate) fn packages(&self, requirements: &Path, name: &str) -> Result<PathBuf, Failure> {
        let folder = self.workspace.target.join("packages").join(name);
        let wanted = read(&self.workspace.root.join(requirements))?;
        let stamp = folder.join("installed-requirements.txt");
        if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
            return Ok(folder);
        }
        let install =
            ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "--upgrade"];
        let pip = self.workspace.command(self.folder.join("bin/python")).args(&install);
        pip.args(&["--target"]).args(&[&folder]).args(&["-r"]).args(&[requirements]).stream()?;
        fs::write(&stamp, wanted).map_err(Failure::of_file(&stamp))?;
        Ok(folder)
    }

    /// The shared library of onnxruntime.
    ///
    /// # Errors
    /// It is not where its package puts it.
    pub(crate) fn onnxruntime(&self) -> Result<PathBuf, Failure> {
        let lib = self.folder.join("lib");
        let inside = |name: &Path| name.join("site-packages/onnxruntime/capi");
        let libraries = entries(&lib)?.into_iter().map(|python| inside(&python)).filter(|capi| capi.is_dir());
        let mut files = Vec::new();
        for capi in libraries {
            files.extend(entries(&capi)?);
        }
        let is_library = |path: &PathBuf| {
            path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libonnxruntime.so"))
        };
        files.into_iter().find(is_library).ok_or_else(|| {
            Failure::Wrong(format!(
                "no libonnxruntime.so below {}; remove that folder and try again",
                lib.display()
            ))
        })
    }
}

/// Python, its folder made and filled if it is not there or not up to date.
///
/// # Errors
/// Python is missing and cannot be installed, or its packages cannot be had.
pub(crate) fn python(workspace: &Workspace) -> Result<Python<'_>, Failure> {
    let folder = workspace.target.join("venv");
    let python = Python { workspace, folder: folder.clone() };
    let models = workspace.root.join("models");
    let wanted = ["requirements.txt", "reference-requirements.txt"]
        .map(|name| read(&models.join(name)))
        .into_iter()
        .collect::<Result<String, _>>()?;
    let stamp = folder.join("installed-requirements.txt");
    if fs::read_to_string(&stamp).is_ok_and(|installed| installed == wanted) {
        return Ok(python);
    }
    // `ensurepip` is the part of the virtual environments that Debian packs apart.
    let complete = workspace.command("python3").args(&["-c", "import ensurepip, venv"]).output();
    if complete.is_err() {
        debian(workspace, "python3 with venv", &["python3", "python3-venv"])?;
    }
    workspace.command("python3").args(&["-m", "venv"]).args(&[&folder]).stream()?;
    let install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r"];
    let requirements = models.join("reference-requirements.txt");
    workspace.command(folder.join("bin/python")).args(&install).args(&[requirements]).stream()?;
    fs::write(&stamp, wanted).map_err(Failure::of_file(&stamp))?;
    Ok(python)
}

/// cargo-deny, built into the target folder if that version is not there.
///
/// # Errors
/// It cannot be built.
pub(crate) fn cargo_deny(workspace: &Workspace) -> Result<Run, Failure> {
    built(workspace, "cargo-deny", CARGO_DENY, &["--version"])
}

/// A tool of cargo, built into the target folder if `asks` is not answered with that version.
///
/// # Errors
/// It cannot be built.
pub(crate) fn built(workspace: &Workspace, name: &str, version: &str, asks: &[&str]) -> Result<Run, Failure> {
    let folder = workspace.target.join("tools");
    let program = folder.join("bin").join(name);
    let there = workspace.command(&program).args(asks).output();
    if !there.is_ok_and(|answer| answer.ends_with(version)) {
        // Soon built, and small.
        let how = ["install", "--debug", "--config", "profile.dev.debug=false", "--locked", "--quiet"];
        let what = [name, "--version", version, "--root"];
        workspace.cargo(&how).args(&what).args(&[&folder]).stream()?;
    }
    Ok(workspace.command(program))
}

/// A program, its packages installed if it is not there.
///
/// # Errors
/// It is missing and cannot be installed.
pub(crate) fn present(
    workspace: &Workspace,
    program: &'static str,
    packages: &[&str],
) -> Result<(), Failure> {
    match workspace.command(program).args(&["--version"]).output() {
        Ok(_) => Ok(()),
        Err(_) => debian(workspace, program, packages),
    }
}

/// Installs packages of Debian, if this is one and we may.
///
/// # Errors
/// It is none, we may not, or they cannot be had.
pub(crate) fn debian(workspace: &Workspace, what: &'static str, packages: &[&str]) -> Result<(), Failure> {
    let install =
        format!("apt-get update && apt-get install -y --no-install-recommends {}", packages.join(" "));
    let is_root = workspace.command("id").args(&["-u"]).output().is_ok_and(|id| id == "0");
    if !is_root || !Path::new("/etc/debian_version").exists() {
        return Err(Failure::Missing { what, install: format!("sudo sh -c '{install}'") });
    }
    workspace
        .command("sh")
        .args(&["-c", &install])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stream()
        .map(drop)
}

fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(Failure::of_file(path))
}
