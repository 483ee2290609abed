//! Rows 75 and 76: dependencies and targets.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The folder for everything built, in which `cargo xtask` keeps its tools.
fn target() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().expect("a folder of the target folder")
}

fn told(output: &Output) -> String {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    text(&output.stdout) + &text(&output.stderr)
}

/// What `cargo xtask test deny` asks of a workspace, by the rules of this one.
fn deny(manifest: &Path) -> (bool, String) {
    let program = target().join("tools/bin/cargo-deny");
    assert!(program.is_file(), "no {}; install it with: cargo xtask test deny", program.display());
    let config = root().join("deny.toml");
    let mut command = Command::new(program);
    command.arg("--manifest-path").arg(manifest).arg("--offline").arg("--config").arg(config);
    let output = command.args(["check", "bans", "licenses", "sources"]).output().expect("it is there");
    (output.status.success(), told(&output))
}

/// A workspace of one package with these dependencies, which are packages of this name, version and licence.
fn planted(name: &str, dependencies: &[(&str, &str, &str, &str)], more: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _none_there = fs::remove_dir_all(&folder);
    let package = |folder: &Path, name: &str, version: &str, license: &str, rest: &str| {
        fs::create_dir_all(folder.join("src")).expect("the folder for tests takes folders");
        fs::write(folder.join("src/lib.rs"), "").expect("and files");
        let text = format!(
            "[package]\nname = \"{name}\"\nversion = \"{version}\"\nedition = \"2024\"\nlicense = \"{license}\"\n{rest}"
        );
        fs::write(folder.join("Cargo.toml"), text).expect("and files");
    };
    let mut rest = format!("publish = false\n[workspace]\nexclude = [\"d\"]\n[dependencies]\n{more}");
    for (key, of, version, license) in dependencies {
        package(&folder.join("d").join(key), of, version, license, "");
        rest += &format!("{key} = {{ path = \"d/{key}\", package = \"{of}\", version = \"{version}\" }}\n");
    }
    package(&folder, "planted", "0.1.0", "MIT", &rest);
    folder.join("Cargo.toml")
}

#[test]
fn row_75_a_new_duplicate_licence_or_source_stops_at_the_gate() {
    let (passes, said) = deny(&root().join("Cargo.toml"));
    assert!(passes, "{said}");
    let (passes, said) = deny(&planted("row-75-clean", &[("one", "one", "1.0.0", "MIT")], ""));
    assert!(passes, "the gate speaks about what is right: {said}");
    let twice = [("one", "twice", "1.0.0", "MIT"), ("two", "twice", "2.0.0", "MIT")];
    let (passes, said) = deny(&planted("row-75-duplicate", &twice, ""));
    assert!(!passes && said.contains("duplicate entries for crate 'twice'"), "{said}");
    let (passes, said) = deny(&planted("row-75-licence", &[("one", "one", "1.0.0", "GPL-3.0-only")], ""));
    assert!(!passes && said.contains("GPL-3.0-only") && said.contains("not explicitly allowed"), "{said}");
    // A source: a repository here stands for one elsewhere.
    let source = planted("row-75-repository", &[], "");
    let repository = source.parent().expect("its folder").to_str().expect("UTF-8");
    let git = |arguments: &[&str]| {
        let identity = [
            "-c",
            "user.name=planted",
            "-c",
            "user.email=planted@localhost",
            "-c",
            "init.defaultBranch=main",
        ];
        let status = Command::new("git").args(identity).arg("-C").arg(repository).args(arguments).output();
        let status = status.expect("no git; install it with: apt-get install git");
        assert!(status.status.success(), "{}", told(&status));
    };
    git(&["init", "--quiet"]);
    git(&["add", "."]);
    git(&["commit", "--quiet", "--no-gpg-sign", "-m", "planted"]);
    let more = format!("planted-source = {{ git = \"file://{repository}\", package = \"planted\" }}\n");
    let manifest = planted("row-75-source", &[], &more);
    // Its own name is taken.
    let text =
        fs::read_to_string(&manifest).expect("UTF-8").replacen("name = \"planted\"", "name = \"reader\"", 1);
    fs::write(&manifest, text).expect("our own file");
    let mut fetch = Command::new(env!("CARGO"));
    let fetched =
        fetch.args(["generate-lockfile", "--manifest-path"]).arg(&manifest).output().expect("cargo");
    assert!(fetched.status.success(), "{}", told(&fetched));
    let (passes, said) = deny(&manifest);
    assert!(!passes && said.contains("source") && said.contains("not explicitly allowed"), "{said}");
}

/// A processor without compare-and-swap, and one without 64-bit atomics.
const TARGETS: [&str; 2] = ["thumbv6m-none-eabi", "thumbv7em-none-eabihf"];

fn cargo(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO"));
    command.current_dir(root()).args(arguments).env("CARGO_TARGET_DIR", target());
    command.output().expect("cargo")
}

#[test]
fn row_76_targets_without_64_bit_atomics_build_and_schedule() {
    for triple in TARGETS {
        let libraries = Command::new("rustc").args(["--print", "target-libdir", "--target", triple]).output();
        let libraries = libraries.expect("no rustc; install it with rustup");
        let folder = String::from_utf8_lossy(&libraries.stdout).trim().to_owned();
        assert!(Path::new(&folder).is_dir(), "no core library; install it with: rustup target add {triple}");
        for package in ["red-core", "red-sync"] {
            let built = cargo(&["build", "--quiet", "--package", package, "--target", triple]);
            assert!(built.status.success(), "{package} for {triple}: {}", told(&built));
        }
    }
    // In the emulator: random workloads, and every action as on this machine.
    let compared = cargo(&["xtask", "traces", "--count", "3"]);
    assert!(compared.status.success(), "{}", told(&compared));
}
