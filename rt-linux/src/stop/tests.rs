use nix::sys::signal::{SigHandler, Signal, raise};

use super::{StopSignals, held};
use crate::bell::Woken;
use crate::clock::now_ns;

/// One test, because the handlers belong to the whole process.
#[test]
fn a_signal_rings_the_bell_and_the_previous_handler_comes_back() {
    let signals = StopSignals::install().expect("nothing forbids it");
    assert_eq!(signals.requested(), None);
    for signal in [Signal::SIGTERM, Signal::SIGINT, Signal::SIGINT] {
        raise(signal).expect("to this thread");
        assert_eq!(signals.bell().wait(Some(now_ns() + 5_000_000_000), 0), Woken::Rung);
        assert_eq!(signals.requested(), Some(signal));
    }
    // A shell starts background jobs with SIGINT ignored, so "before" is not always the default.
    let before = were_ignored();

    let inner = StopSignals::install().expect("they nest");
    assert_eq!(inner.requested(), Some(Signal::SIGINT), "what came before is known inside");
    drop(inner);
    // Would end this process if the inner one had put back what was there before the outer one.
    raise(Signal::SIGTERM).expect("to this thread");
    assert_eq!(signals.requested(), Some(Signal::SIGTERM));
    drop(signals);

    let again = StopSignals::install().expect("nothing forbids it");
    assert_eq!(again.requested(), None, "an old signal does not stop a new run");
    assert_eq!(were_ignored(), before);

    let later = StopSignals::install().expect("they nest");
    drop(again);
    raise(Signal::SIGINT).expect("to this thread");
    assert_eq!(later.requested(), Some(Signal::SIGINT), "the order of dropping does not matter");
    drop(later);
    assert!(held().previous.is_none());
}

fn were_ignored() -> [bool; 2] {
    let previous = held().previous.expect("somebody holds the handlers");
    previous.map(|(_, previous)| matches!(previous.handler(), SigHandler::SigIgn))
}
