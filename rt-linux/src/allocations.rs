#![allow(unsafe_code, reason = "an allocator is an unsafe trait to implement")]
//! Counts heap calls where there must be none.
//!
//! A program makes [`CountingAllocator`] its global allocator; lanes arm their thread while they schedule and
//! disarm it while a node body runs, because bodies may allocate and the scheduler may not.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

static COUNTED: AtomicU64 = AtomicU64::new(0);

thread_local! {
    static ARMED: Cell<bool> = const { Cell::new(false) };
}

/// The system's allocator, with a count of the calls that armed threads make.
#[derive(Clone, Copy, Debug, Default)]
pub struct CountingAllocator;

/// Arms the calling thread, or disarms it.
pub fn arm(on: bool) {
    ARMED.with(|armed| armed.set(on));
}

/// Heap calls of armed threads since the process started.
#[must_use]
pub fn counted() -> u64 {
    COUNTED.load(Ordering::Relaxed)
}

fn count() {
    // A thread that ends has no flag any more and is not armed.
    if ARMED.try_with(Cell::get).unwrap_or(false) {
        COUNTED.fetch_add(1, Ordering::Relaxed);
    }
}

// SAFETY: every call is passed to the system's allocator unchanged.
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        // SAFETY: the caller's contract is the same.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        count();
        // SAFETY: the caller's contract is the same.
        unsafe { System.dealloc(block, layout) }
    }

    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        // SAFETY: the caller's contract is the same.
        unsafe { System.realloc(block, layout, size) }
    }
}
