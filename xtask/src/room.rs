//! Room on the disk. What a step built for itself alone stays for the next time, unless room is scarce.

use std::fs;

use crate::workspace::Workspace;

/// Steps, and folders of the target folder that no step after them uses.
const OWN: &[(&str, &[&str])] = &[
    ("clients", &["clients"]),
    ("onnx", &["venv"]),
    ("fuzz", &["fuzz"]),
    ("miri", &["miri"]),
    ("sanitizers", &["address", "thread"]),
    ("loom", &["loom"]),
];

/// What any step may still need, and the packages that it installs.
const SCARCE_MIB: u64 = 6 << 10;

/// MiB free where things are built, as far as this can be told.
pub(crate) fn free_mib(workspace: &Workspace) -> Option<u64> {
    let ask = workspace.command("df").args(&["--output=avail", "--block-size=1M"]).args(&[&workspace.root]);
    ask.output().ok()?.lines().last()?.trim().parse().ok()
}

/// After a step: removes what no later one uses, where less is free than they may need.
pub(crate) fn make(workspace: &Workspace, step: &str, free_mib: Option<u64>) {
    if free_mib.is_none_or(|free| free >= SCARCE_MIB) {
        return;
    }
    for folder in OWN.iter().filter(|(name, _)| *name == step).flat_map(|(_, folders)| *folders) {
        // What cannot be removed is in nobody's way but the disk's.
        if fs::remove_dir_all(workspace.target.join(folder)).is_ok() {
            say!("room is scarce: removed {folder} from the target folder");
        }
    }
}

#[cfg(test)]
mod tests;
