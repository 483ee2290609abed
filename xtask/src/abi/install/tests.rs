use super::*;

#[test]
fn a_wish_says_where_to() {
    let wish = Wish::of(&["--target", "thumbv7em-none-eabihf", "--prefix", "/opt/red"]).unwrap();
    assert_eq!((wish.prefix.as_path(), wish.target.has_system()), (Path::new("/opt/red"), false));
    assert!(Wish::of(&["--prefix", "here"]).unwrap().prefix.is_absolute());
    for (words, part) in [
        (&[][..], "--prefix"),
        (&["--prefix"], "value"),
        (&["--folder", "/opt"], "--folder"),
        (&["--prefix", "/opt", "--binutils", "x-"], "--target"),
        (&["--prefix", "/opt", "--target", "avr-unknown-none"], "--binutils"),
    ] {
        let reason = Wish::of(words).unwrap_err();
        assert!(reason.contains(part), "{words:?}: {reason}");
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_told_with_what_to_do() {
    let file = std::env::temp_dir().join(format!("red-install-{}", std::process::id()));
    fs::write(&file, "a file, and no folder").unwrap();
    let failure = writable(&file.join("below")).unwrap_err().to_string();
    fs::remove_file(&file).unwrap();
    assert!(failure.contains("below") && failure.contains("--prefix"), "{failure}");
}

#[test]
fn what_is_installed_again_replaces_what_was_there() {
    let folder = std::env::temp_dir().join(format!("red-put-{}", std::process::id()));
    for text in ["old", "new one"] {
        assert_eq!(put(&folder.join("lib/file"), &Piece::Text(text.into())).unwrap(), text.len().to_string());
        assert_eq!(put(&folder.join("lib/name"), &Piece::Link("file".into())).unwrap(), "-> file");
    }
    assert_eq!(fs::read_to_string(folder.join("lib/name")).unwrap(), "new one");
    assert_eq!(entries(&folder.join("lib")).unwrap().len(), 2, "nothing is left beside them");
    fs::remove_dir_all(&folder).unwrap();
}
