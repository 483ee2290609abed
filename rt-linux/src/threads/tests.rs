use super::{NOT_UP, Starting};
use nix::unistd::Pid;
use std::sync::mpsc;
use std::time::{Duration, Instant};

#[test]
fn a_spare_that_sets_itself_up_for_too_long_is_not_waited_for() {
    let (told, verdict) = mpsc::channel();
    let (go, is_to_go) = mpsc::channel();
    let (_finished, figures) = mpsc::channel();
    let far = Instant::now() + Duration::from_secs(3_600);
    let mut spare = Starting::<()> { lane: 0, until: far, verdict, id: None, go, figures };
    assert_eq!(spare.verdict(), None);
    spare.until = Instant::now();
    assert_eq!(spare.verdict(), Some(Err(NOT_UP)));
    // One that comes up then finds nobody.
    told.send(Ok(Pid::this())).expect("still there");
    drop(spare);
    assert!(is_to_go.recv().is_err());
}
