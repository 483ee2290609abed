//! *Claim.* No wake-up of a bell is lost, whether it is a ring or a condition and `wake`, by one thread or two, against
//! a time-out or a signal; and what was written before a ring is seen after it.
//!
//! *Threads.* A waiter and a ringer; then another ringer, the clock, or signals.
//! *Bound.* None for two; two preemptions for three threads, three with `--deep`.
//! *Sources.* `rt-linux/src/bell.rs`
#![cfg(loom)]

use loom::cell::UnsafeCell;
use loom::sync::atomic::Ordering;
use loom::thread;
use red_loom_tests::atomics::AtomicU32;
use red_loom_tests::bell::{Bell, Woken};
use red_loom_tests::kernel::{self, futex_wait, futex_wake};
use red_loom_tests::model::explore;
use std::sync::Arc;

/// What the claims are about.
trait Rings: Send + Sync + 'static {
    fn new() -> Self;
    fn ring(&self);
    fn wake(&self);
    fn wait_for(&self, ready: impl Fn() -> bool, until: Option<u64>, spin_ns: u64) -> Woken;

    fn wait_long(&self) {
        assert_eq!(self.wait_for(|| false, None, 0), Woken::Rung);
    }

    /// Whether there is a ring now.
    fn is_rung(&self) -> bool {
        self.wait_for(|| false, Some(0), 0) == Woken::Rung
    }
}

impl Rings for Bell {
    fn new() -> Self {
        Self::new()
    }

    fn ring(&self) {
        self.ring();
    }

    fn wake(&self) {
        self.wake();
    }

    fn wait_for(&self, ready: impl Fn() -> bool, until: Option<u64>, spin_ns: u64) -> Woken {
        self.wait_for(ready, until, spin_ns)
    }
}

/// A bell, and what two threads write before they ring it.
struct Shared<B> {
    bell: B,
    news: [UnsafeCell<u32>; 2],
    condition: AtomicU32,
}

// SAFETY: the checker says when news is reached by two at once.
unsafe impl<B: Sync> Sync for Shared<B> {}
// SAFETY: the news goes with it.
unsafe impl<B: Send> Send for Shared<B> {}

fn shared<B: Rings>() -> Arc<Shared<B>> {
    let news = [UnsafeCell::new(0), UnsafeCell::new(0)];
    Arc::new(Shared { bell: B::new(), news, condition: AtomicU32::new(0) })
}

impl<B: Rings> Shared<B> {
    fn write(&self, number: usize) {
        // SAFETY: nobody else writes it, and nobody reads it before the ring.
        self.news[number].with_mut(|news| unsafe { *news = 1 });
    }

    fn read(&self, number: usize) -> u32 {
        // SAFETY: after the ring.
        self.news[number].with(|news| unsafe { *news })
    }
}

/// Starts a thread.
fn start<B: Rings>(shared: &Arc<Shared<B>>, body: fn(&Shared<B>)) -> thread::JoinHandle<()> {
    let shared = shared.clone();
    thread::spawn(move || body(&shared))
}

fn a_ring_wakes<B: Rings>() {
    let shared = shared::<B>();
    let ringer = start(&shared, |shared| {
        shared.write(0);
        shared.bell.ring();
        shared.write(1);
        shared.bell.ring();
    });
    shared.bell.wait_long();
    assert_eq!(shared.read(0), 1);
    ringer.join().unwrap();
    shared.bell.is_rung();
    assert!(!shared.bell.is_rung(), "a ring came twice");
}

#[test]
fn a_ring_wakes_the_waiter_and_brings_its_news() {
    explore(2, a_ring_wakes::<Bell>);
}

/// As a seat: the condition is a word of its own, and both sides come again.
fn a_condition_wakes<B: Rings>(spin_ns: u64) {
    let shared = shared::<B>();
    let writer = start(&shared, |shared| {
        for now in 1..=2 {
            shared.condition.store(now, Ordering::Release);
            shared.bell.wake();
        }
    });
    let woken = shared.bell.wait_for(|| shared.condition.load(Ordering::Relaxed) == 2, None, spin_ns);
    assert_eq!(woken, Woken::Rung);
    // A ring from before the condition held may have ended the wait; one that comes with it ends the next one.
    while shared.condition.load(Ordering::Relaxed) != 2 {
        let woken = shared.bell.wait_for(|| shared.condition.load(Ordering::Relaxed) == 2, None, spin_ns);
        assert_eq!(woken, Woken::Rung);
    }
    writer.join().unwrap();
}

