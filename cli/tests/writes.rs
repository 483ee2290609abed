//! Sources of the command: files are written in one place.

use std::fs;
use std::path::Path;

/// What makes a file, or puts one in another's place.
const WRITES: [&str; 9] = [
    "File::create",
    "File::options",
    "OpenOptions",
    "fs::write",
    "fs::rename",
    "fs::copy",
    "fs::hard_link",
    "symlink(",
    "Writer::start(",
];

/// The lines of a source that write past `place`.
fn past(source: &str) -> impl Iterator<Item = &str> {
    source.lines().filter(|line| WRITES.iter().any(|write| line.contains(write)))
}

#[test]
fn nothing_is_written_but_through_the_module_that_looks() {
    let sources = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let (mut folders, mut seen) = (vec![sources.clone()], 0);
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            let exempt = path.starts_with(sources.join("place")) || path.ends_with("tests.rs");
            if path.is_dir() {
                folders.push(path);
            } else if !exempt && path != sources.join("place.rs") {
                let source = fs::read_to_string(&path).unwrap();
                assert_eq!(past(&source).next(), None, "{}: write through `place`", path.display());
                seen += 1;
            }
        }
    }
    assert!(seen > 50, "{seen} sources");
    assert_eq!(past("let file = File::create(path)?;").count(), 1, "a planted one is seen");
}
