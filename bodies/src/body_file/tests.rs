use std::env;
use std::os::unix::fs::symlink;
use std::process::{self, Command};

use super::*;

/// A folder with `in/a` and `out/b`, and links from `in` to these and to `in`.
fn folder(test: &str) -> PathBuf {
    let folder = env::temp_dir().join(format!("red-body-file-{}-{test}", process::id()));
    for name in ["in/a", "out/b"] {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().expect("a folder")).expect("the temporary directory is writable");
        fs::write(path, "0123456789").expect("the temporary directory is writable");
    }
    let links = [("a", "good"), ("../out/b", "bad"), ("../out", "elsewhere"), ("loop", "loop")];
    for (to, link) in links {
        symlink(to, folder.join("in").join(link)).expect("the link is new");
    }
    symlink("in", folder.join("named")).expect("the link is new");
    folder
}

#[test]
fn links_may_not_lead_out_of_the_folder() {
    let root = folder("links");
    for folder in ["in", "named"].map(|name| root.join(name)) {
        for (name, expected) in [("a", "in/a"), ("good", "in/a"), ("./elsewhere/../in/a", "in/a")] {
            let path = within(&folder, Path::new(name)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!(path, fs::canonicalize(root.join(expected)).expect("it is there"));
        }
        for name in ["bad", "elsewhere/b", "../out/b", "/dev/null"] {
            let error = within(&folder, Path::new(name)).expect_err(name);
            assert!(matches!(error, BodyError::Outside { .. }), "{name}: {error}");
        }
        for name in ["absent", "loop", "a/b", "a\0b"] {
            let error = within(&folder, Path::new(name)).expect_err(name);
            assert!(matches!(error, BodyError::Read { .. }), "{name}: {error}");
        }
    }
    fs::remove_dir_all(root).expect("the folder was there");
}

#[test]
fn only_regular_files_of_bounded_size_are_opened() {
    let root = folder("kinds");
    let fifo = root.join("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().expect("coreutils").success());
    for path in [&fifo, &root, Path::new("/dev/zero")] {
        assert!(matches!(open(path, 10), Err(BodyError::NotAFile { .. })), "{path:?}");
    }
    let file = root.join("in/a");
    let (opened, size) = open(&file, 10).expect("ten bytes");
    assert_eq!((read(opened, size).expect("readable"), size), (b"0123456789".to_vec(), 10));
    assert!(matches!(open(&file, 9), Err(BodyError::TooLarge { most: 9, .. })));
    let (opened, size) = open(&file, 10).expect("ten bytes");
    File::options().append(true).open(&file).and_then(|file| file.set_len(1 << 40)).expect("a sparse file");
    assert_eq!(read(opened, size).expect("readable").len(), 10, "what was added meanwhile is left");
    assert!(matches!(open(&file, 10), Err(BodyError::TooLarge { .. })));
    fs::remove_dir_all(root).expect("the folder was there");
}
