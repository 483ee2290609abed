use std::fs::{self, File};
use std::io::Write;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::Command;

use proptest::prelude::*;

use super::{Format, MAX_FILE_BYTES, Source, load, parse};
use crate::Refusal::{NotAFile, TooLarge, Unreadable};
use crate::fixtures::{EXAMPLE_TOML, EXAMPLE_YAML};

/// A folder of its own for each test, removed in the end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("red-workload-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        fs::remove_dir_all(&self.0).unwrap();
    }
}

#[test]
fn the_ending_tells_the_format() {
    let folder = Folder::new("formats");
    let expected = parse(EXAMPLE_TOML.as_bytes(), Format::Toml, "").unwrap();
    for (name, text) in [("a.toml", EXAMPLE_TOML), ("a.yaml", EXAMPLE_YAML), ("a.YML", EXAMPLE_YAML)] {
        fs::write(folder.path(name), text).unwrap();
        assert_eq!(load(&folder.path(name)).as_ref(), Ok(&expected), "{name}");
    }
    assert_eq!(Format::of(Path::new("workload")), Format::Toml);
}

#[test]
fn only_regular_files_are_read() {
    let folder = Folder::new("kinds");
    assert!(Command::new("mkfifo").arg(folder.path("fifo")).status().unwrap().success());
    symlink(folder.path("loop"), folder.path("loop")).unwrap();
    let cases = [
        (folder.0.clone(), NotAFile),
        (folder.path("fifo"), NotAFile),
        (PathBuf::from("/dev/zero"), NotAFile),
        (folder.path("loop"), Unreadable),
        (folder.path("absent.toml"), Unreadable),
        (folder.path("absent.toml/below"), Unreadable),
        (PathBuf::new(), Unreadable),
        (PathBuf::from("a\0b"), Unreadable),
    ];
    for (path, expected) in cases {
        let error = load(&path).unwrap_err();
        assert_eq!(error.refusal, expected, "{error}");
        assert!(error.place.is_none() && error.to_string().len() < 2000, "{error}");
    }
}

#[test]
fn a_large_file_is_refused_by_its_size() {
    let folder = Folder::new("sizes");
    let sparse = folder.path("sparse.toml");
    File::create(&sparse).unwrap().set_len(1 << 40).unwrap();
    assert_eq!(load(&sparse).unwrap_err().refusal, TooLarge);
    let full = folder.path("full.toml");
    let mut file = File::create(&full).unwrap();
    file.write_all(EXAMPLE_TOML.as_bytes()).unwrap();
    file.write_all(&vec![b'\n'; MAX_FILE_BYTES as usize - EXAMPLE_TOML.len()]).unwrap();
    assert!(load(&full).is_ok());
    file.write_all(b"\n").unwrap();
    assert_eq!(load(&full).unwrap_err().refusal, TooLarge);
}

#[test]
fn a_source_knows_where_its_bodies_are() {
    let text = "\u{feff}pool = [{ name = 'p', lanes = 1 }]\r\n[[task]]\nname = 't'\ndeadline = '1s'\nonce = true\n\
                node = [{ name = 'a', wcet = '1ms', body = { spin = '1ms' } },\n{ name = 'b', wcet = '1ms' }, \
                { name = 's', mimonet = { weights = 'w', frame = 'f', encoder = { wcet = '1ms' }, decoders = [\n\
                { name = 'd', wcet = '1ms', body = { onnx = 'd.onnx' } }] } }]\n\
                [[event]]\nat = '2s'\ntask = 't'\nadd = [{ name = 'z', wcet = '1ms' }]\n\
                [[event]]\nat = '1s'\ntask = 't'\nadd = [{ name = 'y', wcet = '1ms' }]\n";
    let source = Source::parse(text.as_bytes(), Format::Toml, Path::new("dir/w.toml")).unwrap();
    // As nodes are numbered: stages in place, then events by their instants.
    let places = [(6, 44), (7, 1), (7, 95), (8, 36), (16, 8), (12, 8)];
    for (part, (line, column)) in places.into_iter().enumerate() {
        assert_eq!(source.body(0, part), format!("dir/w.toml:{line}:{column}"));
    }
    assert_eq!((source.body(0, 6), source.body(1, 0)), ("dir/w.toml".to_owned(), "dir/w.toml".to_owned()));
    assert_eq!(source.folder(), Path::new("dir"));
    assert_eq!(
        Source::parse(text.as_bytes(), Format::Toml, Path::new("w")).unwrap().folder(),
        Path::new(".")
    );
}

/// Whatever the bytes are, there is an answer, and a refusal is short and printable.
fn check_answer(bytes: &[u8]) {
    for format in [Format::Toml, Format::Yaml] {
        if let Err(error) = parse(bytes, format, "w") {
            let message = error.to_string();
            assert!(message.chars().count() <= 2000, "{message}");
            assert!(!message.chars().any(char::is_control), "{message:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::with_cases(512)
    })]

    #[test]
    fn any_bytes_have_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        check_answer(&bytes);
    }

    #[test]
    fn any_text_of_the_languages_has_an_answer(text in "([\\[\\]{}=:.,#&*!|>\"' \n-]|[a-z0-9é]){0,200}") {
        check_answer(text.as_bytes());
    }

    #[test]
    fn any_mutation_of_a_valid_file_has_an_answer(
        yaml in any::<bool>(),
        edits in prop::collection::vec((any::<prop::sample::Index>(), 0..6_usize, any::<u8>()), 1..6),
    ) {
        let mut bytes = if yaml { EXAMPLE_YAML } else { EXAMPLE_TOML }.as_bytes().to_vec();
        for (index, length, replacement) in edits {
            let start = index.index(bytes.len());
            let end = (start + length).min(bytes.len());
            bytes.splice(start..end, [replacement].into_iter().take(length + 1));
        }
        check_answer(&bytes);
    }

    #[test]
    fn any_truncation_of_a_valid_file_has_an_answer(length in 0..EXAMPLE_TOML.len()) {
        check_answer(&EXAMPLE_TOML.as_bytes()[..length]);
        check_answer(&EXAMPLE_YAML.as_bytes()[..length.min(EXAMPLE_YAML.len())]);
    }
}
