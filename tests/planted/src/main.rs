//! Bugs that interpreters and sanitizers have to find, and the same code without them: `race`, `freed`, `looked`, `lent`,
//! `sound`.
#![allow(unsafe_code, reason = "the bugs are of the kind that only unsafe code can have")]

use red_ffi::{
    RED_ALIGN, RED_DAG_4X16X16_BYTES, red_dag, red_dag_close, red_dag_open_4x16x16, red_dag_remove_node,
};
use std::alloc::{Layout, alloc, dealloc};
use std::cell::UnsafeCell;
use std::env;
use std::process::ExitCode;
use std::ptr;
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

/// Frees a number by its address, or by a reference where that is asked, which may only look.
fn free(looked: bool) -> u32 {
    let number = Box::into_raw(Box::new(7));
    // SAFETY: it came from a box.
    let seen: &u32 = unsafe { &*number };
    let value = *seen;
    let at = if looked { ptr::from_ref(seen).cast_mut() } else { number };
    // SAFETY: it came from a box, and is freed once, by whom it belongs to; but for the planted bug, that is.
    drop(unsafe { Box::from_raw(at) });
    value
}

/// Calls the C ABI for a graph whose memory was freed where that is asked.
fn lend(freed: bool) -> u32 {
    let Ok(layout) = Layout::from_size_align(RED_DAG_4X16X16_BYTES, RED_ALIGN) else { return 0 };
    // SAFETY: it is of some size.
    let memory = unsafe { alloc(layout) };
    let give_back = || {
        // SAFETY: it came from there, and is freed once.
        unsafe { dealloc(memory, layout) };
    };
    let mut dag = red_dag::default();
    let opened = red_dag_open_4x16x16(memory.cast(), layout.size(), &raw mut dag);
    if freed {
        give_back();
    }
    let answers = [opened, red_dag_remove_node(&raw mut dag, 0), red_dag_close(&raw mut dag)];
    if !freed {
        give_back();
    }
    answers.into_iter().map(|answer| answer as u32).sum()
}

fn main() -> ExitCode {
    let words: Vec<String> = env::args().skip(1).collect();
    let sum = match words.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["race"] => count(Ordering::Relaxed),
        ["freed"] => read(true),
        ["looked"] => free(true),
        ["lent"] => lend(true),
        ["sound"] => count(Ordering::Release) + read(false) + free(false) + lend(false),
        _ => {
            eprintln!("usage: red-planted race|freed|looked|lent|sound");
            return ExitCode::from(2);
        }
    };
    println!("{sum}");
    ExitCode::SUCCESS
}