#[test]
fn a_condition_and_a_wake_end_the_wait() {
    explore(2, || a_condition_wakes::<Bell>(0));
}

#[test]
fn a_condition_ends_the_wait_at_the_border_of_spin_and_sleep() {
    explore(2, || a_condition_wakes::<Bell>(2));
}

#[test]
fn two_ringers_wake_the_waiter_and_bring_their_news() {
    explore(3, || {
        let shared = shared::<Bell>();
        let ring = |shared: &Shared<Bell>, number: usize| {
            shared.write(number);
            shared.bell.ring();
            shared.condition.fetch_or(1 << number, Ordering::Relaxed);
        };
        let [one, two] = [0, 1].map(|number| {
            let shared = shared.clone();
            thread::spawn(move || ring(&shared, number))
        });
        shared.bell.wait_long();
        // When both have rung, what is left is taken, and with it the news of both.
        while shared.condition.load(Ordering::Relaxed) != 3 {
            thread::yield_now();
        }
        shared.bell.is_rung();
        assert_eq!((shared.read(0), shared.read(1)), (1, 1));
        one.join().unwrap();
        two.join().unwrap();
    });
}

#[test]
fn a_time_out_swallows_no_ring() {
    explore(3, || {
        let shared = shared::<Bell>();
        let ringer = start(&shared, |shared| {
            shared.write(0);
            shared.bell.ring();
        });
        let clock = start(&shared, |_| kernel::advance(5));
        if shared.bell.wait_for(|| false, Some(5), 0) == Woken::TimedOut {
            shared.bell.wait_long();
        }
        assert_eq!(shared.read(0), 1);
        ringer.join().unwrap();
        clock.join().unwrap();
    });
}

#[test]
fn a_signal_is_no_wake_up_and_swallows_none() {
    explore(3, || {
        let shared = shared::<Bell>();
        let ringer = start(&shared, |shared| {
            shared.write(0);
            shared.condition.store(1, Ordering::Release);
            shared.bell.ring();
        });
        let signals = start(&shared, |_| kernel::interrupt());
        shared.bell.wait_long();
        assert_eq!(shared.read(0), 1);
        ringer.join().unwrap();
        signals.join().unwrap();
    });
}

/// A bell with a planted fault: its waiter goes to sleep without another look, at the ring or at the condition.
struct Planted<const LOOKS_AT_RING: bool> {
    state: AtomicU32,
}

const QUIET: u32 = 0;
const RUNG: u32 = 1;
const ASLEEP: u32 = 2;

impl<const LOOKS_AT_RING: bool> Rings for Planted<LOOKS_AT_RING> {
    fn new() -> Self {
        Self { state: AtomicU32::new(QUIET) }
    }

    fn ring(&self) {
        if self.state.swap(RUNG, Ordering::AcqRel) == ASLEEP {
            futex_wake(&self.state);
        }
    }

    fn wake(&self) {
        if self.state.fetch_or(0, Ordering::AcqRel) == ASLEEP {
            self.ring();
        }
    }

    fn wait_for(&self, ready: impl Fn() -> bool, until: Option<u64>, _spin_ns: u64) -> Woken {
        loop {
            if self.state.swap(QUIET, Ordering::AcqRel) == RUNG || ready() {
                return Woken::Rung;
            }
            let sleeps = if LOOKS_AT_RING {
                self.state.compare_exchange(QUIET, ASLEEP, Ordering::AcqRel, Ordering::Relaxed).is_ok()
            } else {
                self.state.store(ASLEEP, Ordering::Release);
                true
            };
            if sleeps && futex_wait(&self.state, ASLEEP, until) {
                return Woken::TimedOut;
            }
        }
    }
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_bell_that_forgets_to_look_at_the_ring_is_caught() {
    explore(2, a_ring_wakes::<Planted<false>>);
}

#[test]
#[should_panic(expected = "deadlock")]
fn a_bell_that_forgets_to_look_at_the_condition_is_caught() {
    explore(2, || a_condition_wakes::<Planted<true>>(0));
}
