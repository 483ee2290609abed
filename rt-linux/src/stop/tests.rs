use nix::errno::Errno;
use nix::sys::signal::{SigAction, SigHandler, Signal, raise};

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
    drop(signals);

    let again = StopSignals::install().expect("the first was dropped");
    assert_eq!(again.requested(), None, "an old signal does not stop a new run");
    let is_default = |previous: &SigAction| matches!(previous.handler(), SigHandler::SigDfl);
    assert!(again.previous.iter().all(|(_, previous)| is_default(previous)));
}
