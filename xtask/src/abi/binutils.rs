//! Compiler, linker and archiver of a target.

use std::env::consts::ARCH;

use crate::cross::{self, AARCH64};
use crate::process::{Failure, Run};
use crate::tools;
use crate::workspace::Workspace;

/// Where libraries are for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Target {
    /// As rustc names it; none: this machine.
    pub(crate) triple: Option<String>,
    /// What the names of its binutils begin with.
    prefix: String,
    packages: &'static [&'static str],
}

/// Targets whose binutils are known: how the triple begins, what their names begin with, their packages in Debian.
const KNOWN: &[(&str, &str, &[&str])] = &[
    ("thumb", "arm-none-eabi-", &["binutils-arm-none-eabi"]),
    (AARCH64, "aarch64-linux-gnu-", &["gcc-aarch64-linux-gnu", "libc6-dev-arm64-cross"]),
];

impl Target {
    pub(crate) fn here() -> Self {
        Self { triple: None, prefix: String::new(), packages: &["gcc", "libc6-dev", "binutils"] }
    }

    /// The target of a name; `binutils` is what the names of its linker begin with, if that is given.
    ///
    /// # Errors
    /// Nothing is known of it, and nothing given: how to give it.
    pub(crate) fn of(triple: &str, binutils: Option<&str>) -> Result<Self, String> {
        if binutils.is_none() && triple == format!("{ARCH}-unknown-linux-gnu") {
            return Ok(Self::here());
        }
        let known = KNOWN.iter().find(|(begin, ..)| triple.starts_with(begin));
        let (prefix, packages) = match (binutils, known) {
            (Some(prefix), _) => (prefix, [].as_slice()),
            (None, Some((_, prefix, packages))) => (*prefix, *packages),
            (None, None) => {
                return Err(format!(
                    "no linker is known for {triple}: say what the names of its binutils begin with, as in --binutils \
                     riscv64-unknown-elf-"
                ));
            }
        };
        Ok(Self { triple: Some(triple.to_owned()), prefix: prefix.to_owned(), packages })
    }

    /// Whether programs there have an operating system below them, and so shared libraries.
    pub(crate) fn has_system(&self) -> bool {
        self.triple.as_ref().is_none_or(|triple| !triple.contains("-none"))
    }

    /// What rustc is told for the core. On AArch64 it would ask the C library which atomics the processor has.
    pub(crate) fn flags(&self) -> &'static [&'static str] {
        match self.triple.as_deref().unwrap_or(ARCH) {
            triple if triple.starts_with("aarch64") => &["-Ctarget-feature=-outline-atomics"],
            _ => &[],
        }
    }

    /// What cargo is told by its environment: the compiler of the C files, and the linker.
    pub(crate) fn environment(&self) -> Vec<(String, String)> {
        let Some(triple) = self.triple.as_ref().filter(|_| self.has_system()) else { return Vec::new() };
        let name = triple.replace('-', "_");
        let linker = format!("CARGO_TARGET_{}_LINKER", name.to_uppercase());
        [format!("CC_{name}"), linker].map(|variable| (variable, format!("{}gcc", self.prefix))).into()
    }

    /// One of its tools, installed if it is not there.
    ///
    /// # Errors
    /// It is missing and cannot be installed.
    pub(crate) fn tool(&self, workspace: &Workspace, name: &'static str) -> Result<Run, Failure> {
        let program = match (name, &*self.prefix) {
            ("cc", "") => "cc".to_owned(),
            ("cc", prefix) => format!("{prefix}gcc"),
            (name, prefix) => format!("{prefix}{name}"),
        };
        if workspace.command(&program).args(&["--version"]).output().is_err() {
            if self.packages.is_empty() {
                return Err(Failure::Wrong(format!(
                    "cannot start {program}: put it on the PATH, or give another --binutils"
                )));
            }
            tools::debian(workspace, name, self.packages)?;
        }
        Ok(workspace.command(program))
    }

    /// Everything that building for it takes, seen to before the long part begins.
    ///
    /// # Errors
    /// Something is missing and cannot be installed.
    pub(crate) fn prepare(&self, workspace: &Workspace) -> Result<(), Failure> {
        for name in ["ld.bfd", "objcopy", "ar"] {
            let _there = self.tool(workspace, name)?;
        }
        if self.has_system() {
            let _there = self.tool(workspace, "cc")?;
        }
        self.triple.as_ref().map_or(Ok(()), |triple| cross::library(workspace, triple))
    }
}

#[cfg(test)]
mod tests;
