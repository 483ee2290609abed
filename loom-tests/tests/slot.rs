//! *Claim.* A body that returns and a watchdog that finds it too late agree: the bound is kept and nothing happened, or
//! it has passed, the watchdog saw the right thread, and it is done with the thread when the body's lane goes on.
//!
//! *Threads.* The lane and the watchdog.
//! *Bound.* None.
//! *Sources.* `rt-linux/src/slot.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::thread;
use red_loom_tests::model::explore;
use red_loom_tests::slot::{Bound, Slot};
use std::sync::Arc;

const THREAD: i32 = 7;
const DEADLINE: u64 = 5;

struct Shared {
    slot: Slot,
    /// The thread's policy, which the watchdog changes first and the thread afterwards.
    policy: UnsafeCell<u32>,
}

// SAFETY: the checker says when the policy is reached by two at once.
unsafe impl Sync for Shared {}
// SAFETY: the policy goes with it.
unsafe impl Send for Shared {}

/// Two bodies one after the other; the watchdog looks once. `waits` is false for a lane that does not wait for the
/// watchdog to be done.
fn agree(waits: bool) {
    let shared = Arc::new(Shared { slot: Slot::new(), policy: UnsafeCell::new(0) });
    let watchdog = {
        let shared = shared.clone();
        thread::spawn(move || {
            let Some(deadline) = shared.slot.deadline() else { return false };
            assert_eq!(deadline, DEADLINE);
            let claimed = shared.slot.claim(deadline);
            if claimed {
                shared.slot.expire(|thread| {
                    assert_eq!(thread, Some(THREAD), "the wrong thread");
                    // SAFETY: the thread waits until this is over.
                    shared.policy.with_mut(|policy| unsafe { *policy = 1 });
                });
            }
            claimed
        })
    };
    shared.slot.adopt_thread(THREAD);
    let mut passed = 0;
    for _ in 0..2 {
        let armed = shared.slot.arm(DEADLINE);
        let found = shared.slot.has_passed();
        if !waits && found {
            // SAFETY: planted; the checker says that it is not.
            shared.policy.with_mut(|policy| unsafe { *policy = 0 });
        }
        if shared.slot.disarm(armed) == Bound::Passed {
            passed += 1;
            // SAFETY: the watchdog is done.
            shared.policy.with_mut(|policy| unsafe { *policy = 0 });
        } else {
            assert!(!found, "the bound had passed");
        }
    }
    let claimed = watchdog.join().unwrap();
    assert_eq!(passed, u32::from(claimed), "a bound that passed is told once");
    assert!(shared.slot.deadline().is_none());
}

#[test]
fn lane_and_watchdog_agree() {
    explore(2, || agree(true));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_lane_that_does_not_wait_for_the_watchdog_is_caught() {
    explore(2, || agree(false));
}
