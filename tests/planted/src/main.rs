//! Bugs that interpreters and sanitizers have to find, and the same code without them: `race`, `freed`, `sound`.
#![allow(unsafe_code, reason = "the bugs are of the kind that only unsafe code can have")]

use std::cell::UnsafeCell;
use std::env;
use std::process::ExitCode;
use std::sync::Barrier;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Fewer under an interpreter.
const ROUNDS: u32 = if cfg!(miri) { 20 } else { 20_000 };

struct Lock {
    taken: AtomicBool,
    value: UnsafeCell<u32>,
}

// SAFETY: only who took the lock reaches the value; but for the planted bug, that is.
unsafe impl Sync for Lock {}

impl Lock {
    /// Adds one; `release` is what the lock is given back with.
    fn increment(&self, release: Ordering) {
        // Acquire: pairs with the Release below, where it is one.
        while self.taken.compare_exchange(false, true, Ordering::Acquire, Ordering::Relaxed).is_err() {
            thread::yield_now();
        }
        let value = self.value.get();
        // SAFETY: the lock is ours.
        unsafe { *value += 1 };
        self.taken.store(false, release);
    }
}

/// Two threads add up what a lock holds.
fn count(release: Ordering) -> u32 {
    let lock = Lock { taken: AtomicBool::new(false), value: UnsafeCell::new(0) };
    let start = Barrier::new(2);
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                start.wait();
                (0..ROUNDS).for_each(|_| lock.increment(release));
            });
        }
    });
    lock.value.into_inner()
}

/// Reads a number, after it was freed where that is asked.
fn read(freed: bool) -> u32 {
    let number = Box::into_raw(Box::new(7));
    let free = || {
        // SAFETY: it came from a box, and is freed once.
        drop(unsafe { Box::from_raw(number) });
    };
    if freed {
        free();
    }
    // SAFETY: it was not freed; but for the planted bug, that is.
    let seen = unsafe { number.read_volatile() };
    if !freed {
        free();
    }
    seen
}

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let sum = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["race"] => count(Ordering::Relaxed),
        ["freed"] => read(true),
        ["sound"] => count(Ordering::Release) + read(false),
        _ => {
            eprintln!("usage: red-planted race|freed|sound");
            return ExitCode::from(2);
        }
    };
    println!("{sum}");
    ExitCode::SUCCESS
}
