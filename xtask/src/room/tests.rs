use super::*;
use crate::steps;
use std::env;
use std::path::Path;

#[test]
fn where_room_is_scarce_a_step_leaves_nothing_of_its_own() {
    let target = env::temp_dir().join(format!("red-room-{}", std::process::id()));
    let (own, others) = (target.join("thread"), target.join("debug"));
    for folder in [&own, &others] {
        fs::create_dir_all(folder).expect("a folder for temporary files");
    }
    let workspace = Workspace { root: target.clone(), target: target.clone() };
    let found = |free| {
        make(&workspace, "sanitizers", free);
        [own.is_dir(), others.is_dir()]
    };
    assert_eq!(found(None), [true, true]);
    assert_eq!(found(Some(SCARCE_MIB)), [true, true]);
    assert_eq!(found(Some(SCARCE_MIB - 1)), [false, true]);
    fs::remove_dir_all(&target).expect("it was made above");
}

#[test]
fn only_steps_leave_something() {
    let names: Vec<&str> = OWN.iter().map(|(name, _)| *name).collect();
    assert!(steps::choose(&names).is_ok(), "{names:?}");
}

#[test]
fn a_disk_tells_how_much_is_free() {
    assert!(free_mib(&Workspace::here()).is_some());
    let nowhere = Path::new("/no such folder").to_path_buf();
    assert_eq!(free_mib(&Workspace { root: nowhere.clone(), target: nowhere }), None);
}
