use super::Sleeper;
use crate::bell::{Bell, Woken};
use crate::clock::now_ns;

#[test]
fn a_sleep_never_ends_before_its_time() {
    for mut sleeper in [Sleeper::spinning(), Sleeper::yielding()] {
        for _ in 0..20 {
            let at = now_ns() + 300_000;
            sleeper.sleep_until(at);
            assert!(now_ns() >= at);
        }
    }
}

#[test]
fn a_time_in_the_past_returns_at_once_and_says_how_late() {
    let at = now_ns() - 1_000_000;
    assert!(Sleeper::spinning().sleep_until(at) >= 1_000_000);
    assert!(Sleeper::yielding().sleep_until(at) >= 1_000_000);
}

#[test]
fn a_ring_ends_the_wait_with_and_without_a_time() {
    for mut sleeper in [Sleeper::spinning(), Sleeper::yielding()] {
        let bell = Bell::new();
        for until in [None, Some(u64::MAX), Some(0)] {
            bell.ring();
            assert_eq!(sleeper.wait(&bell, || false, until, 1_000), Woken::Rung);
        }
    }
}

#[test]
fn only_the_spinning_sleeper_has_a_lead() {
    assert!(Sleeper::spinning().lead_ns() > 0);
    assert_eq!(Sleeper::yielding().lead_ns(), 0);
}
