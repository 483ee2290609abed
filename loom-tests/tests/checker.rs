//! *Claim.* The checker tries what it has to: a load too many hides no execution, and time, futex and stale loads are as
//! the models take them to be.
//!
//! *Threads.* Two.
//! *Bound.* None.
//! *Sources.* none
#![cfg(loom)]

use loom::sync::atomic::Ordering;
use loom::thread;
use red_loom_tests::atomics::AtomicU32;
use red_loom_tests::model::explore;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex};

/// What two threads that each store in one word and load the other may see.
fn outcomes(loads_too_much: bool, order: Ordering) -> BTreeSet<(u32, u32)> {
    let seen = Arc::new(Mutex::new(BTreeSet::new()));
    let told = seen.clone();
    explore(2, move || {
        let words = Arc::new([AtomicU32::new(0), AtomicU32::new(0)]);
        let meet = move |words: &[AtomicU32; 2], mine: usize| {
            if loads_too_much {
                words[mine].load(Ordering::Relaxed);
            }
            words[mine].store(1, order);
            words[1 - mine].load(order)
        };
        let other = {
            let words = words.clone();
            thread::spawn(move || meet(&words, 1))
        };
        let mine = meet(&words, 0);
        told.lock().unwrap().insert((mine, other.join().unwrap()));
    });
    let seen = seen.lock().unwrap();
    seen.clone()
}

#[test]
fn a_load_too_many_hides_no_execution() {
    // All four: the last is what a store buffer does.
    let all = BTreeSet::from([(0, 0), (0, 1), (1, 0), (1, 1)]);
    assert_eq!(outcomes(false, Ordering::Relaxed), all);
    assert_eq!(outcomes(true, Ordering::Relaxed), all);
}
