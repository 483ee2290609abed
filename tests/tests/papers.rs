//! What the papers point to is there.

use std::fs;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The papers, relative to the root.
fn papers() -> Vec<String> {
    let decisions = fs::read_dir(root().join("docs/decisions")).expect("decisions are recorded");
    let names = decisions.map(|entry| entry.expect("an entry").file_name().display().to_string());
    let mut papers: Vec<String> = names.map(|name| format!("docs/decisions/{name}")).collect();
    let others = [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "docs/glossary.md",
        "docs/overload.md",
        "docs/paper-map.md",
        "docs/paper.md",
        "docs/targets.md",
        "examples/embassy-qemu/README.md",
        "docs/workload-file.md",
        "workload/README.md",
    ];
    papers.extend(others.map(str::to_owned));
    papers
}

/// Targets of links, and files and folders in backquotes that are named from the root.
fn pointers(text: &str) -> Vec<String> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let local = links.filter(|link| !link.contains("://") && !link.starts_with('#'));
    let quoted = text.split('`').skip(1).step_by(2);
    let file = |name: &&str| {
        name.contains('/')
            && !name.contains(' ')
            && [".rs", ".md", ".toml"].iter().any(|kind| name.ends_with(kind))
    };
    local.chain(quoted.filter(file)).map(str::to_owned).collect()
}

/// Whether a pointer leads somewhere: from the paper's folder, the root, or the core's sources.
fn leads_somewhere(paper: &str, pointer: &str) -> bool {
    let beside = Path::new(paper).parent().unwrap_or(Path::new(""));
    [beside, Path::new(""), Path::new("core-nostd/src"), Path::new("core-nostd/src/scheduler")]
        .iter()
        .any(|folder| root().join(folder).join(pointer).exists())
}

#[test]
fn every_pointer_leads_somewhere() {
    assert_eq!(pointers("`a/b.rs` and [c](d.md), not `Scheduler` or `a b/c.rs`"), ["d.md", "a/b.rs"]);
    assert!(!leads_somewhere("README.md", "docs/planted.md"));
    let mut astray = Vec::new();
    for paper in papers() {
        let text = fs::read_to_string(root().join(&paper)).expect("the paper is there");
        let wrong = pointers(&text).into_iter().filter(|pointer| !leads_somewhere(&paper, pointer));
        astray.extend(wrong.map(|pointer| format!("{paper}: {pointer}")));
    }
    assert!(astray.is_empty(), "{}", astray.join("\n"));
}

#[test]
fn decisions_are_numbered_without_gaps_and_say_why_and_at_what_cost() {
    let mut names: Vec<String> = papers().into_iter().filter(|name| name.contains("decisions/")).collect();
    names.sort();
    for (at, name) in names.iter().enumerate() {
        let number = format!("{:04}", at + 1);
        let text = fs::read_to_string(root().join(name)).expect("the decision is there");
        assert!(name.contains(&format!("/{number}-")) && text.starts_with(&format!("# {number} ")), "{name}");
        assert!(text.contains("*Choice.*") && text.contains("*Cost.*"), "{name}");
    }
}

/// Crates of others that a manifest names.
fn dependencies(manifest: &str) -> Vec<&str> {
    let mut inside = false;
    let mut found = Vec::new();
    for line in manifest.lines() {
        if line.starts_with('[') {
            inside = line.ends_with("dependencies]");
        } else if let Some((name, _)) =
            line.split_once([' ', '.', '=']).filter(|_| inside && !line.starts_with('#'))
        {
            found.push(name);
        }
    }
    found.retain(|name| !name.starts_with("red-"));
    found
}

#[test]
fn every_dependency_has_its_reason() {
    let planted = "[target.'cfg(loom)'.dependencies]\nloom = \"0.7\"\nred-core.workspace = true\n[lints]\nworkspace = true";
    assert_eq!(dependencies(planted), ["loom"]);
    let decision =
        fs::read_to_string(root().join("docs/decisions/0001-dependencies.md")).expect("it is there");
    // Packages lie in the root and one folder below.
    let below = |folder: &Path| -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).into_iter().flatten();
        entries.map(|entry| entry.expect("an entry").path()).collect()
    };
    let folders = below(&root()).into_iter().flat_map(|folder| below(&folder).into_iter().chain([folder]));
    let manifests: Vec<PathBuf> =
        folders.map(|folder| folder.join("Cargo.toml")).filter(|file| file.exists()).collect();
    assert!(manifests.iter().any(|file| file.ends_with("core-nostd/embassy/Cargo.toml")), "{manifests:?}");
    for manifest in manifests {
        let text = fs::read_to_string(&manifest).expect("a manifest is text");
        for name in dependencies(&text) {
            assert!(
                decision.contains(&format!("`{name}`")),
                "{name} of {} has no reason",
                manifest.display()
            );
        }
    }
}
