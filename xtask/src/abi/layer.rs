//! The two libraries, of one package.

use crate::workspace::Workspace;

/// How much of the C ABI a library has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    /// Graphs and schedulers; nothing below it.
    Core,
    /// All functions, above an operating system.
    All,
}

/// What only the library with all functions has, by how names begin.
const ABOVE_THE_CORE: &[&str] = &["red_runtime_"];

impl Layer {
    pub(crate) const ALL: [Self; 2] = [Self::Core, Self::All];

    /// `lib<this>.a`, and the file for pkg-config.
    pub(crate) const fn library(self) -> &'static str {
        match self {
            Self::Core => "red_core",
            Self::All => "red",
        }
    }

    /// The profile that it is built in. The core has no panic to unwind from; the other ends panics at its border.
    pub(crate) const fn profile(self) -> &'static str {
        match self {
            Self::Core => "release-ffi",
            Self::All => "release",
        }
    }

    pub(crate) const fn features(self) -> &'static [&'static str] {
        match self {
            Self::Core => &["--no-default-features"],
            Self::All => &["--features", "counts"],
        }
    }

    /// Whether it has a function of the header.
    pub(crate) fn has(self, function: &str) -> bool {
        self == Self::All || ABOVE_THE_CORE.iter().all(|part| !function.starts_with(part))
    }
}

/// The version of both libraries, that of the workspace.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What the loader looks for: the major version.
pub(crate) fn soname(layer: Layer) -> String {
    format!("lib{}.so.{}", layer.library(), env!("CARGO_PKG_VERSION_MAJOR"))
}

/// Where the headers lie.
pub(crate) fn headers(workspace: &Workspace) -> std::path::PathBuf {
    workspace.root.join("ffi/include")
}
