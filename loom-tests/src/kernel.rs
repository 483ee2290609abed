//! The kernel as the models see it: futex, clock and signals.
//!
//! The kernel compares and enqueues under the lock of the word's bucket, and wakes under the same. Here one lock
//! serves all words. Time goes on by one at each look at the clock, and wherever a model advances it.

use crate::primitive::{AtomicU32, Ordering};
use loom::sync::{Mutex, MutexGuard};
use loom::thread::{self, Thread};

loom::lazy_static! {
    static ref KERNEL: Mutex<State> = Mutex::new(State::default());
}

#[derive(Default)]
struct State {
    now_ns: u64,
    sleepers: Vec<Sleeper>,
}

/// A thread in `futex_wait`. It is alone on its word, as every bell has one waiter.
struct Sleeper {
    word: usize,
    until: Option<u64>,
    thread: Thread,
    /// Why it sleeps no more.
    end: Option<End>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum End {
    Woken,
    TimedOut,
    Interrupted,
}

/// Sleeps while `word` is `expected`, to an absolute time; whether that time came.
pub fn futex_wait(word: &AtomicU32, expected: u32, until: Option<u64>) -> bool {
    let mut state = kernel();
    // Relaxed: what a waker stored before it took this lock is seen, and no more than that is known.
    if word.load(Ordering::Relaxed) != expected {
        return false;
    }
    if until.is_some_and(|until| until <= state.now_ns) {
        return true;
    }
    let word = address(word);
    assert!(state.sleepers.iter().all(|sleeper| sleeper.word != word), "a bell has one waiter");
    state.sleepers.push(Sleeper { word, until, thread: thread::current(), end: None });
    loop {
        // Parked without the lock: where the checker finds that nobody goes on, nothing is left to be unlocked.
        drop(state);
        thread::park();
        state = kernel();
        let mine = state.sleepers.iter().position(|s| s.word == word).expect("it sleeps until it leaves");
        if let Some(end) = state.sleepers[mine].end {
            state.sleepers.swap_remove(mine);
            return end == End::TimedOut;
        }
    }
}

/// Wakes the thread that sleeps on `word`.
pub fn futex_wake(word: &AtomicU32) {
    let word = address(word);
    end_sleeps(End::Woken, &mut kernel(), |sleeper, _| sleeper.word == word);
}

/// The clock.
pub fn now_ns() -> u64 {
    let mut state = kernel();
    state.now_ns += 1;
    state.now_ns
}

/// The clock goes on to `now_ns`; sleepers whose time that is time out.
pub fn advance(now_ns: u64) {
    let mut state = kernel();
    state.now_ns = state.now_ns.max(now_ns);
    end_sleeps(End::TimedOut, &mut state, |sleeper, now| sleeper.until.is_some_and(|until| until <= now));
}

/// A signal comes to everybody who sleeps: the sleep ends without a wake-up, as it may at any time.
pub fn interrupt() {
    end_sleeps(End::Interrupted, &mut kernel(), |_, _| true);
}

fn end_sleeps(end: End, state: &mut State, which: impl Fn(&Sleeper, u64) -> bool) {
    let now = state.now_ns;
    for sleeper in state.sleepers.iter_mut().filter(|sleeper| sleeper.end.is_none()) {
        if which(sleeper, now) {
            sleeper.end = Some(end);
            sleeper.thread.unpark();
        }
    }
}

fn kernel() -> MutexGuard<'static, State> {
    KERNEL.lock().expect("nobody panics here")
}

fn address(word: &AtomicU32) -> usize {
    std::ptr::from_ref(word) as usize
}
