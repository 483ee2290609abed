//! *Claim.* One thread at a time is inside the ticket lock, it sees all that the one before it wrote, and who has
//! drawn a ticket is inside before everybody who draws later.
//!
//! *Threads.* Two, each as often as twice; alone three, once each.
//! *Bound.* None for two; one preemption for three, because three spinners do not end otherwise.
//! *Sources.* `sync/src/ticket_lock.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use loom::thread;
use red_loom_tests::Exclusive;
use red_loom_tests::model::{explore, explore_within};
use red_loom_tests::ticket_lock::TicketLock;
use std::sync::Arc;

/// What the claims are about: a lock that tells how many came.
trait Lock<T>: Exclusive<T> + Send + Sync + 'static {
    fn drawn(&self) -> u32;
}

impl<T: Send + 'static> Lock<T> for TicketLock<T> {
    fn drawn(&self) -> u32 {
        Self::drawn(self)
    }
}

/// Every thread adds one, `times` times; the checker's cell sees two inside at once, and a write that is missed.
fn excludes<L: Lock<u32>>(threads: u32, times: u32) {
    let lock = Arc::new(L::new(0));
    let add = move |lock: &L| (0..times).for_each(|_| lock.with(|n| *n += 1));
    let others: Vec<_> = (1..threads)
        .map(|_| {
            let lock = lock.clone();
            thread::spawn(move || add(&lock))
        })
        .collect();
    add(&lock);
    others.into_iter().for_each(|other| other.join().unwrap());
    assert_eq!(lock.with(|n| *n), threads * times);
}

/// Who holds the lock sees another come, leaves, and comes again: the other is first.
fn serves_in_order<L: Lock<Vec<u8>>>() {
    let lock = Arc::new(L::new(Vec::new()));
    let other = {
        let lock = lock.clone();
        thread::spawn(move || lock.with(|order| order.push(b'b')))
    };
    let mut saw_it_come = false;
    lock.with(|order| {
        order.push(b'a');
        saw_it_come = order.len() == 1 && lock.drawn() == 2;
    });
    lock.with(|order| order.push(b'c'));
    other.join().unwrap();
    lock.with(|order| {
        assert_eq!(order.len(), 3, "everybody was inside");
        assert!(!saw_it_come || order == b"abc", "the later ticket was served first");
    });
}

#[test]
fn two_threads_exclude_each_other() {
    explore(2, || excludes::<TicketLock<_>>(2, 2));
}

#[test]
fn three_threads_exclude_each_other() {
    explore_within(3, Some(1), || excludes::<TicketLock<_>>(3, 1));
}

#[test]
fn tickets_are_served_in_their_order() {
    explore(2, serves_in_order::<TicketLock<_>>);
}

/// A lock with planted faults: `SEES` what the holder before wrote, or not; fair it is never.
struct Planted<T, const SEES: bool> {
    taken: AtomicBool,
    drawn: AtomicU32,
    value: UnsafeCell<T>,
}

// SAFETY: as much as a lock with planted faults is.
unsafe impl<T: Send, const SEES: bool> Sync for Planted<T, SEES> {}
// SAFETY: the value goes with it.
unsafe impl<T: Send, const SEES: bool> Send for Planted<T, SEES> {}

impl<T, const SEES: bool> Exclusive<T> for Planted<T, SEES> {
    fn new(value: T) -> Self {
        Self { taken: AtomicBool::new(false), drawn: AtomicU32::new(0), value: UnsafeCell::new(value) }
    }

    fn with<R>(&self, f: impl FnOnce(&mut T) -> R) -> R {
        self.drawn.fetch_add(1, Ordering::Relaxed);
        while self.taken.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).is_err() {
            thread::yield_now();
        }
        // SAFETY: the checker says when this is not alone.
        let result = self.value.with_mut(|value| f(unsafe { &mut *value }));
        self.taken.store(false, if SEES { Ordering::Release } else { Ordering::Relaxed });
        result
    }
}

impl<T: Send + 'static, const SEES: bool> Lock<T> for Planted<T, SEES> {
    fn drawn(&self) -> u32 {
        self.drawn.load(Ordering::Relaxed)
    }
}

#[test]
#[should_panic(expected = "Causality violation")]
fn a_lock_that_unlocks_relaxed_is_caught() {
    explore(2, || excludes::<Planted<_, false>>(2, 1));
}

#[test]
#[should_panic(expected = "the later ticket was served first")]
fn a_lock_that_is_not_fair_is_caught() {
    explore(2, serves_in_order::<Planted<_, true>>);
}
