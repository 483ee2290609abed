//! The library that the tests are built with: as it ships, or with a sanitizer in it.

use std::fs;
use std::path::{Path, PathBuf};

use crate::nightly::{HOST, Nightly};
use crate::process::Failure;
use crate::sanitizers::sanitized;
use crate::workspace::Workspace;

/// ThreadSanitizer's runtime among the libraries of the toolchain.
const THREAD_RUNTIME: &str = "librustc-nightly_rt.tsan.a";

/// Which one.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Library {
    Shipped,
    /// The same sources with AddressSanitizer in them, and with the checks that a release leaves out.
    Address,
    /// With ThreadSanitizer, in the standard library too, whose synchronisation it has to see.
    Thread,
}

impl Library {
    /// Where it is installed; the one that ships is already.
    ///
    /// # Errors
    /// It does not build, or cannot be copied.
    pub(super) fn installed(
        self,
        workspace: &Workspace,
        nightly: &Nightly<'_>,
        shipped: &Path,
    ) -> Result<PathBuf, Failure> {
        let (sanitizer, flags): (_, &[&str]) = match self {
            Self::Shipped => return Ok(shipped.to_path_buf()),
            Self::Address => ("address", &[]),
            Self::Thread => ("thread", &["-Zbuild-std"]),
        };
        let library = ["--package", "red-ffi", "--features", "counts", "--lib", "--crate-type", "staticlib"];
        // As tests are built: without it a scheduler takes so long that every task of a test is late.
        let build = sanitized(nightly, sanitizer, "rustc").env("CARGO_PROFILE_DEV_OPT_LEVEL", "1");
        build.args(flags).args(&library).stream()?;

        let prefix = shipped.with_extension(sanitizer);
        let lib = prefix.join("lib");
        let _old = fs::remove_dir_all(&prefix);
        fs::create_dir_all(&lib).map_err(Failure::of_file(&lib))?;
        // No other library is there that might be linked in its place.
        for (part, to) in [("include", &prefix), ("lib/cmake", &lib)] {
            workspace.command("cp").args(&["-r"]).args(&[&shipped.join(part), to]).stream()?;
        }
        let built = nightly.target(sanitizer).join(HOST).join("debug/libred_ffi.a");
        copy(&built, &lib.join("libred.a"))?;
        if self == Self::Thread {
            copy(&nightly.libraries()?.join(THREAD_RUNTIME), &lib.join(THREAD_RUNTIME))?;
        }
        Ok(prefix)
    }

    /// What the tests are told of it.
    pub(super) fn option(self, prefix: &Path) -> Option<String> {
        match self {
            Self::Shipped => None,
            Self::Address => Some("-DRED_SANITIZE=address,undefined".to_owned()),
            Self::Thread => Some(format!("-DRED_TSAN={}", prefix.join("lib").join(THREAD_RUNTIME).display())),
        }
    }
}

fn copy(from: &Path, to: &Path) -> Result<(), Failure> {
    fs::copy(from, to).map(drop).map_err(Failure::of_file(from))
}
