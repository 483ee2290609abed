use std::time::{Duration, SystemTime};
use std::{env, process};

use super::*;

#[test]
fn a_copy_is_what_the_workspace_is_and_what_is_the_same_keeps_its_time() {
    let root = env::temp_dir().join(format!("red-copy-{}", process::id()));
    let (from, to) = (root.join("from"), root.join("to"));
    let write = |path: PathBuf, text: &str| {
        fs::create_dir_all(path.parent().expect("in a folder")).expect("a folder for the test");
        fs::write(path, text).expect("a file for the test");
    };
    let read = |name: &str| fs::read_to_string(to.join(name)).ok();
    let all = |path: &Path| !path.ends_with("target");
    write(from.join("a/kept.rs"), "the same");
    write(from.join("a/changed.rs"), "right");
    write(from.join("target/built"), "large");
    write(to.join("a/changed.rs"), "a mutant");
    write(to.join("a/removed.rs"), "of an earlier run");
    write(to.join("b/removed.rs"), "of an earlier run");
    mirror(&from, &to, &all).expect("a copy");
    assert_eq!((read("a/kept.rs"), read("a/changed.rs")), (Some("the same".into()), Some("right".into())));
    assert!(!to.join("a/removed.rs").exists() && !to.join("b").exists() && !to.join("target").exists());

    let old = SystemTime::UNIX_EPOCH + Duration::from_secs(1);
    let kept = fs::File::options().write(true).open(to.join("a/kept.rs")).expect("the copy");
    kept.set_modified(old).expect("a time");
    mirror(&from, &to, &all).expect("a copy again");
    let modified = fs::metadata(to.join("a/kept.rs")).and_then(|file| file.modified());
    assert_eq!(modified.expect("a time"), old);
    fs::remove_dir_all(root).expect("it goes away");
}
