//! *Claim.* Who is inside a gate finds what its opener put there, and who closed it and found nobody inside may take that
//! away; of several that close it, one did.
//!
//! *Threads.* Who opens and closes, and a user; two users and who closes; two that close.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `sync/src/gate.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::thread;
use red_loom_tests::gate::Gate;
use red_loom_tests::model::explore;
use std::sync::Arc;

/// A gate, and what is behind it.
struct Place {
    gate: Gate,
    object: UnsafeCell<Option<u32>>,
}

// SAFETY: that nobody looks while somebody changes the object is what is checked.
unsafe impl Sync for Place {}

impl Place {
    fn new() -> Arc<Self> {
        Arc::new(Self { gate: Gate::closed(), object: UnsafeCell::new(None) })
    }

    fn set(&self, object: Option<u32>) {
        // SAFETY: nobody is inside, which is what is checked.
        self.object.with_mut(|place| unsafe { *place = object });
    }

    fn open(&self, object: u32) {
        self.set(Some(object));
        self.gate.open();
    }

    /// Looks at the object if that is permitted; `asks` is false for one that does not ask.
    fn look(&self, asks: bool) {
        let inside = self.gate.enter();
        if inside.is_some() || !asks {
            // SAFETY: whoever is inside may look, which is what is checked.
            assert_eq!(self.object.with(|object| unsafe { *object }), Some(7), "it is not there");
        }
    }

    /// Takes the object away; `waits` is false for one that does not wait until all have left.
    fn close(&self, waits: bool) -> bool {
        let closed = self.gate.close();
        if closed {
            while waits && self.gate.inside() > 0 {
                thread::yield_now();
            }
            self.set(None);
        }
        closed
    }
}

fn user(place: &Arc<Place>, asks: bool) -> thread::JoinHandle<()> {
    let place = place.clone();
    thread::spawn(move || place.look(asks))
}

fn is_there(waits: bool, asks: bool) {
    let place = Place::new();
    let user = user(&place, asks);
    place.open(7);
    assert!(place.close(waits));
    user.join().unwrap();
    assert_eq!(place.gate.inside(), 0, "somebody is counted who left");
}

#[test]
fn who_is_inside_finds_the_object() {
    explore(2, || is_there(true, true));
}

#[test]
fn the_object_outlives_all_that_are_inside() {
    explore(3, || {
        let place = Place::new();
        place.open(7);
        let users = [user(&place, true), user(&place, true)];
        assert!(place.close(true));
        users.into_iter().for_each(|user| user.join().unwrap());
    });
}

#[test]
fn one_closes_it() {
    explore(2, || {
        let place = Place::new();
        place.open(7);
        let other = {
            let place = place.clone();
            thread::spawn(move || place.close(true))
        };
        assert!(place.close(true) != other.join().unwrap(), "two closed it, or none");
    });
}

#[test]
#[should_panic(expected = "Causality violation")]
fn one_that_does_not_wait_is_caught() {
    explore(2, || is_there(false, true));
}

#[test]
#[should_panic(expected = "Causality violation")]
fn one_that_does_not_ask_is_caught() {
    explore(2, || is_there(true, false));
}
