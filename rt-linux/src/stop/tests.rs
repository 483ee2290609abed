use nix::errno::Errno;
use nix::sys::signal::{SigHandler, Signal, raise};

use super::StopSignals;
use crate::bell::Woken;
use crate::clock::now_ns;
use crate::setup::SetupError;

/// One test, because the handlers belong to the whole process.
#[test]
fn a_signal_rings_the_bell_and_the_previous_handler_comes_back() {
    let signals = StopSignals::install().expect("nobody else in this process catches signals");
    assert_eq!(signals.requested(), None);
    assert!(matches!(StopSignals::install(), Err(SetupError::System { errno: Errno::EBUSY, .. })));
    for signal in [Signal::SIGTERM, Signal::SIGINT, Signal::SIGINT] {
        raise(signal).expect("to this thread");
        assert_eq!(signals.bell().wait(Some(now_ns() + 5_000_000_000), 0), Woken::Rung);
        assert_eq!(signals.requested(), Some(signal));
    }
    // A shell starts background jobs with SIGINT ignored, so "before" is not always the default.
    let before = are_ignored(&signals);
    drop(signals);

    let again = StopSignals::install().expect("the first was dropped");
    assert_eq!(again.requested(), None, "an old signal does not stop a new run");
    assert_eq!(are_ignored(&again), before);
}

fn are_ignored(signals: &StopSignals) -> [bool; 2] {
    signals.previous.map(|(_, previous)| matches!(previous.handler(), SigHandler::SigIgn))
}
