//! The lock files hold what the manifests ask for: a build of one that does not would change it, aloud nowhere.

use crate::process::Failure;
use crate::workspace::Workspace;

/// The packages that have a lock file: the workspace, and what fuzzes it.
const MANIFESTS: [&str; 2] = ["Cargo.toml", "fuzz/Cargo.toml"];

/// # Errors
/// One does not. What cargo says names it.
pub(crate) fn check(workspace: &Workspace) -> Result<(), Failure> {
    MANIFESTS.iter().try_for_each(|manifest| holds(workspace, manifest))
}

fn holds(workspace: &Workspace, manifest: &str) -> Result<(), Failure> {
    workspace.cargo(&["fetch", "--quiet", "--locked", "--manifest-path", manifest]).stream().map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_manifest_that_asks_for_more_is_seen() {
        let folder = std::env::temp_dir().join(format!("red-lock-files-{}", std::process::id()));
        let manifest = folder.join("Cargo.toml");
        let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
        let package =
            |name: &str| format!("[package]\nname = '{name}'\nversion = '0.1.0'\nedition = '2024'\n");
        std::fs::create_dir_all(folder.join("src")).unwrap();
        std::fs::create_dir_all(folder.join("new/src")).unwrap();
        write("src/lib.rs", "");
        write("new/src/lib.rs", "");
        write("new/Cargo.toml", &package("new"));
        write("Cargo.toml", &package("old"));
        let workspace = Workspace::here();
        let manifest = manifest.to_str().unwrap();
        workspace.cargo(&["generate-lockfile", "--manifest-path", manifest]).capture().unwrap();
        assert!(holds(&workspace, manifest).is_ok());
        write("Cargo.toml", &format!("{}[dependencies]\nnew.path = 'new'\n", package("old")));
        assert!(holds(&workspace, manifest).is_err());
        std::fs::remove_dir_all(folder).unwrap();
    }
}
