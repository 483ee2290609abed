use super::*;
use std::os::unix::fs::symlink;

/// A folder of this name for one test, empty.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("redrt-place-{name}-{}", std::process::id()));
    let _none_there = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a writable temporary folder");
    folder
}

/// What a place is refused with.
fn refusal(places: &mut Places, path: &Path) -> String {
    match places.add("page", "--out", path) {
        Err(Failure::Input(message)) => message,
        other => panic!("{}: {other:?}", path.display()),
    }
}

#[test]
fn an_input_is_no_output_by_any_name_and_force_changes_nothing() {
    let folder = folder("input");
    let [input, soft, hard] = ["input", "soft", "hard"].map(|name| folder.join(name));
    fs::write(&input, "mine").unwrap();
    symlink("input", &soft).unwrap();
    fs::hard_link(&input, &hard).unwrap();
    let about = folder.join("../").join(folder.file_name().unwrap()).join("input");
    for force in [false, true] {
        let mut places = Places::new(&Force { force }, Failure::Machine).but("log", &input);
        for path in [&input, &soft, &hard, &about] {
            assert!(refusal(&mut places, path).contains("is the log itself"));
        }
        // One that is missing is none either.
        let missing = folder.join("missing");
        let mut places = Places::new(&Force { force }, Failure::Machine).but("log", &missing);
        assert!(refusal(&mut places, &missing).contains("is the log itself"));
    }
    assert_eq!(fs::read_to_string(&input).unwrap(), "mine");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn two_outputs_have_two_places() {
    let folder = folder("two");
    let mut places = Places::new(&Force { force: true }, Failure::Machine);
    places.add("trace", "--trace", &folder.join("one")).unwrap();
    let told = refusal(&mut places, &folder.join("./one"));
    assert!(told.contains("--trace") && told.contains("--out") && told.contains("are one file"), "{told}");
    for stream in ["/dev/null", "/dev/null"] {
        places.add("page", "--out", Path::new(stream)).unwrap();
    }
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_is_there_stays_unless_it_may_be_replaced() {
    let folder = folder("there");
    let [old, nowhere, kept, link] = ["old", "nowhere", "kept", "link"].map(|name| folder.join(name));
    fs::write(&old, "mine").unwrap();
    fs::write(&kept, "mine").unwrap();
    symlink("missing", &nowhere).unwrap();
    symlink("kept", &link).unwrap();
    let mut places = Places::new(&Force { force: false }, Failure::Machine);
    for path in [&old, &nowhere, &link] {
        let told = refusal(&mut places, path);
        assert!(
            told.contains("--force") && told.contains("--out") && told.contains("another name"),
            "{told}"
        );
    }
    let mut places = Places::new(&Force { force: true }, Failure::Machine);
    for path in [&old, &nowhere, &link] {
        places.add("page", "--out", path).unwrap().write_text("new").unwrap();
        assert_eq!(fs::read_to_string(path).unwrap(), "new");
    }
    assert_eq!(fs::read_to_string(&kept).unwrap(), "mine", "what a link led to stays");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 4, "nothing is left beside them");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn what_appears_meanwhile_stays_too() {
    let folder = folder("meanwhile");
    let mut places = Places::new(&Force { force: false }, Failure::Machine);
    let page = places.add("page", "--out", &folder.join("page")).unwrap();
    let log = places.add_log("--record", &folder.join("log")).unwrap();
    for place in [&page, &log] {
        fs::write(place.path(), "mine").unwrap();
    }
    assert!(matches!(page.write_text("new"), Err(Failure::Machine(_))));
    assert_eq!(log.create().unwrap_err().kind(), io::ErrorKind::AlreadyExists);
    for place in [&page, &log] {
        assert_eq!(fs::read_to_string(place.path()).unwrap(), "mine");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2, "nothing is left beside them");
    fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn a_place_that_takes_no_file_is_told_before_anything_is_written() {
    let folder = folder("none");
    let mut places = Places::new(&Force { force: true }, Failure::Machine);
    for path in [folder.clone(), folder.join("missing/page"), folder.join("page/")] {
        let told = places.add("page", "--out", &path);
        assert!(
            matches!(&told, Err(Failure::Machine(why)) if why.contains("cannot write the page")),
            "{told:?}"
        );
    }
    assert!(places.add_log("--record", Path::new("/dev/null")).is_err(), "a device is no log");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    fs::remove_dir_all(&folder).unwrap();
}
